#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <string_view>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "io/read/input_file.hpp"
#include "io/text/text.hpp"
#include "lamella/medical/labels.hpp"
#include "medical/geometry/common.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t most_label_table_bytes = std::uint64_t{16} << 20;
constexpr std::array<std::string_view, 7> label_columns = {"label", "name", "color", "category", "type", "region", "voxels"};

/// The rows of a CSV file, one after another.
class CsvRows {
public:
    CsvRows(std::string name, std::string_view text) : name_(std::move(name)), text_(text) {
        at_ = text_.starts_with("\xef\xbb\xbf") ? 3 : 0;  // what some programs begin UTF-8 with
    }

    /// False at the end of the file. Between quotes stand commas, line ends, and quotes, each twice. Empty lines are passed
    /// over.
    bool next(std::vector<std::string>& cells) {
        for (cells.clear(); cells.empty() && at_ < text_.size(); ++at_) {
            row_ = at_;
            cells.emplace_back();
            bool quoted = false;
            for (; at_ < text_.size() && (quoted || text_[at_] != '\n'); ++at_) {
                const char c = text_[at_];
                if (c == '"' && !(quoted && text_.substr(at_ + 1, 1) == "\"")) {
                    quoted = !quoted;
                } else if (c == ',' && !quoted) {
                    cells.emplace_back();
                } else {
                    cells.back() += c;
                    at_ += c == '"' ? 1 : 0;
                }
            }
            if (quoted) {
                refuse("a quote without its end");
            }
            std::for_each(cells.begin(), cells.end(), [](std::string& cell) { cell = std::string(trimmed(cell)); });
            if (cells.size() == 1 && cells[0].empty()) {
                cells.clear();
            }
        }
        return !cells.empty();
    }

    /// Throws Refused, "FILE:LINE: WHAT".
    [[noreturn]] void refuse(const std::string& what) const {
        refuse_image(name_ + ":" + std::to_string(line_of(text_, row_)), what);
    }

private:
    std::string name_;
    std::string_view text_;
    std::size_t at_ = 0;
    std::size_t row_ = 0;  ///< where the row begins
};

std::array<std::uint8_t, 3> colour_in(const CsvRows& rows, const std::string& text) {
    std::uint32_t number = 0;
    const char* const end = text.data() + text.size();
    if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, number, 16).ptr != end) {
        rows.refuse("the color " + in_quotes(text) + " is not written as #rrggbb");
    }
    return {static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8 & 0xff),
            static_cast<std::uint8_t>(number & 0xff)};
}

/// What separates codes in DICOM and in 3D Slicer's files is in none.
Code code_in(const CsvRows& rows, std::string_view column, const std::string& text) {
    const std::size_t first = text.find('^');
    const std::size_t second = first == text.npos ? text.npos : text.find('^', first + 1);
    const auto part = [&](std::size_t begin, std::size_t end) {
        return second == text.npos ? std::string() : text.substr(begin, end - begin);
    };
    Code code{part(0, first), part(first + 1, second), part(second + 1, text.npos)};
    const auto fits = [](const std::string& of, std::size_t most) { return !of.empty() && of.size() <= most; };
    const bool clean =
        std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == '\\' || c == '~' || c == '|'; });
    if (!clean || !fits(code.scheme, 16) || !fits(code.value, 16) || !fits(code.meaning, 64) ||
        code.meaning.find('^') != text.npos) {
        rows.refuse("the " + std::string(column) + " " + in_quotes(text) +
                    " is not scheme^value^meaning, of at most 16, 16 and 64 bytes");
    }
    return code;
}

/// The column of each cell, as an index into label_columns.
std::vector<std::size_t> columns_in(const CsvRows& rows, const std::vector<std::string>& cells) {
    std::vector<std::size_t> columns;
    for (const std::string& cell : cells) {
        const auto* const found = std::find(label_columns.begin(), label_columns.end(), lower_case(cell));
        columns.push_back(static_cast<std::size_t>(found - label_columns.begin()));
        if (found == label_columns.end() || std::count(columns.begin(), columns.end(), columns.back()) > 1) {
            rows.refuse("the column " + in_quotes(cell) + " is not known, or stands there twice; there is " +
                        "label, name, color, category, type, region");
        }
    }
    if (std::find(columns.begin(), columns.end(), 0U) == columns.end()) {
        rows.refuse("no column is called label");
    }
    return columns;
}

LabelRow label_row_of(const CsvRows& rows, const std::vector<std::size_t>& columns, const std::vector<std::string>& cells) {
    LabelRow row;
    if (cells.size() != columns.size()) {
        rows.refuse(std::to_string(cells.size()) + " cells, where the first line has " + std::to_string(columns.size()));
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::string_view column = label_columns[columns[i]];
        if (column == "label" &&
            (!read_integer(std::string_view(cells[i]), row.label) || row.label == 0 || row.label > most_mask_labels)) {
            rows.refuse("the label " + in_quotes(cells[i]) + " is not a number from 1 to 65,535");
        }
        Code* const code = column == "category" ? &row.terms.category
                           : column == "type"   ? &row.terms.type
                           : column == "region" ? &row.terms.region
                                                : nullptr;
        if (column == "name") {
            row.name = cells[i];
        } else if (column == "color" && !cells[i].empty()) {
            row.terms.colour = colour_in(rows, cells[i]);
        } else if (code != nullptr && !cells[i].empty()) {
            *code = code_in(rows, column, cells[i]);
        }
    }
    return row;
}

}  // namespace

std::array<std::uint8_t, 3> SegmentTerms::colour_of(std::size_t index) const noexcept {
    static constexpr std::array<std::array<std::uint8_t, 3>, 6> in_turn = {
        {{230, 77, 51}, {0, 115, 178}, {0, 158, 115}, {230, 158, 0}, {204, 120, 166}, {87, 181, 232}}};
    return colour.value_or(in_turn[index % in_turn.size()]);
}

Result<std::vector<LabelRow>> read_label_table(const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Result<std::vector<LabelRow>> {
        const std::string name = printable(path_text(path));
        const InputFile file = require(InputFile::open(path));
        if (file.size() > most_label_table_bytes) {
            refuse_image(name, "larger than 16 MiB: no table of labels");
        }
        std::string text(static_cast<std::size_t>(file.size()), '\0');
        require(file.read_at(0, std::as_writable_bytes(std::span(text))));
        if (utf8_text(text) != text) {
            refuse_image(name, "not in UTF-8");
        }
        CsvRows rows(name, text);
        std::vector<std::string> cells;
        if (!rows.next(cells)) {
            refuse_image(name, "an empty table of labels");
        }
        const std::vector<std::size_t> columns = columns_in(rows, cells);
        std::vector<LabelRow> found;
        std::set<std::size_t> labels;
        while (rows.next(cells)) {
            found.push_back(label_row_of(rows, columns, cells));
            if (!labels.insert(found.back().label).second) {
                rows.refuse("the label " + std::to_string(found.back().label) + " has a row already");
            }
        }
        return found;
    });
}

}  // namespace lamella
