// results.jsonl: a line an item, appended when the item ends, and put in order when the batch ends.
//
// A crash can tear the last line only. It is dropped when the file is opened, and its item is done again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "batch/plan/item.hpp"
#include "batch/results/result_line.hpp"

namespace lamella::cli::batch {

struct LedgerName {
    std::string folder;
    std::uint32_t shard = 0;
    std::uint32_t shards = 0;  ///< 0: the batch is not divided

    std::string path() const;
    std::string path_of_whole() const;
};

class Ledger {
public:
    /// Opens or makes the file, in a folder that exists, and locks it. Throws Failure (bad_output), also where another batch
    /// holds the lock.
    explicit Ledger(const LedgerName& name);
    ~Ledger();
    Ledger(const Ledger&) = delete;
    Ledger& operator=(const Ledger&) = delete;

    /// The line of an item, if there is one. A shard also knows those of the whole.
    const ResultLine* find(const std::string& key) const;

    /// On disk when this returns. Throws Failure (bad_output); what was written of the line is taken back then.
    void append(const ResultLine& result);

    /// Puts the file in order: by mesh, then by output. A line of an earlier batch stays, unless an item of `items` writes
    /// one of its outputs; a shard keeps those of `items` alone. Throws Failure (bad_output).
    void finish(const std::vector<Item>& items);

    const std::string& path() const noexcept { return path_; }

private:
    void open_and_lock();
    void read_lines(const std::string& path, bool own);

    std::string path_;
    bool shard_;
    int descriptor_ = -1;
    std::uint64_t bytes_ = 0;  ///< of whole lines
    std::unordered_map<std::string, ResultLine> lines_;
};

/// The lines in order, by mesh, then by output.
std::string ordered_text(const std::unordered_map<std::string, ResultLine>& lines);

/// Writes aside, waits for the disk, renames. Throws Failure (bad_output).
void write_durably(const std::string& path, const std::string& text);

/// All lines of a file but those that are torn. Throws Failure (bad_input) if it cannot be read.
std::vector<ResultLine> read_results(const std::string& path);

}  // namespace lamella::cli::batch
