#include "outputs/image_arguments.hpp"

#include <utility>

#include "files/mesh_input.hpp"
#include "outputs/output_formats.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

void declare_structures(CLI::App& command, OutputArguments& arguments) {
    command
        .add_option_function<std::string>(
            "--holes",
            [&arguments](const std::string& text) {
                if (text != "keyhole" && text != "xor") {
                    throw CLI::ValidationError("--holes", "'" + text + "' is not one of keyhole|xor");
                }
                arguments.holes = text == "xor" ? HoleForm::exclusive_or : HoleForm::keyhole;
                arguments.holes_given = true;
            },
            "Holes in a structure set: joined to their contour, or contours that exclude one another (keyhole)")
        ->type_name("keyhole|xor")
        ->transform(lower_case);
    command.add_flag("--without-ct", arguments.without_ct, "Write a structure set that refers to no CT");
}

}  // namespace

void declare_outputs(CLI::App& command, OutputArguments& arguments) {
    command
        .add_option(
            "-o,--output", arguments.outputs,
            "File to write, by the end of its name: " + output_format_ends() + "; repeatable; - for SVG on standard output")
        ->type_name("FILE|-")
        ->take_all()
        ->allow_extra_args(false)
        ->check(given_path);
    command
        .add_option("--to", arguments.to,
                    "Write these formats, each as --output with the end of its name exchanged: " + output_format_names())
        ->type_name("FORMAT,...")
        ->check(given);
    command.add_flag("--coverage", arguments.coverage, "Masks hold the share of each voxel's area that is inside");
    command
        .add_option("--picture-layer", arguments.picture_layer, "PNG shows this layer, counted from 0, not a contact sheet")
        ->type_name("N")
        ->check(CLI::Validator(CLI::NonNegativeNumber).description(""));
    declare_structures(command, arguments);
    command.add_flag("--strict", arguments.strict, "Fail where a slice has open contours, of which no area is known");
}

void declare_image(CLI::App& command, ImageArguments& arguments) {
    CLI::Option* const like = command.add_option(
        "--like", arguments.like, "Cut at the slices of this image: NIfTI-1, NRRD, or a folder with a DICOM series");
    CLI::Option* const spacing =
        command.add_option("--spacing", arguments.spacing,
                           "Cut for voxels of this size in mm around the mesh, along left, posterior, superior");
    like->type_name("IMAGE")->check(given_path)->excludes(spacing);
    spacing->type_name("X,Y,Z")->check(given);
    command
        .add_option_function<std::string>(
            "--frame",
            [&arguments](const std::string& text) {
                if (text != "lps" && text != "ras") {
                    throw CLI::ValidationError("--frame", "'" + text + "' is not one of lps|ras");
                }
                arguments.frame = text == "lps" ? PatientFrame::lps : PatientFrame::ras;
            },
            "Patient frame of meshes that do not state one")
        ->type_name("lps|ras")
        ->transform(lower_case);
    command.add_option("--subslices", arguments.subslices, "Masks hold the mean share over N planes a slice (1: off)")
        ->type_name("N")
        ->check(CLI::Range(1, 1000));
}

ImageGeometry read_image_of(const ImageArguments& arguments) {
    return done_or_thrown(read_image_geometry(arguments.like));
}

PatientFrame patient_frame_of(const MeshFile& mesh, const ImageArguments& arguments, const std::string& name) {
    if (mesh.patient_frame != PatientFrame::unstated) {
        return mesh.patient_frame;
    }
    if (arguments.frame == PatientFrame::unstated) {
        throw Failure(bad_usage, name + ": states no patient frame; --frame lps or --frame ras says it");
    }
    return arguments.frame;
}

}  // namespace lamella::cli
