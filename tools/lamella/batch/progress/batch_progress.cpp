#include "batch/progress/batch_progress.hpp"

#include <algorithm>

namespace lamella::cli::batch {

namespace {

constexpr std::chrono::seconds between_lines{30};

std::string status_text(const BatchCounts& counts, double seconds) {
    std::string text = grouped(counts.ended()) + " of " + counted(counts.items, "mesh", "meshes");
    if (counts.triangles > 0) {
        text += ", " + rate_text(counts.triangles / std::max(seconds, 1e-3));
    }
    if (counts.cost > 0 && counts.all_cost > counts.cost) {
        text += ", " + duration_text(seconds * (counts.all_cost / counts.cost - 1)) + " left";
    }
    return counts.failed == 0 ? text : text + ", " + grouped(counts.failed) + " failed";
}

}  // namespace

std::string duration_text(double seconds) {
    constexpr double minute = 60;
    constexpr double hour = 60 * minute;
    if (seconds < 2 * minute) {
        return rounded(seconds, seconds < 10 ? 1 : 0) + " s";
    }
    return seconds < 2 * hour ? rounded(seconds / minute, 0) + " min" : rounded(seconds / hour, 1) + " h";
}

std::string rate_text(double triangles_per_s) {
    constexpr double million = 1e6;
    return triangles_per_s >= million ? rounded(triangles_per_s / million, 1) + " M triangles/s"
                                      : rounded(triangles_per_s / 1e3, 1) + " k triangles/s";
}

BatchProgress::BatchProgress(ProgressBar::When when)
    : bar_(when),
      lines_(!bar_.shown() && when != ProgressBar::When::never),
      next_(Clock::now() + (lines_ ? Clock::duration(between_lines) : Clock::duration(0))) {}

void BatchProgress::show(const BatchCounts& counts) {
    const Clock::time_point now = Clock::now();
    if (now < next_ || !(bar_.shown() || lines_)) {
        return;
    }
    next_ = now + (lines_ ? Clock::duration(between_lines) : Clock::duration(std::chrono::milliseconds(200)));
    const std::string status = status_text(counts, seconds());
    if (lines_) {
        complain(status);
    } else {
        bar_.show(status, counts.all_cost > 0 ? counts.cost / counts.all_cost : 0);
    }
}

void BatchProgress::tell(const std::string& message) {
    bar_.wipe();
    complain(message);
}

}  // namespace lamella::cli::batch
