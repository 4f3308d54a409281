// results.jsonl: a line an item, appended when the item ends, and put in order when the batch ends.
//
// A crash can tear the last line only. It is dropped when the file is opened, and its item is done again. Lines hold no time
// of the run and nothing of the machine, so that the same meshes give the same bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "batch/plan.hpp"
#include "files/streams.hpp"
#include "lamella/control.hpp"
#include "processes/workers.hpp"

namespace lamella::cli::batch {

struct OutputFact {
    std::string path;
    std::optional<std::uint64_t> bytes;  ///< none: it was not written

    bool operator==(const OutputFact&) const = default;
};

/// The outcome of an item.
struct ResultLine {
    std::string mesh;
    std::string failure;  ///< why it failed; empty: done
    std::vector<std::string> options;
    std::vector<InputFact> inputs;
    std::vector<OutputFact> outputs;  ///< of a failed item without sizes; the first one names the item
    std::optional<SliceFacts> facts;

    bool done() const noexcept { return failure.empty(); }
    const std::string& key() const { return outputs.front().path; }
};

/// With a final newline.
std::string line_of(const ResultLine& result);

/// None where the text is no such line, as one that was torn by a crash.
std::optional<ResultLine> parse_line(std::string_view text);

/// A file by its time, or by its content. A folder, such as a DICOM series, by the bytes in its files, and the latest time.
/// A file that cannot be read has no bytes and no time: the item then says why. Throws Failure where `stop` ends it.
InputFact fact_of(const std::string& path, bool hash, const StopCheck& stop);

/// The outputs of an item with their sizes; an output that is not there has none.
std::vector<OutputFact> outputs_of(const Item& item);

/// Done: the line says so, of the same mesh, options and inputs, and every output is there in the size that it says, or is
/// not there if it says so (slice within --memory leaves out a table).
bool is_done(const Item& item, const ResultLine& line);

/// True if the line does not state what every line of this version does: see changed_defaults.
bool is_of_older_version(const ResultLine& line);

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
    /// Opens or makes the file, and its folder, and locks it. Throws Failure (bad_input, bad_output), also where
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
