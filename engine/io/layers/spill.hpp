// Columns that lie one after another in a file, but grow side by side: beyond 1 MiB in all in a file without a name.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "io/write/output_file.hpp"

namespace lamella {

class Spill {
public:
    /// `beside`: the file that is written. Where its folder takes none, as that of a device, the system's for temporary
    /// files is used.
    Spill(const std::filesystem::path& beside, std::size_t columns, const StopCheck& stop)
        : beside_(beside), columns_(columns), most_held_(std::max<std::size_t>(4096, (std::size_t{1} << 20) / columns)) {
        pace_.follow(stop);
    }

    /// These throw Refused, Stopped, std::bad_alloc.
    void append(std::size_t column, std::string_view bytes) {
        Column& to = columns_[column];
        to.bytes += bytes.size();
        to.held += bytes;
        pace_.spend(bytes.size());
        if (to.held.size() > most_held_) {
            put_away(to);
        }
    }
    /// Calls take(piece) from the column's first byte to its last.
    template <class Take>
    void read(std::size_t column, Take&& take) {
        std::string piece;
        for (const auto& [begin, bytes] : columns_[column].away) {
            piece.resize(bytes);
            check(file_.read_at(std::as_writable_bytes(std::span(piece)), begin));
            pace_.spend(piece.size());
            take(std::string_view(piece));
        }
        take(std::string_view(columns_[column].held));
    }
    std::uint64_t bytes(std::size_t column) const noexcept { return columns_[column].bytes; }

private:
    struct Column {
        std::vector<std::pair<std::uint64_t, std::size_t>> away;  ///< where, and how many bytes
        std::string held;
        std::uint64_t bytes = 0;
    };

    void put_away(Column& column) {
        if (!file_.is_open()) {
            folder_ = beside_.has_parent_path() ? beside_.parent_path() : std::filesystem::path(".");
            if (file_.create_scratch(folder_) != 0) {  // a device's
                folder_ = std::filesystem::temp_directory_path();
                check(file_.create_scratch(folder_));
            }
        }
        check(file_.write_at(std::as_bytes(std::span(column.held)), end_));
        column.away.emplace_back(end_, column.held.size());
        end_ += column.held.size();
        column.held.clear();
    }

    void check(int failure) const {
        if (failure != 0) {
            throw Refused{unwritable(folder_ / "a temporary file", failure)};
        }
    }

    std::filesystem::path beside_;
    std::filesystem::path folder_;
    std::vector<Column> columns_;
    std::size_t most_held_;
    File file_;
    std::uint64_t end_ = 0;
    StopPace pace_;
};

}  // namespace lamella
