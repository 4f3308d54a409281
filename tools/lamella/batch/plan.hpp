// From what was typed to the items of a batch, with all that can be refused before any work.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace lamella::cli::batch {

/// Values by the option's name with its dashes, "--layer-height"; a flag has the value "true".
using OptionValues = std::map<std::string, std::vector<std::string>>;

/// The options of `lamella slice` by name, as a batch passes them on: which there are, which values they take, and whether
/// they go together.
class SliceWords {
public:
    SliceWords();

    /// The name with dashes of an option that an item may have: of "layer-height", "layer_height" or "--layer-height". Empty
    /// if there is none of that name.
    std::string name_of(const std::string& text) const;
    /// As slice declares it.
    const CLI::Option& option(const std::string& name) const { return *prototype_.get_option(name); }
    /// The options that slice does not take together with --memory, as they need the whole mesh.
    std::vector<std::string> names_without_memory() const;

    /// The options typed for `command`, which has those of slice and more.
    OptionValues typed(const CLI::App& command) const;

    /// "--layer-height=0.5", in the order of `lamella slice --help`.
    std::vector<std::string> words(const OptionValues& values) const;

    /// Throws Failure (bad_usage) if slice would refuse these options.
    void require_accepted(const OptionValues& values) const;

private:
    CLI::App prototype_;
};

struct MeshSource {
    std::string path;
    std::string folder;   ///< of the mesh below the SOURCE that is a folder; empty where that is the folder itself
    OptionValues values;  ///< of a manifest
    std::string place;    ///< FILE:LINE of a manifest, else empty
};

/// True if a file's name ends in .csv or .jsonl.
bool is_named_as_manifest(const std::string& path);

/// A list of meshes with options for each: CSV with a line of names, or JSON Lines.
///
///     path,layer-height,like            {"path": "liver.stl", "layer-height": 0.5, "like": "ct.nii.gz"}
///     liver.stl,0.5,ct.nii.gz           {"path": "skull.stl", "spacing": [1, 1, 2], "coverage": true}
///     skull.stl,,
///
/// The names may be separated by semicolons or tabs; then so is the rest, and one number may have a decimal comma: 0,5. An
/// empty cell or null leaves the option as the command line has it. Paths are relative to the current folder, as on the
/// command line. Throws Failure naming the file and the line: of what cannot be read, and of names that are no option of
/// slice.
std::vector<MeshSource> read_manifest(const std::string& path, const SliceWords& words);

/// The meshes of SOURCE..., files, folders, globs and manifests, in the order of the sources; a folder's in the order of
/// names, folders in it included. Throws Failure: of a folder that cannot be listed, of a folder or glob without meshes, of
/// a manifest. A mesh need not exist: that is for its item to say.
std::vector<MeshSource> list_sources(const std::vector<std::string>& given, const SliceWords& words);

/// A file that decides what comes out, as it was found: with its time, or with its content by --hash.
struct InputFact {
    std::string path;
    std::uint64_t bytes = 0;
    std::int64_t modified_ns = 0;  ///< since 1970; 0 with a hash
    std::string sha256;            ///< empty without --hash

    bool operator==(const InputFact&) const = default;
};

/// One mesh of a batch: what is sliced, how, and into which files.
struct Item {
    std::string mesh;
    std::vector<std::string> words;    ///< options that decide what comes out: "--layer-height=0.5"
    std::vector<std::string> plain;    ///< options that do not: "--map"
    std::vector<std::string> outputs;  ///< as slice takes them
    std::string to;                    ///< formats
    std::string report;
    std::vector<std::string> files;  ///< all that come to lie on disk, but for the report; the first one names the item
    std::vector<std::string> option_files;  ///< that the options name: images, planes, transforms
    std::optional<int> threads;             ///< asked for
    std::string place;                      ///< FILE:LINE of a manifest, else empty
    std::vector<InputFact> inputs;          ///< the mesh, then option_files; found when the item's turn comes

    const std::string& key() const { return files.front(); }
    /// With the report.
    std::vector<std::string> all_files() const;
};

/// `common` are the options of all, of which those of a manifest take the place. Throws Failure: options that slice would
/// refuse, an unknown word in a name, two items with one output, an output that is a mesh of the batch, a file that options
/// name, or one of `own_files`: results and manifests.
std::vector<Item> plan_items(const std::vector<MeshSource>& sources, const OptionValues& common, const SliceWords& words,
                             const std::vector<std::string>& own_files);

/// The folder in which all lies that the name of an output with places for that of a mesh stands for: "out" of
/// 'out/{stem}.svg', "." of '{stem}.svg'.
std::string fixed_folder(const std::string& pattern);

}  // namespace lamella::cli::batch
