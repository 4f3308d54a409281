// What a person reads when a batch has ended.
#pragma once

#include <string>
#include <vector>

#include "batch/progress/batch_progress.hpp"

namespace lamella::cli::batch {

struct FailedItem {
    std::string mesh;
    std::string reason;
};

/// Some lines, each a keyword and what there is to say, with a final newline.
std::string batch_summary(const BatchCounts& counts, double seconds, const std::string& results,
                          const std::vector<FailedItem>& failed);

}  // namespace lamella::cli::batch
