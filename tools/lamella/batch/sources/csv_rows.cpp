#include "batch/sources/csv_rows.hpp"

#include <algorithm>
#include <utility>

#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

class CsvReader {
public:
    CsvReader(std::string_view text, const std::string& name) : text_(text), name_(name) {
        constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
        if (text_.starts_with(byte_order_mark)) {
            at_ = byte_order_mark.size();
        }
    }

    std::vector<CsvRow> rows() {
        std::vector<CsvRow> rows;
        while (at_ < text_.size()) {
            CsvRow row = next_row();
            if (row.cells.size() > 1 || !row.cells.front().empty()) {
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
        } while (at_ < text_.size() && text_[at_] == ',' && ++at_ <= text_.size());
        end_line();
        return row;
    }

    std::string plain_cell() {
        const std::size_t begin = at_;
        at_ = std::min(text_.find_first_of(",\r\n", begin), text_.size());
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
        if (at_ < text_.size() && std::string_view(",\r\n").find(text_[at_]) == std::string_view::npos) {
            throw Failure(bad_input, name_ + ":" + std::to_string(line_) + ": text follows a closing quote");
        }
    }

    void end_line() {
        at_ += at_ < text_.size() && text_[at_] == '\r' ? 1 : 0;
        at_ += at_ < text_.size() && text_[at_] == '\n' ? 1 : 0;
        ++line_;
    }

    std::string_view text_;
    const std::string& name_;
    std::size_t at_ = 0;
    std::size_t line_ = 1;
};

}  // namespace

std::vector<CsvRow> csv_rows(std::string_view text, const std::string& name) {
    return CsvReader(text, name).rows();
}

}  // namespace lamella::cli::batch
