#include "batch/progress/batch_summary.hpp"

#include <algorithm>

namespace lamella::cli::batch {

namespace {

constexpr std::size_t most_listed = 20;

}  // namespace

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
        text += "failed    ";
        text += printable(failed[i].mesh);
        text += ": ";
        text += printable(failed[i].reason);
        text += '\n';
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
