// A batch in words for people: how far it is, and a summary in the end.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace lamella::cli::batch {

struct BatchCounts {
    std::size_t items = 0;      ///< of the batch
    std::size_t unchanged = 0;  ///< done before
    std::size_t done = 0;       ///< now
    std::size_t failed = 0;
    std::size_t of_older_version = 0;  ///< done before, by a version of lamella with other defaults
    double triangles = 0;              ///< of those done
    double cost = 0;                   ///< of those that ended, as estimated
    double all_cost = 0;               ///< of those to do

    std::size_t ended() const noexcept { return unchanged + done + failed; }
};

/// How far it is after so many seconds, on one line.
std::string batch_status(const BatchCounts& counts, double seconds);

struct FailedItem {
    std::string mesh;
    std::string reason;
};

/// Some lines, each a keyword and what there is to say, with a final newline.
std::string batch_summary(const BatchCounts& counts, double seconds, const std::string& results,
                          const std::vector<FailedItem>& failed);

}  // namespace lamella::cli::batch
