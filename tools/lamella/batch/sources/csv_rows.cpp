#include "batch/sources/csv_rows.hpp"

#include <algorithm>
#include <utility>

#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

class CsvReader {
public:
    CsvReader(std::string_view text, char separator, const std::string& name)
        : text_(text), ends_{separator, '\r', '\n'}, name_(name) {}

    std::vector<CsvRow> rows() {
        std::vector<CsvRow> rows;
        while (at_ < text_.size()) {
            CsvRow row = next_row();
            if (!std::all_of(row.cells.begin(), row.cells.end(), [](const std::string& cell) { return cell.empty(); })) {
                rows.push_back(std::move(row));
            }
        }
        return rows;
    }

private:
    CsvRow next_row() {
        CsvRow row{.cells = {}, .line = line_};
        do {
            row.cells.push_back(at_ < text_.size() && text_[at_] == '"' ? quoted_cell() : plain_cell());
        } while (at_ < text_.size() && text_[at_] == ends_[0] && ++at_ <= text_.size());
        end_line();
        return row;
    }

    std::string plain_cell() {
        const std::size_t begin = at_;
        at_ = std::min(text_.find_first_of(ends_, begin), text_.size());
        return std::string(text_.substr(begin, at_ - begin));
    }

    std::string quoted_cell() {
        const std::size_t line = line_;
        std::string cell;
        for (++at_; at_ < text_.size(); ++at_) {
            if (text_[at_] == '"' && (++at_ == text_.size() || text_[at_] != '"')) {
                require_end_of_cell();
                return cell;
            }
            line_ += text_[at_] == '\n' ? 1 : 0;
            cell += text_[at_];
        }
        throw Failure(bad_input, name_ + ":" + std::to_string(line) + ": a quote is not closed");
    }

    void require_end_of_cell() const {
        if (at_ < text_.size() && ends_.find(text_[at_]) == std::string_view::npos) {
            throw Failure(bad_input, name_ + ":" + std::to_string(line_) + ": text follows a closing quote");
        }
    }

    void end_line() {
        at_ += at_ < text_.size() && text_[at_] == '\r' ? 1 : 0;
        at_ += at_ < text_.size() && text_[at_] == '\n' ? 1 : 0;
        ++line_;
    }

    std::string_view text_;
    std::string ends_;  ///< of a cell: the separator, and ends of lines
    const std::string& name_;
    std::size_t at_ = 0;
    std::size_t line_ = 1;
};

}  // namespace

char separator_of(std::string_view text, const std::string& name) {
    const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
    char found = 0;
    for (const char separator : {',', ';', '\t'}) {
        if (line.find(separator) == std::string_view::npos) {
            continue;
        }
        if (found != 0) {
            throw Failure(bad_input, name + ":1: the names are separated by " + name_of(found) + " and by " +
                                         name_of(separator) + ": one of them has to separate all");
        }
        found = separator;
    }
    return found == 0 ? ',' : found;
}

std::string name_of(char separator) {
    return separator == '\t' ? "tabs" : std::string(1, separator);
}

std::vector<CsvRow> csv_rows(std::string_view text, char separator, const std::string& name) {
    return CsvReader(text, separator, name).rows();
}

}  // namespace lamella::cli::batch
