#include <algorithm>
#include <string_view>
#include <utility>

#include "batch/batch.hpp"
#include "files/streams.hpp"
#include "outputs/outputs.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

/// For messages.
std::string name_of_separator(char separator) {
    return separator == '\t' ? "tabs" : std::string(1, separator);
}

/// Cells by CSV as RFC 4180 has it, or with another separator in place of commas.
struct CsvRow {
    std::vector<std::string> cells{""};
    std::size_t line = 1;  ///< where the row begins

    /// True if nothing stands in the cells from `begin` on, as in columns at the end that a spreadsheet left empty.
    bool is_empty(std::size_t begin = 0) const {
        return std::all_of(cells.begin() + static_cast<std::ptrdiff_t>(begin), cells.end(),
                           [](const std::string& cell) { return cell.empty(); });
    }
};

/// What a manifest says, row by row; throws Failure naming the file and the line.
class ManifestReader {
public:
    ManifestReader(std::string path, const SliceOptionNames& names)
        : path_(std::move(path)), names_(names), text_(read_text(path_)) {}

    std::vector<MeshSource> rows() {
        path_.ends_with(".csv") ? read_csv() : read_json_lines();
        refuse_if(rows_.empty(), bad_input, path_ + ": no meshes");
        return std::move(rows_);
    }

private:
    using Cells = std::vector<std::pair<std::string, std::vector<std::string>>>;  ///< values by what names() gave

    void refuse_at(std::size_t line, bool wrong, const std::string& what) const {
        refuse_if(wrong, bad_input, path_ + ":" + std::to_string(line) + ": " + what);
    }

    /// For each word the name of an option, or "" where it names the mesh itself.
    std::vector<std::string> names(const std::vector<std::string>& words, std::size_t line) const {
        std::vector<std::string> found;
        found.reserve(words.size());
        for (const std::string& word : words) {
            const bool mesh = word == "path" || word == "mesh";
            std::string name = mesh ? "" : names_.name_of(word);
            refuse_at(line, !mesh && name.empty(), "'" + word + "' is neither path nor an option of lamella slice");
            refuse_at(line, std::find(found.begin(), found.end(), name) != found.end(), "'" + word + "' stands there twice");
            found.push_back(std::move(name));
        }
        return found;
    }

    void add_row(Cells&& cells, std::size_t line) {
        MeshSource row{.path = {}, .folder = {}, .values = {}, .place = path_ + ":" + std::to_string(line)};
        for (auto& [name, values] : cells) {
            if (name.empty()) {
                row.path = values.front();
            } else if (is_flag(names_.option(name))) {
                const std::string& value = values.front();
                const bool is_set = value == "true" || value == "1" || value == "yes";
                refuse_at(line, !is_set && value != "false" && value != "0" && value != "no",
                          std::string(name).append(": '").append(value).append("' is neither true nor false"));
                row.values[name] = is_set ? std::vector<std::string>{"true"} : std::vector<std::string>();
            } else {
                row.values[name] = std::move(values);
            }
        }
        refuse_at(line, row.path.empty(), "no path of a mesh");
        refuse_at(line, is_standard(row.path), "'-' is no path: a batch takes files");
        rows_.push_back(std::move(row));
    }

    /// Comma, semicolon or tab: what separates the names in the first line, which must not be several of them; comma where
    /// there is one name.
    char separator() const {
        const std::string_view line = std::string_view(text_).substr(0, text_.find_first_of("\r\n"));
        char found = 0;
        for (const char separator : {',', ';', '\t'}) {
            if (line.find(separator) != std::string_view::npos) {
                refuse_at(1, found != 0,
                          "the names are separated by " + name_of_separator(found) + " and by " +
                              name_of_separator(separator) + ": one of them has to separate all");
                found = separator;
            }
        }
        return found == 0 ? ',' : found;
    }

    /// The rows but those without a word. Quoted cells may hold separators, quotes ("") and line ends.
    std::vector<CsvRow> table(char separator) const {
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
        for (std::size_t at = 0; at < text_.size(); ++at) {
            const char c = text_[at];
            const char next = at + 1 < text_.size() ? text_[at + 1] : '\0';
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
            } else {
                refuse_at(line, closed, "text follows a closing quote");
                const bool opens = c == '"' && row.cells.back().empty();
                quoted_from = opens ? line : 0;
                row.cells.back() += opens ? "" : std::string(1, c);
            }
        }
        refuse_at(quoted_from, quoted_from > 0, "a quote is not closed");
        end_row();
        return rows;
    }

    /// A decimal comma as a point, where no list can be meant.
    std::string number_in(const std::string& name, const std::string& value, char separator, std::size_t line) const {
        if (name.empty() || !is_decimal_comma(value)) {
            return value;
        }
        const bool one_number = names_.option(name).get_type_name().starts_with("MM");
        refuse_at(
            line, !one_number && separator != ',',
            name + ": '" + value + "' is one number or two: write " + with_point(value) + ", or a blank after the comma");
        return one_number ? with_point(value) : value;
    }

    void read_csv() {
        const char separator = this->separator();
        std::vector<CsvRow> rows = table(separator);
        if (rows.empty()) {
            return;
        }
        CsvRow& first = rows.front();
        while (first.is_empty(first.cells.size() - 1)) {
            first.cells.pop_back();
        }
        const std::vector<std::string> columns = names(first.cells, first.line);
        refuse_at(first.line, std::find(columns.begin(), columns.end(), "") == columns.end(), "no column is named path");
        for (auto row = rows.begin() + 1; row != rows.end(); ++row) {
            refuse_at(row->line, row->cells.size() < columns.size() || !row->is_empty(columns.size()),
                      counted(row->cells.size(), "cell") + " where the first line names " +
                          counted(columns.size(), "column") + " separated by " + name_of_separator(separator) +
                          ": quotes keep a cell that holds one whole");
            Cells cells;
            for (std::size_t i = 0; i < columns.size(); ++i) {
                if (!row->cells[i].empty()) {
                    cells.push_back({columns[i], {number_in(columns[i], row->cells[i], separator, row->line)}});
                }
            }
            add_row(std::move(cells), row->line);
        }
    }

    void read_json_lines() {
        std::size_t line = 0;
        for (const std::string_view row : split(text_, '\n')) {
            ++line;
            if (row.find_first_not_of(" \t\r") == std::string_view::npos) {
                continue;
            }
            const nlohmann::json object = nlohmann::json::parse(row, nullptr, false);
            refuse_at(line, !object.is_object(), "not a JSON object");
            std::vector<std::string> keys;
            for (const auto& member : object.items()) {
                keys.push_back(member.key());
            }
            const std::vector<std::string> found = names(keys, line);
            Cells cells;
            for (std::size_t i = 0; i < keys.size(); ++i) {
                if (const nlohmann::json& value = object[keys[i]]; !value.is_null()) {
                    cells.emplace_back(found[i], values_of(found[i], keys[i], value, line));
                }
            }
            add_row(std::move(cells), line);
        }
    }

    /// A list is repeated where the option may be, else joined by commas.
    std::vector<std::string> values_of(const std::string& name, const std::string& key, const nlohmann::json& value,
                                       std::size_t line) const {
        if (!value.is_array()) {
            return {scalar(key, value, line)};
        }
        refuse_at(line, value.empty() || name.empty(), "'" + key + "' is a list" + (value.empty() ? " of nothing" : ""));
        std::vector<std::string> values;
        for (const nlohmann::json& each : value) {
            values.push_back(scalar(key, each, line));
        }
        const bool repeats = names_.option(name).get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
        return repeats ? values : std::vector<std::string>{joined(values, ",")};
    }

    std::string scalar(const std::string& key, const nlohmann::json& value, std::size_t line) const {
        refuse_at(line, !value.is_primitive() || value.is_null(),
                  "'" + key + "' is neither text, a number nor true or false");
        return value.is_string()         ? name_of_text(value.get<std::string>())
               : value.is_number_float() ? exact_text(value.get<double>())
                                         : value.dump();
    }

    std::string path_;
    const SliceOptionNames& names_;
    std::string text_;
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
