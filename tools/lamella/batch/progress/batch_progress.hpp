// How far a batch is, on stderr: a bar on a terminal, else a line from time to time.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

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

/// "35 s", "12 min", "3.4 h"
std::string duration_text(double seconds);

/// "1.2 M triangles/s"
std::string rate_text(double triangles_per_s);

}  // namespace lamella::cli::batch
