// The flags of `lamella slice`, and what they ask of the engine.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "files/mesh_input.hpp"
#include "outputs/planned_outputs.hpp"
#include "slicing/tuning.hpp"

namespace lamella::cli {

struct SliceArguments : MeshArguments {
    std::vector<std::string> meshes;  ///< `mesh` is the one that is worked on
    OutputArguments outputs;
    ImageArguments image;
    std::string report;
    std::optional<double> weld_mm;
    bool orient_shells = false;
    Tuning tuning;
    std::uint64_t memory_bytes = 0;  ///< 0: the mesh is held
    bool hash = false;
    bool split = false;  ///< each object of a file is a mesh

    bool in_ranges() const noexcept { return memory_bytes > 0; }
    /// At least two where each may hold several.
    std::size_t mesh_count() const noexcept { return std::max<std::size_t>(split ? 2 : 1, meshes.size()); }
    bool output_to_stdout() const noexcept {
        return std::any_of(outputs.outputs.begin(), outputs.outputs.end(), is_standard);
    }
};

/// Declares the flags on `command`, to be stored in `arguments`. Values are checked, and files that flags name are read,
/// when the command line is parsed, which throws CLI::ParseError or Failure.
void declare(CLI::App& command, SliceArguments& arguments);

/// Sets the heights of the planes, whatever the flags say of them.
void cut_at(SliceOptions& options, std::vector<double> heights);

/// The least distance between two planes at different heights, if there are two.
std::optional<double> least_plane_distance(const SliceOptions& options);

}  // namespace lamella::cli
