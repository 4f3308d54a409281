// Tables of CSV as RFC 4180 has it, or with another separator in place of commas.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lamella {

struct CsvRow {
    std::vector<std::string> cells{""};
    std::size_t line = 1;  ///< where the row begins

    /// True if nothing stands in the cells from `begin` on, as in columns at the end that a spreadsheet left empty.
    bool is_empty(std::size_t begin = 0) const {
        return std::all_of(cells.begin() + static_cast<std::ptrdiff_t>(std::min(begin, cells.size())), cells.end(),
                           [](const std::string& cell) { return cell.empty(); });
    }
};

/// The rows but those without a word. Quoted cells may hold separators, quotes ("") and line ends. Where the text is no such
/// table, refuse(line, what) throws.
template <class Refuse>
std::vector<CsvRow> read_csv(std::string_view text, char separator, Refuse refuse) {
    std::vector<CsvRow> rows;
    CsvRow row;
    std::size_t line = 1;
    std::size_t quoted_from = 0;  // the line of a quote that is open; else 0
    bool closed = false;          // the quote of the cell
    const auto end_row = [&] {
        if (!row.is_empty()) {
            rows.push_back(std::move(row));
        }
        row = {{""}, ++line};
    };
    for (std::size_t at = 0; at < text.size(); ++at) {
        const char c = text[at];
        const char next = at + 1 < text.size() ? text[at + 1] : '\0';
        if (quoted_from > 0 && (c != '"' || next == '"')) {
            row.cells.back() += c;
            at += c == '"' ? 1 : 0;
            line += c == '\n' ? 1 : 0;
        } else if (quoted_from > 0) {
            quoted_from = 0;
            closed = true;
        } else if (c == separator || c == '\r' || c == '\n') {
            closed = false;
            at += c == '\r' && next == '\n' ? 1 : 0;
            c == separator ? void(row.cells.emplace_back()) : end_row();
        } else if (closed) {
            refuse(line, "text follows a closing quote");
        } else if (c == '"' && row.cells.back().empty()) {
            quoted_from = line;
        } else {
            row.cells.back() += c;
        }
    }
    if (quoted_from > 0) {
        refuse(quoted_from, "a quote is not closed");
    }
    end_row();
    return rows;
}

}  // namespace lamella
