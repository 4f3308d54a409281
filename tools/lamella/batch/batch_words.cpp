#include "batch/batch_words.hpp"

#include <algorithm>
#include <cstdint>

#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

constexpr std::size_t most_listed = 20;  ///< of meshes that failed

/// "35 s", "12 min", "3.4 h"
std::string duration_text(double seconds) {
    constexpr double minute = 60;
    constexpr double hour = 60 * minute;
    if (seconds < 2 * minute) {
        return rounded(seconds, seconds < 10 ? 1 : 0) + " s";
    }
    return seconds < 2 * hour ? rounded(seconds / minute, 0) + " min" : rounded(seconds / hour, 1) + " h";
}

/// "1.2 M triangles/s"
std::string rate_text(double triangles_per_s) {
    constexpr double million = 1e6;
    return triangles_per_s >= million ? rounded(triangles_per_s / million, 1) + " M triangles/s"
                                      : rounded(triangles_per_s / 1e3, 1) + " k triangles/s";
}

}  // namespace

std::string batch_status(const BatchCounts& counts, double seconds) {
    std::string text = grouped(counts.ended()) + " of " + counted(counts.items, "mesh", "meshes");
    if (counts.triangles > 0) {
        text += ", " + rate_text(counts.triangles / std::max(seconds, 1e-3));
    }
    if (counts.cost > 0 && counts.all_cost > counts.cost) {
        text += ", " + duration_text(seconds * (counts.all_cost / counts.cost - 1)) + " left";
    }
    return counts.failed == 0 ? text : text + ", " + grouped(counts.failed) + " failed";
}

std::string batch_summary(const BatchCounts& counts, double seconds, const std::string& results,
                          const std::vector<FailedItem>& failed) {
    std::string text = "meshes    " + grouped(counts.items) + ": " + grouped(counts.done) + " done, " +
                       grouped(counts.unchanged) + " unchanged, " + grouped(counts.failed) + " failed\n";
    if (counts.triangles > 0) {
        text += "sliced    " + grouped(static_cast<std::uint64_t>(counts.triangles)) + " triangles in " +
                duration_text(seconds) + ", " + rate_text(counts.triangles / std::max(seconds, 1e-3)) + "\n";
    }
    if (counts.of_older_version > 0) {
        text += "again     " + counted(counts.of_older_version, "mesh", "meshes") +
                " that an older version of lamella sliced, whose defaults were others\n";
    }
    text += "results   " + printable(results) + "\n";
    for (std::size_t i = 0; i < std::min(failed.size(), most_listed); ++i) {
        text += "failed    " + printable(failed[i].mesh) + ": " + printable(failed[i].reason) + "\n";
    }
    if (failed.size() > most_listed) {
        text += "          and " + grouped(failed.size() - most_listed) + " more, which " + printable(results) + " names\n";
    }
    if (!failed.empty()) {
        text += "retry     the same command again slices those that failed, and no other\n";
    }
    return text;
}

}  // namespace lamella::cli::batch
