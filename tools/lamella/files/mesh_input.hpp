// Files of a command: "-" in place of a path (standard input for a mesh, standard output for what
// is written), and checks of an output's path before the work for it is done. The meshes that a command works on: the flags
// that say how to read them, files and folders, a file in words, and doubts that its size and place raise.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <vector>

#include <CLI/CLI.hpp>

#include "base/system/file.hpp"
#include "files/flags.hpp"
#include "lamella/check.hpp"
#include "lamella/io/mesh_file.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

inline constexpr std::string_view standard_stream = "-";

inline bool is_standard(std::string_view path) noexcept {
    return path == standard_stream;
}

/// The names of an input and an output in messages.
inline std::string input_name(const std::string& path) {
    return is_standard(path) ? "standard input" : path;
}
inline std::string output_name(const std::string& path) {
    return is_standard(path) ? "standard output" : path;
}

/// The path under which the library writes to an output.
inline std::filesystem::path output_path(const std::string& path) {
    return is_standard(path) ? "/dev/stdout" : path_of(path);
}

/// Writes a report. Throws Failure (bad_output).
void write_text(const std::string& path, const std::string& text);

/// $TMPDIR, else /tmp.
std::string temporary_folder();

/// "cannot write 'PATH': REASON"
Failure unwritable(const std::string& path, int error_number);

/// Throws Failure (bad_output) where `path`, or standard output for -, plainly cannot be written; a full disk shows only
/// later.
void require_writable(const std::string& path);

/// Throws Failure (bad_usage) if the path ends in another extension, and is no device or pipe.
void require_extension(const std::string& path, const std::string& option, const std::string& extension);

/// The files of a command, of which no output replaces an input or another output, by whatever path or link, and whether it
/// exists or not. An input and an output may both be -, which are different streams. Empty paths stand for no file.
class FilePlan {
public:
    /// `what`: as messages call it, "the mesh". Throws Failure (bad_usage).
    void reads(const std::string& path, const std::string& what) { add({path, "", what + " itself"}); }
    /// The same of a file that `option` names; `what`: "another output".
    void writes(const std::string& path, const std::string& option, const std::string& what) { add({path, option, what}); }
    /// Throws Failure (bad_usage) where `path` could not be added.
    void require_free(const std::string& path, const std::string& option) const {
        require_free(File{path, option, ""}, keys_of(path));
    }

private:
    struct File {
        std::string path;
        std::string option;  ///< empty: an input
        std::string what;
    };
    /// Where a file lies or would lie, whatever links and spellings its path has; and if it is there, what all its names
    /// share.
    std::vector<std::string> keys_of(const std::string& path) const;
    void require_free(const File& file, const std::vector<std::string>& keys) const;
    void add(const File& file);

    mutable std::unordered_map<std::string, std::string> folders_;  ///< without links, by their paths as given
    std::unordered_map<std::string, File> files_;  ///< by where they lie, and by their numbers in their file systems
};

// --- meshes

struct MeshArguments {
    std::string mesh;  ///< a path, or - for standard input
    std::optional<double> unit_mm;
    SliceOptions options = tool_options();  ///< of which info and check use the grid alone
    int threads = 0;
    bool map_file = false;
    bool all_roles = false;  ///< of a file's parts: see ReadOptions
    ProgressBar::When progress = ProgressBar::When::automatic;
    bool quiet = false;

    std::string name() const { return input_name(mesh); }
};

/// Declares --unit, --grid, --threads and --progress on `command`, to be stored in `arguments`.
void declare_reading(CLI::App& command, MeshArguments& arguments);

/// --threads and --progress alone; --threads alone.
void declare_running(CLI::App& command, MeshArguments& arguments);
void declare_threads(CLI::App& command, int& threads);

/// --quiet, of commands whose words on standard output only tell what they did.
void declare_quiet(CLI::App& command, MeshArguments& arguments);

/// The help of an argument that is a mesh: "Mesh file, or - for standard input: ...".
std::string mesh_help(const std::string& what);

/// Reads the mesh; its warnings are the caller's to tell. Throws Failure.
MeshFile read_mesh_of(const MeshArguments& arguments, Stages& stages);

/// The same, with the warnings told.
MeshFile read_mesh_and_warn(const MeshArguments& arguments, Stages& stages);

/// "binary STL, 1.9 MB", with what else is known of the file.
std::string description(const MeshFile& mesh);

/// Judges a mesh that is not sliced.
inline constexpr double common_layer_mm = 0.2;

/// A mesh as it was cut or examined.
struct MeasuredMesh {
    const Box& box;
    double grid_mm;
    std::optional<double> plane_distance_mm = common_layer_mm;  ///< the least from plane to plane, if there are two
    double detail_mm = common_layer_mm;                         ///< the least of that and the sides of voxels
    std::optional<double> farthest_mm{};                        ///< of the file's coordinates, where an image moved them
    bool moved = false;                                         ///< by a transform, so that coordinates are not the file's
};

/// Warnings, each one line that names the file: a grid too coarse, coordinates too far away, and a size that suggests
/// another unit where neither the file nor --unit states one.
std::vector<std::string> doubts_of_scale(const MeshArguments& arguments, const MeshFile& file, const MeasuredMesh& mesh);

/// ", boundary edges 0 on it and 44 by exact coordinates", after the grid, or nothing where they are as many.
std::string joined_by_grid(const MeshCheck& check);

/// By name. Where `problem` is set, those that were found before it.
std::vector<std::filesystem::directory_entry> entries_of(const std::filesystem::path& folder, std::error_code& problem);

struct ListedMesh {
    std::string path;
    std::string folder;   ///< that it is in, below the one that was listed; empty: that one itself
    std::string problem;  ///< why there is nothing to read, if so
};

/// False of standard input.
bool is_folder(const std::string& path);

/// The path itself, or where it is a folder the files named as meshes in it and in those below it, by name. Left out are
/// hidden ones, and links to folders, which may lead back to one above them. A folder that cannot be listed, or without any
/// mesh, stands there as a problem.
std::vector<ListedMesh> meshes_at(const std::string& path);

/// The meshes of info and check, which work on one after the other.
struct MeshList {
    std::vector<std::string> given;  ///< as typed
    MeshArguments each;              ///< how to read each; its mesh is left empty

    /// A list of files and folders, and not one file.
    bool several() const;
    /// The meshes, those in folders and in the folders below them too. Throws Failure (bad_usage) if standard input is given
    /// twice.
    std::vector<ListedMesh> meshes() const;

    /// Calls `use` for one mesh after the other. A Failure by which one of several cannot be used is printed and passed to
    /// `refuse`, and the rest goes on; in the end one Failure for all is returned. A Failure of the output, or of the only
    /// mesh, is thrown.
    [[nodiscard]] std::optional<Failure> for_each(
        Interrupt& interrupt, const std::function<void(const MeshArguments&)>& use,
        const std::function<void(const MeshArguments&, const Failure&)>& refuse) const;
};

/// Declares the meshes and the flags of declare_reading() on `command`, to be stored in `list`.
void declare_mesh_list(CLI::App& command, MeshList& list);

}  // namespace lamella::cli
