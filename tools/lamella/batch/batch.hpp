// A batch: from what was typed to its items, with all that can be refused before any work; from there to its end; and
// results.jsonl, a line an item, appended when the item ends, and put in order when the batch ends.
//
// A crash can tear the last line only. It is dropped when the file is opened, and its item is done again. Lines hold no time
// of the run and nothing of the machine, so that the same meshes give the same bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "base/system/file.hpp"
#include "files/mesh_input.hpp"
#include "lamella/context.hpp"
#include "slice/slice.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::batch {

using Json = nlohmann::ordered_json;

/// One mesh of a batch: what is sliced, how, and into which files.
struct Item {
    std::string mesh{};
    std::vector<std::string> words{};   ///< options that decide what comes out: "--layer-height=0.5"
    std::vector<std::string> plain{};   ///< options that do not: "--map"
    std::vector<std::string> writes{};  ///< options that name what is written: "--output=out/liver.svg"
    std::string report{};
    std::vector<std::string> files{};  ///< all that come to lie on disk, but for the report; the first one names the item
    std::vector<std::string> option_files{};  ///< that the options name: images, planes, transforms
    int threads = 0;                          ///< asked for; 0: as the batch has it
    std::string place{};                      ///< FILE:LINE of a manifest, else empty
    Json inputs = Json::array();              ///< fact_of() the mesh, then option_files; found when the item's turn comes

    const std::string& key() const { return files.front(); }
    /// With the report.
    std::vector<std::string> all_files() const;
};

/// The items of SOURCE..., with the options that were typed for `command`, of which those of a manifest take the place.
/// Throws Failure: a folder or glob without meshes, a manifest that is wrong, options that slice would refuse, an unknown
/// word in a name, two items with one output, an output that is a mesh of the batch, a file that options name, a manifest or
/// one of `own_files`. Where the item stands in a manifest, that is what is wrong (bad_input).
std::vector<Item> plan_items(const CLI::App& command, const std::vector<std::string>& sources,
                             const std::vector<std::string>& own_files);

/// A file that decides what comes out, as it was found, with its bytes: by its time, in ns since 1970, or by its content. A
/// folder, such as a DICOM series, by the bytes in its files, and the latest time. A file that cannot be read has no bytes
/// and no time: the item then says why. Throws Failure where `stop` ends it.
Json fact_of(const std::string& path, bool hash, const Callback<bool()>& stop);

/// The outcome of an item: a line of results.jsonl, in which names are text_of_name().
struct ResultLine {
    /// Throws Json::exception of what is no such line.
    explicit ResultLine(Json line);
    /// `reason`: why it failed, else empty. `facts` are further members.
    ResultLine(const Item& item, const std::string& reason, const Json& facts);

    Json json;
    std::string mesh;
    std::string failure;               ///< why it failed; empty: done
    std::vector<std::string> outputs;  ///< the first one names the item

    const std::string& key() const { return outputs.front(); }
    /// Done: of the same mesh, options and inputs, and every output is there in the size that the line says, or is not there
    /// if it says so (slice within --memory leaves out a table).
    bool is_of(const Item& item) const;
    /// True if it does not state what every line of this version does: see changed_defaults.
    bool is_of_older_version() const;
};

/// By key.
using ResultLines = std::unordered_map<std::string, ResultLine>;

struct ResultsName {
    std::string folder;
    std::uint32_t shard = 0;
    std::uint32_t shards = 0;  ///< 0: the batch is not divided

    std::string path() const;
    std::string path_of_whole() const { return ResultsName{folder}.path(); }
};

/// The shard that `text` names as I `between` N where 0 <= I < N, as 0/4; its folder is left empty.
std::optional<ResultsName> parse_shard(std::string_view text, std::string_view between);

class ResultsFile {
public:
    /// Opens or makes the file, and its folder, and locks it. Throws Failure (bad_input, bad_output), also where
    /// another batch holds the lock.
    explicit ResultsFile(const ResultsName& name);

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
    File file_;
    std::uint64_t bytes_ = 0;  ///< of whole lines
    ResultLines lines_;
};

/// Joins the results of shards. `sources` is a folder with results.I-of-N.jsonl, or those files. Writes results.jsonl beside
/// them: their lines, and those of the results.jsonl that was there which no shard has. Prints a summary. Throws Failure,
/// also where a shard is missing or a mesh has failed.
void merge_shards(const std::vector<std::string>& sources);

struct BatchArguments {
    SliceArguments slice;            ///< its meshes are the sources; what it holds else is read from the command
    int jobs = 0;                    ///< 0: as many as there are processors
    std::uint64_t memory_bytes = 0;  ///< 0: what is free
    double timeout_s = 0;
    int retries = 1;
    std::string shard;
    std::string results;
    bool force = false;
    bool hash = false;
    bool merge = false;
};

/// Slices what is not done of `items`, those of this shard, and prints a summary. `arguments` say how many jobs and how much
/// memory. Throws Failure where results cannot be kept, and where a mesh has failed.
void run_batch(std::vector<Item> items, const ResultsName& name, const BatchArguments& arguments, Interrupt& interrupt);

}  // namespace lamella::cli::batch
