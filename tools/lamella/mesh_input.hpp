// The mesh that a command works on: the flags that say how to read it, and the file in words.
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "lamella/io/mesh_file.hpp"
#include "standard_streams.hpp"

namespace lamella::cli {

struct MeshArguments {
    std::string mesh;  ///< a path, or - for standard input
    std::optional<std::string> unit;
    std::string grid;  ///< empty: the default
    int threads = 0;
    bool map_file = false;

    std::string name() const { return input_name(mesh); }
};

/// A check for options whose value may not be empty: what is wrong with it, if anything.
std::string given(const std::string& text);
std::string given_path(const std::string& path);

/// Declares the mesh, --unit, --grid and --threads on `command`, to be stored in `arguments`.
void declare_mesh(CLI::App& command, MeshArguments& arguments);
/// The same without the mesh.
void declare_reading(CLI::App& command, MeshArguments& arguments);

/// The help of an argument that is a mesh: "Mesh file, or - for standard input: ...".
std::string mesh_help(const std::string& what);

/// Reads the mesh; its warnings are the caller's to tell. Throws Failure.
MeshFile read_mesh_of(const MeshArguments& arguments);

/// The same for a command that has nothing on the screen that warnings could run into.
MeshFile read_mesh_and_warn(const MeshArguments& arguments);

/// "binary STL, 1.9 MB", with what else is known of the file.
std::string description(const MeshFile& mesh);

}  // namespace lamella::cli
