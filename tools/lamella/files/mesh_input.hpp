// The meshes that a command works on: the flags that say how to read them, files and folders, a file in words, and doubts
// that its size and place raise.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "files/flags.hpp"
#include "files/streams.hpp"
#include "lamella/check.hpp"
#include "lamella/io/mesh_file.hpp"
#include "terminal/stages.hpp"

namespace lamella::cli {

struct MeshArguments {
    std::string mesh;  ///< a path, or - for standard input
    std::optional<double> unit_mm;
    SliceOptions options = tool_options();  ///< of which info and check use the grid alone
    int threads = 0;
    bool map_file = false;
    ProgressBar::When progress = ProgressBar::When::automatic;

    std::string name() const { return input_name(mesh); }
};

/// Declares --unit, --grid, --threads and --progress on `command`, to be stored in `arguments`.
void declare_reading(CLI::App& command, MeshArguments& arguments);

/// --threads and --progress alone; --threads alone.
void declare_running(CLI::App& command, MeshArguments& arguments);
void declare_threads(CLI::App& command, int& threads);

/// The help of an argument that is a mesh: "Mesh file, or - for standard input: ...".
std::string mesh_help(const std::string& what);

/// Reads the mesh, which `bar` shows; its warnings are the caller's to tell. Throws Failure.
MeshFile read_mesh_of(const MeshArguments& arguments, ProgressBar& bar);

/// The same, with the warnings told.
MeshFile read_mesh_and_warn(const MeshArguments& arguments, ProgressBar& bar);

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
