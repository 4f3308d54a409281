// results.jsonl: a line an item, appended when the item ends, and put in order when the batch ends.
//
// A crash can tear the last line only. It is dropped when the file is opened, and its item is done again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "batch/plan.hpp"
#include "batch/result_line.hpp"
#include "files/streams.hpp"

namespace lamella::cli::batch {

struct LedgerName {
    std::string folder;
    std::uint32_t shard = 0;
    std::uint32_t shards = 0;  ///< 0: the batch is not divided

    std::string path() const;
    std::string path_of_whole() const;
};

/// Takes the digits of `text` for I and N where 0 <= I < N. False where they are none.
bool parse_shard(std::string_view index, std::string_view count, LedgerName& name);

/// By output.
using ResultLines = std::unordered_map<std::string, ResultLine>;

class Ledger {
public:
    /// Opens or makes the file, in a folder that exists, and locks it. Throws Failure (bad_input, bad_output), also where
    /// another batch holds the lock.
    explicit Ledger(const LedgerName& name);

    /// The line of an item, if there is one. A shard also knows those of the whole.
    const ResultLine* find(const std::string& key) const;

    /// On disk when this returns. Throws Failure (bad_output); what was written of the line is taken back then.
    void append(const ResultLine& result);

    /// Puts the file in order: by mesh, then by output. A line of an earlier batch stays, unless an item of `items` writes
    /// one of its outputs; a shard keeps those of `items` alone. Throws Failure (bad_output).
    void finish(const std::vector<Item>& items);

    const std::string& path() const noexcept { return path_; }

private:
    std::string path_;
    bool shard_;
    Descriptor file_;
    std::uint64_t bytes_ = 0;  ///< of whole lines
    ResultLines lines_;
};

struct MergedResults {
    std::string path;
    std::size_t items = 0;
    std::vector<std::string> failures;  ///< "MESH: REASON"
};

/// Joins the results of shards. `sources` is a folder with results.I-of-N.jsonl, or those files. Writes results.jsonl beside
/// them: their lines, and those of the results.jsonl that was there which no shard has. Throws Failure, also where a shard
/// is missing.
MergedResults merge_shards(const std::vector<std::string>& sources);

}  // namespace lamella::cli::batch
