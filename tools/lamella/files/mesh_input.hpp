// The meshes that a command works on: the flags that say how to read them, files and folders, and a file in words.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "files/streams.hpp"
#include "lamella/io/mesh_file.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/interrupt.hpp"

namespace lamella::cli {

struct MeshArguments {
    std::string mesh;  ///< a path, or - for standard input
    std::optional<std::string> unit;
    std::string grid;  ///< empty: the default
    int threads = 0;
    bool map_file = false;
    ProgressBar::When progress = ProgressBar::When::automatic;

    std::string name() const { return input_name(mesh); }
};

/// A check for options whose value may not be empty: what is wrong with it, if anything.
std::string given(const std::string& text);
std::string given_path(const std::string& path);

/// Transforms a word of a list to lower case, as it is listed; records hold it so.
std::string lower_case(std::string word);

/// Declares --unit, --grid and --threads on `command`, to be stored in `arguments`.
void declare_reading(CLI::App& command, MeshArguments& arguments);

/// --threads alone.
void declare_threads(CLI::App& command, MeshArguments& arguments);

/// The help of an argument that is a mesh: "Mesh file, or - for standard input: ...".
std::string mesh_help(const std::string& what);

/// Reads the mesh, which `bar` shows; its warnings are the caller's to tell. Throws Failure.
MeshFile read_mesh_of(const MeshArguments& arguments, ProgressBar& bar);

/// The same, with the warnings told.
MeshFile read_mesh_and_warn(const MeshArguments& arguments, ProgressBar& bar);

/// "binary STL, 1.9 MB", with what else is known of the file.
std::string description(const MeshFile& mesh);

/// By name. Where `problem` is set, those that were found before it.
std::vector<std::filesystem::directory_entry> entries_of(const std::filesystem::path& folder, std::error_code& problem);

struct ListedMesh {
    std::string path;
    std::string folder;   ///< that it is in, below the one that was listed; empty: that one itself
    std::string problem;  ///< why there is nothing to read, if so
};

/// The files named as meshes in a folder and in those below it, by name. Left out are hidden ones, and links to folders,
/// which may lead back to one above them. A folder that cannot be listed, or without any mesh, stands there as a problem.
std::vector<ListedMesh> meshes_below(const std::string& folder);

struct MeshListArguments {
    std::vector<std::string> given;  ///< as typed
    MeshArguments each;              ///< how to read each; its mesh is left empty
};

/// Declares the meshes, --unit, --grid and --threads on `command`, to be stored in `arguments`.
void declare_mesh_list(CLI::App& command, MeshListArguments& arguments);

class MeshList {
public:
    /// Lists the meshes in folders and in the folders below them. Throws Failure (bad_usage) if standard input is given
    /// twice, or if --unit or --grid is none.
    explicit MeshList(const MeshListArguments& arguments);

    /// A list of files and folders, and not one file.
    bool several() const noexcept { return several_; }
    std::vector<std::string> paths() const;

    using Use = std::function<void(const MeshArguments&)>;
    using Refuse = std::function<void(const MeshArguments&, const Failure&)>;

    /// Calls `use` for one mesh after the other. A Failure by which one of several cannot be used is printed and passed to
    /// `refuse`, and the rest goes on; in the end one Failure for all is returned. A Failure of the output, or of the only
    /// mesh, is thrown.
    [[nodiscard]] std::optional<Failure> for_each(Interrupt& interrupt, const Use& use, const Refuse& refuse) const;

private:
    MeshArguments each_;
    bool several_;
    std::vector<ListedMesh> meshes_;
};

}  // namespace lamella::cli
