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
#include "files/streams.hpp"
#include "lamella/slice.hpp"
#include "outputs/image_arguments.hpp"

namespace lamella::cli {

struct SliceArguments : MeshArguments {
    std::vector<std::string> meshes;  ///< `mesh` is the one that is worked on
    OutputArguments outputs;
    ImageArguments image;
    std::string report;
    std::optional<double> layer_height_mm;
    std::string planes;
    std::string random_heights;
    std::uint64_t seed = 1;
    std::optional<double> first_height_mm;
    Datum datum = Datum::mesh_min;
    PlaneSide side = PlaneSide::below;
    std::optional<double> weld_mm;
    bool orient_shells = false;
    std::string close_gaps = "auto";  ///< mm, or auto
    GapSense gap_sense = GapSense::kept;
    RegionRules region{.fill_rule = FillRule::non_zero, .fill_from = {}};  ///< but for fill_from
    std::vector<std::string> fill_from;                                    ///< LAYER:RULE
    std::string normal;
    std::string transform;
    std::string layers;  ///< A:B
    std::string memory;  ///< bytes; empty: the mesh is held
    bool hash = false;
    bool split = false;  ///< each object of a file is a mesh
    int band_planes = 0;
    ContourForm form = ContourForm::swept;

    /// At least two where each may hold several.
    std::size_t mesh_count() const noexcept { return std::max<std::size_t>(split ? 2 : 1, meshes.size()); }
    bool output_to_stdout() const noexcept {
        return std::any_of(outputs.outputs.begin(), outputs.outputs.end(), is_standard);
    }
    bool report_to_stdout() const noexcept { return is_standard(report); }
};

/// Declares the flags on `command`, to be stored in `arguments`.
void declare(CLI::App& command, SliceArguments& arguments);

/// --progress, which info and check have too.
void declare_progress(CLI::App& command, MeshArguments& arguments);

/// The least distance between two planes at different heights, if there are two.
std::optional<double> least_plane_distance(const LayerPlan& plan);

/// Checks values and reads the files that flags name. Throws Failure.
SliceOptions options_of(const SliceArguments& arguments);

}  // namespace lamella::cli
