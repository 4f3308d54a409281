// Joins the results of shards.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace lamella::cli::batch {

struct MergedResults {
    std::string path;
    std::size_t items = 0;
    std::size_t failed = 0;
    std::vector<std::string> failures;  ///< "MESH: REASON"
};

/// `sources` is a folder with results.I-of-N.jsonl, or those files. Writes results.jsonl beside them: their lines, and those
/// of the results.jsonl that was there which no shard has. Throws Failure, also where a shard is missing.
MergedResults merge_shards(const std::vector<std::string>& sources);

}  // namespace lamella::cli::batch
