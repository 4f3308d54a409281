// A batch in words for people: on stderr how far it is, a bar on a terminal, else a line from time to time; in the end a
// summary.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "terminal/console.hpp"

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

class BatchProgress {
public:
    explicit BatchProgress(ProgressBar::When when);

    void show(const BatchCounts& counts);
    /// A line of its own.
    void tell(const std::string& message);
    void wipe() { bar_.wipe(); }

    double seconds() const { return watch_.ms() / 1000; }

private:
    using Clock = std::chrono::steady_clock;

    ProgressBar bar_;
    bool lines_;  ///< no terminal, and not switched off
    Stopwatch watch_;
    Clock::time_point next_;
};

struct FailedItem {
    std::string mesh;
    std::string reason;
};

/// Some lines, each a keyword and what there is to say, with a final newline.
std::string batch_summary(const BatchCounts& counts, double seconds, const std::string& results,
                          const std::vector<FailedItem>& failed);

}  // namespace lamella::cli::batch
