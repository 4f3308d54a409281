// The mesh that a command works on: the flags that say how to read it, and the file in words.
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "files/streams.hpp"
#include "lamella/io/mesh_file.hpp"
#include "terminal/console.hpp"

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

}  // namespace lamella::cli
