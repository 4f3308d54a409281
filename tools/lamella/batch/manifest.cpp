#include "batch/batch.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "files/streams.hpp"
#include "outputs/write_outputs.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli::batch {

namespace {

/// True if its value is one number of mm.
bool takes_length(const CLI::Option& option) {
    return option.get_type_name().starts_with("MM");
}

/// For messages.
std::string name_of_separator(char separator) {
    return separator == '\t' ? "tabs" : std::string(1, separator);
}

/// Comma, semicolon or tab: what separates the names in the first line; comma where there is one name. Throws Failure where
/// there are several.
char separator_of(std::string_view text, const std::string& name) {
    const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
    char found = 0;
    for (const char separator : {',', ';', '\t'}) {
        if (line.find(separator) == std::string_view::npos) {
            continue;
        }
        refuse_if(found != 0, bad_input,
                  name + ":1: the names are separated by " + name_of_separator(found) + " and by " +
                      name_of_separator(separator) + ": one of them has to separate all");
        found = separator;
    }
    return found == 0 ? ',' : found;
}

struct CsvRow {
    std::vector<std::string> cells;
    std::size_t line = 0;  ///< where the row begins, from 1
};

/// True if nothing stands in the cells from `begin` on, as in columns at the end that a spreadsheet left empty.
bool are_empty(const CsvRow& row, std::size_t begin) {
    return std::all_of(row.cells.begin() + static_cast<std::ptrdiff_t>(begin), row.cells.end(),
                       [](const std::string& cell) { return cell.empty(); });
}

/// The rows but those without a word, by CSV as RFC 4180 has it, or with another separator in place of commas: quoted cells
/// that may hold commas, quotes ("") and line ends; LF or CRLF. Throws Failure naming the line of a cell whose quotes do not
/// match.
std::vector<CsvRow> csv_rows(std::string_view text, char separator, const std::string& name) {
    std::vector<CsvRow> rows;
    CsvRow row{{""}, 1};
    std::size_t line = 1;
    std::size_t quoted_from = 0;  // the line of a quote that is open; else 0
    bool closed = false;          // the quote of the cell
    const auto end_row = [&] {
        if (!are_empty(row, 0)) {
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
            throw Failure(bad_input, name + ":" + std::to_string(line) + ": text follows a closing quote");
        } else if (c == '"' && row.cells.back().empty()) {
            quoted_from = line;
        } else {
            row.cells.back() += c;
        }
    }
    refuse_if(quoted_from > 0, bad_input, name + ":" + std::to_string(quoted_from) + ": a quote is not closed");
    end_row();
    return rows;
}

/// Rows of one manifest, whatever its format.
class ManifestReader {
public:
    ManifestReader(std::string path, const SliceOptionNames& names) : path_(std::move(path)), names_(names) {}

    std::vector<MeshSource> rows() {
        const std::string text = read_text(path_);
        path_.ends_with(".csv") ? read_csv(text) : read_lines(text);
        refuse_if(rows_.empty(), bad_input, path_ + ": no meshes");
        return std::move(rows_);
    }

private:
    Failure at(std::size_t line, const std::string& what) const {
        return {bad_input, path_ + ":" + std::to_string(line) + ": " + what};
    }

    /// "" for the mesh itself, else the name of an option.
    std::string column(const std::string& text, std::size_t line) const {
        if (text == "path" || text == "mesh") {
            return {};
        }
        std::string name = names_.name_of(text);
        if (name.empty()) {
            throw at(line, "'" + text + "' is neither path nor an option of lamella slice");
        }
        return name;
    }

    void begin_row(std::size_t line) { rows_.push_back({"", "", {}, path_ + ":" + std::to_string(line)}); }

    void end_row(std::size_t line) const {
        if (rows_.back().path.empty()) {
            throw at(line, "no path of a mesh");
        }
        if (is_standard(rows_.back().path)) {
            throw at(line, "'-' is no path: a batch takes files");
        }
    }

    /// A decimal comma as a point, where no list can be meant.
    std::string value_of(const std::string& name, const std::string& value, std::size_t line) const {
        if (name.empty() || !is_decimal_comma(value)) {
            return value;
        }
        if (takes_length(names_.option(name))) {
            return with_point(value);
        }
        if (separator_ != ',') {
            throw at(line, name + ": '" + value + "' is one number or two: write " + with_point(value) +
                               ", or a blank after the comma");
        }
        return value;
    }

    void set(const std::string& name, std::vector<std::string> values, std::size_t line) {
        MeshSource& row = rows_.back();
        if (name.empty()) {
            row.path = values.front();
            return;
        }
        if (!is_flag(names_.option(name))) {
            row.values[name] = std::move(values);
            return;
        }
        const std::string& value = values.front();
        const bool is_set = value == "true" || value == "1" || value == "yes";
        if (!is_set && value != "false" && value != "0" && value != "no") {
            throw at(line, name + ": '" + value + "' is neither true nor false");
        }
        row.values[name] = is_set ? std::vector<std::string>{"true"} : std::vector<std::string>();
    }

    void read_csv(const std::string& text) {
        std::vector<std::string> columns;
        separator_ = separator_of(text, path_);
        const std::vector<CsvRow> table = csv_rows(text, separator_, path_);
        for (const CsvRow& row : table) {
            if (&row == &table.front()) {
                columns = columns_of(row);
                continue;
            }
            if (row.cells.size() < columns.size() || !are_empty(row, columns.size())) {
                throw at(row.line, counted(row.cells.size(), "cell") + " where the first line names " +
                                       counted(columns.size(), "column") + " separated by " + name_of_separator(separator_) +
                                       ": quotes keep a cell that holds one whole");
            }
            begin_row(row.line);
            for (std::size_t i = 0; i < columns.size(); ++i) {
                if (!row.cells[i].empty()) {
                    set(columns[i], {value_of(columns[i], row.cells[i], row.line)}, row.line);
                }
            }
            end_row(row.line);
        }
    }

    std::vector<std::string> columns_of(const CsvRow& row) const {
        std::vector<std::string> columns;
        for (const std::string& cell : row.cells) {
            if (are_empty(row, columns.size())) {
                break;
            }
            std::string name = column(cell, row.line);
            if (std::find(columns.begin(), columns.end(), name) != columns.end()) {
                throw at(row.line, "two columns are '" + cell + "'");
            }
            columns.push_back(std::move(name));
        }
        if (std::find(columns.begin(), columns.end(), "") == columns.end()) {
            throw at(row.line, "no column is named path");
        }
        return columns;
    }

    void read_lines(const std::string& text) {
        std::size_t line = 0;
        for (const std::string_view row : split(text, '\n')) {
            ++line;
            if (row.find_first_not_of(" \t\r") != std::string_view::npos) {
                begin_row(line);
                read_object(row, line);
                end_row(line);
            }
        }
    }

    void read_object(std::string_view text, std::size_t line) {
        const nlohmann::json object = nlohmann::json::parse(text, nullptr, false);
        if (!object.is_object()) {
            throw at(line, "not a JSON object");
        }
        std::vector<std::string> names;
        for (const auto& [key, value] : object.items()) {
            const std::string name = column(key, line);
            if (std::find(names.begin(), names.end(), name) != names.end()) {
                throw at(line, "two members are '" + key + "'");
            }
            names.push_back(name);
            if (!value.is_null()) {
                set(name, values_of(name, key, value, line), line);
            }
        }
    }

    /// A list is repeated where the option may be, else joined by commas.
    std::vector<std::string> values_of(const std::string& name, const std::string& key, const nlohmann::json& value,
                                       std::size_t line) const {
        if (!value.is_array()) {
            return {scalar(key, value, line)};
        }
        std::vector<std::string> values;
        std::string joined;
        for (const nlohmann::json& each : value) {
            values.push_back(scalar(key, each, line));
            joined += (joined.empty() ? "" : ",") + values.back();
        }
        if (values.empty() || name.empty()) {
            throw at(line, "'" + key + "' is a list" + (values.empty() ? " of nothing" : ""));
        }
        return names_.option(name).get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll
                   ? values
                   : std::vector<std::string>{joined};
    }

    std::string scalar(const std::string& key, const nlohmann::json& value, std::size_t line) const {
        if (value.is_string()) {
            return name_of_text(value.get<std::string>());
        }
        if (value.is_boolean()) {
            return value.get<bool>() ? "true" : "false";
        }
        if (value.is_number_float()) {
            return exact_text(value.get<double>());
        }
        if (value.is_number()) {
            return value.dump();
        }
        throw at(line, "'" + key + "' is neither text, a number nor true or false");
    }

    std::string path_;
    const SliceOptionNames& names_;
    char separator_ = ',';
    std::vector<MeshSource> rows_;
};

}  // namespace

bool is_named_as_manifest(const std::string& path) {
    return path.ends_with(".csv") || path.ends_with(".jsonl");
}

std::vector<MeshSource> read_manifest(const std::string& path, const SliceOptionNames& names) {
    return ManifestReader(path, names).rows();
}

}  // namespace lamella::cli::batch
