#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <string_view>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "io/read/input_file.hpp"
#include "io/text/csv.hpp"
#include "io/text/text.hpp"
#include "lamella/medical/labels.hpp"
#include "medical/geometry/common.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t most_label_table_bytes = std::uint64_t{16} << 20;
constexpr std::array<std::string_view, 7> label_columns = {"label", "name", "color", "category", "type", "region", "voxels"};

/// A row of a table, for messages.
struct TableRow {
    const std::string& name;  ///< of the file
    std::size_t line;

    /// Throws Refused, "FILE:LINE: WHAT".
    [[noreturn]] void refuse(const std::string& what) const { refuse_image(name + ":" + std::to_string(line), what); }
};

std::array<std::uint8_t, 3> colour_in(const TableRow& row, std::string_view text) {
    std::uint32_t number = 0;
    const char* const end = text.data() + text.size();
    if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, number, 16).ptr != end) {
        row.refuse("the color " + in_quotes(text) + " is not written as #rrggbb");
    }
    return {static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8 & 0xff),
            static_cast<std::uint8_t>(number & 0xff)};
}

/// What separates codes in DICOM and in 3D Slicer's files is in none.
Code code_in(const TableRow& row, std::string_view column, std::string_view text) {
    std::array<std::string, 3> parts;  // scheme, value, meaning
    std::size_t count = 0;
    bool fits = true;
    for (const char c : text) {
        count += c == '^' ? 1 : 0;
        fits = fits && count < 3 && static_cast<unsigned char>(c) >= ' ' && c != '\\' && c != '~' && c != '|';
        if (c != '^' && fits) {
            parts[count] += c;
        }
    }
    for (const std::string& part : parts) {
        fits = fits && !part.empty() && part.size() <= (&part == &parts.back() ? 64U : 16U);
    }
    if (!fits) {
        row.refuse("the " + std::string(column) + " " + in_quotes(text) +
                   " is not scheme^value^meaning, of at most 16, 16 and 64 bytes");
    }
    return {parts[0], parts[1], parts[2]};
}

/// The column of each cell, as an index into label_columns.
std::vector<std::size_t> columns_in(const TableRow& row, const std::vector<std::string>& cells) {
    std::vector<std::size_t> columns;
    for (const std::string& cell : cells) {
        const auto* const found = std::find(label_columns.begin(), label_columns.end(), lower_case(trimmed(cell)));
        columns.push_back(static_cast<std::size_t>(found - label_columns.begin()));
        if (found == label_columns.end() || std::count(columns.begin(), columns.end(), columns.back()) > 1) {
            row.refuse("the column " + in_quotes(cell) + " is not known, or stands there twice; there is " +
                       "label, name, color, category, type, region");
        }
    }
    if (std::find(columns.begin(), columns.end(), 0U) == columns.end()) {
        row.refuse("no column is called label");
    }
    return columns;
}

LabelRow label_row_of(const TableRow& at, const std::vector<std::size_t>& columns, const std::vector<std::string>& cells) {
    LabelRow row;
    if (cells.size() != columns.size()) {
        at.refuse(std::to_string(cells.size()) + " cells, where the first line has " + std::to_string(columns.size()));
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::string_view column = label_columns[columns[i]];
        const std::string_view cell = trimmed(cells[i]);
        Code* const code = column == "category" ? &row.terms.category
                           : column == "type"   ? &row.terms.type
                           : column == "region" ? &row.terms.region
                                                : nullptr;
        if (column == "label" && (!read_integer(cell, row.label) || row.label == 0 || row.label > most_mask_labels)) {
            at.refuse("the label " + in_quotes(cell) + " is not a number from 1 to 65,535");
        } else if (column == "name") {
            row.name = cell;
        } else if (column == "color" && !cell.empty()) {
            row.terms.colour = colour_in(at, cell);
        } else if (code != nullptr && !cell.empty()) {
            *code = code_in(at, column, cell);
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
        const std::string_view table = std::string_view(text).substr(text.starts_with("\xef\xbb\xbf") ? 3 : 0);
        const std::vector<CsvRow> rows = read_csv(table, ',', [&](std::size_t line, const char* what) {
            TableRow{name, line}.refuse(what);
        });
        if (rows.empty()) {
            refuse_image(name, "an empty table of labels");
        }
        const std::vector<std::size_t> columns = columns_in({name, rows[0].line}, rows[0].cells);
        std::vector<LabelRow> found;
        std::set<std::size_t> labels;
        for (const CsvRow& row : std::span(rows).subspan(1)) {
            const TableRow at{name, row.line};
            found.push_back(label_row_of(at, columns, row.cells));
            if (!labels.insert(found.back().label).second) {
                at.refuse("the label " + std::to_string(found.back().label) + " has a row already");
            }
        }
        return found;
    });
}

}  // namespace lamella
