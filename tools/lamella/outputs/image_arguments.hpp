// The flags of results that medicine reads, which slice and convert share.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "lamella/io/mesh_file.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/medical/structure_set.hpp"

namespace lamella::cli {

struct OutputArguments {
    std::vector<std::string> outputs;  ///< paths, or -
    std::string to;                    ///< formats
    bool coverage = false;
    bool strict = false;
    HoleForm holes = HoleForm::keyhole;  ///< of structure sets
    bool holes_given = false;
    bool without_ct = false;
    std::optional<std::uint64_t> picture_layer;  ///< instead of a contact sheet
};

/// The image that sets the planes.
struct ImageArguments {
    std::string like;
    std::string spacing;
    PatientFrame frame = PatientFrame::unstated;
    int subslices = 1;

    bool given() const noexcept { return !like.empty() || !spacing.empty(); }
};

void declare_outputs(CLI::App& command, OutputArguments& arguments);
void declare_image(CLI::App& command, ImageArguments& arguments);

/// The geometry of --like. Throws Failure.
ImageGeometry read_image_of(const ImageArguments& arguments);

/// The patient frame of a mesh: what its file states, else --frame. Throws Failure where neither says it.
PatientFrame patient_frame_of(const MeshFile& mesh, const ImageArguments& arguments, const std::string& name);

}  // namespace lamella::cli
