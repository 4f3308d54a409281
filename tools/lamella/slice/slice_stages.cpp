#include "slice/slice_stages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "files/scale_words.hpp"
#include "files/streams.hpp"
#include "lamella/lamella.hpp"
#include "outputs/output_checks.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

/// The meshes, and the files that other options name.
NamedInputs inputs_of(const SliceArguments& arguments) {
    NamedInputs inputs = {{arguments.image.like, "the file of --like"},
                          {arguments.transform, "the file of --transform"},
                          {arguments.planes, "the file of --planes"}};
    for (const std::string& mesh : arguments.meshes) {
        inputs.emplace_back(mesh, "the mesh");
    }
    return inputs;
}

void require_report_possible(const SliceArguments& arguments, const std::vector<PlannedOutput>& outputs) {
    if (arguments.report.empty()) {
        return;
    }
    if (!arguments.layers.empty()) {
        throw Failure(bad_usage, "--report: not with --layers, as it judges the whole mesh");
    }
    if (arguments.mesh_count() > 1) {
        throw Failure(bad_usage, "--report: one mesh a report, not several");
    }
    require_writable(arguments.report);
    require_no_input(arguments.report, inputs_of(arguments), "--report");
    for (const std::filesystem::path& output : files_of(outputs, false)) {
        require_different_output(arguments.report, output.string(), "--report", "--output");
    }
}

/// --memory cannot be had together with the report or with standard input.
void require_ranges_possible(const SliceArguments& arguments) {
    if (arguments.memory.empty()) {
        return;
    }
    (void)parse_bytes(arguments.memory, "--memory");
    if (!arguments.report.empty()) {
        throw Failure(bad_usage, "--memory: --report looks at the whole mesh, which is not held");
    }
    if (std::any_of(arguments.meshes.begin(), arguments.meshes.end(), is_standard)) {
        throw Failure(bad_usage, "--memory: standard input cannot be read twice; write it to a file first");
    }
}

/// How to slice the file within --memory.
FileSliceOptions file_options(const SliceArguments& arguments, const SliceOptions& options) {
    FileSliceOptions in_file{.slice = options, .hash = arguments.hash};
    in_file.mm_per_unit = parse_unit(arguments.unit.value_or("mm"), "--unit");
    in_file.memory_bytes = parse_bytes(arguments.memory, "--memory");
    in_file.temporary_folder = temporary_folder();
    const char* const asked = std::getenv("TMPDIR");
    // Else beside the output: the system's own folder is often held in memory.
    if ((asked == nullptr || *asked == 0) && !arguments.outputs.outputs.empty() && !arguments.output_to_stdout()) {
        const std::filesystem::path folder = std::filesystem::path(arguments.outputs.outputs.front()).parent_path();
        in_file.temporary_folder = folder.empty() ? "." : folder;
    }
    return in_file;
}

/// Lower and upper corner of a mesh in LPS.
using Box = std::array<std::array<double, 3>, 2>;

Box box_of(const MeshFile& file, const std::string& name, const SliceArguments& arguments) {
    SliceOptions options = options_of(arguments);
    options.plan.spacing = ExplicitPlanes{{0}};
    options.layers = {};
    options.transform = ImageGeometry{}.slicing_frame(patient_frame_of(file, arguments.image, name));
    const SliceSummary summary = arguments.memory.empty()
                                     ? done_or_thrown(slice(file, options)).summary
                                     : done_or_thrown(outline_file(name, file_options(arguments, options))).facts.summary;
    return {std::to_array(summary.min_mm), std::to_array(summary.max_mm)};
}

ImageGeometry image_around(const std::vector<MeshFile>& files, const SliceArguments& arguments) {
    const std::vector<double> spacing = parse_triple(arguments.image.spacing, "--spacing");
    Box all{};
    for (std::size_t i = 0; i < files.size(); ++i) {
        const Box box = box_of(files[i], arguments.meshes[i], arguments);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            all[0][axis] = i == 0 ? box[0][axis] : std::min(all[0][axis], box[0][axis]);
            all[1][axis] = i == 0 ? box[1][axis] : std::max(all[1][axis], box[1][axis]);
        }
    }
    return done_or_thrown(geometry_around(all[0], all[1], {spacing[0], spacing[1], spacing[2]}));
}

std::string why_nothing_is_cut(const SliceSummary& found) {
    return "no plane meets the mesh, which reaches from " + exact_text(found.min_mm[2]) + " to " +
           exact_text(found.max_mm[2]) + " mm along the slicing direction";
}

std::string why_nothing_is_left(const SliceResult& result) {
    const double offset_mm = result.region.offset_mm;
    const std::string what = offset_mm < 0 ? "an offset of " + exact_text(offset_mm) + " mm" : "the fill rule";
    return what + " leaves nothing: " +
           (result.summary.emptied_layers == 1
                ? "the one layer that the mesh crosses is empty"
                : "all " + counted(result.summary.emptied_layers, "layer") + " that the mesh crosses are empty");
}

std::vector<std::string> doubts_of(const SliceResult& result, const SliceArguments& arguments, const MeshFile& mesh,
                                   const std::optional<ImageGeometry>& image) {
    const std::optional<double> distance = least_plane_distance(result.plan);
    MeasuredMesh measured{.min_mm = result.summary.min_mm,
                          .max_mm = result.summary.max_mm,
                          .unit_mm = result.unit_mm,
                          .plane_distance_mm = distance,
                          .detail_mm = distance.value_or(common_layer_mm),
                          .moved = !arguments.transform.empty() || !arguments.normal.empty()};
    if (image) {
        measured.detail_mm = std::min({measured.detail_mm, image->spacing_mm[0], image->spacing_mm[1]});
        for (const auto& corner : {result.summary.min_mm, result.summary.max_mm}) {
            for (const double at : image->to_lps({corner[0], corner[1], corner[2]})) {
                measured.farthest_mm = std::max(measured.farthest_mm.value_or(0), std::abs(at));
            }
        }
    }
    return doubts_of_scale(arguments, mesh, measured);
}

}  // namespace

std::vector<PlannedOutput> plan_slice_outputs(const SliceArguments& arguments) {
    require_ranges_possible(arguments);
    const NamedInputs inputs = inputs_of(arguments);
    for (const std::string& output : arguments.outputs.outputs) {
        require_writable(output);
        require_no_input(output, inputs, "--output");
    }
    std::vector<PlannedOutput> outputs =
        plan_outputs(arguments.outputs, arguments.mesh_count(), arguments.image.given(), arguments.image.subslices, inputs);
    require_report_possible(arguments, outputs);
    return outputs;
}

std::vector<std::filesystem::path> files_to_write(const SliceArguments& arguments,
                                                  const std::vector<PlannedOutput>& outputs) {
    std::vector<std::filesystem::path> files = files_of(outputs, arguments.mesh_count() > 1);
    files.emplace_back(arguments.report);
    return files;
}

MeshFile read_for_slicing(const SliceArguments& arguments, Stages& stages) {
    MeshFile mesh = arguments.memory.empty() ? read_mesh_of(arguments, stages.bar())
                                             : done_or_thrown(describe_file(arguments.mesh, file_options(arguments, {})));
    const PatientFrame asked = arguments.image.frame;
    if (asked != PatientFrame::unstated && mesh.patient_frame != PatientFrame::unstated && mesh.patient_frame != asked) {
        mesh.warnings.push_back(arguments.name() + ": states the patient frame " + std::string(name_of(mesh.patient_frame)) +
                                ", which holds instead of --frame " + std::string(name_of(asked)));
    }
    return mesh;
}

ImageGeometry image_for(const std::vector<MeshFile>& files, const SliceArguments& arguments) {
    return arguments.image.like.empty() ? image_around(files, arguments) : read_image_of(arguments.image);
}

MendedMesh mend_mesh(const MeshFile& mesh, const SliceArguments& arguments, Stages& stages, ToolRun& run) {
    MendedMesh mended;
    if (arguments.weld_mm) {
        const auto join = [&](const Control& control) {
            return weld(mesh, {.tolerance_mm = *arguments.weld_mm, .control = control});
        };
        const Stopwatch watch;
        mended.welded = done_or_thrown(stages.run("welding", join), arguments.name());
        run.weld_ms = watch.ms();
    }
    if (arguments.orient_shells) {
        const MeshView view = mended.welded ? mended.welded->view() : mesh.view();
        const auto turn = [&](const Control& control) {
            return orient_shells(view, {.mm_per_unit = mesh.mm_per_unit, .control = control});
        };
        mended.oriented = done_or_thrown(stages.run("turning shells", turn), arguments.name());
        run.shells = mended.oriented->shells;
        run.turned_shells = mended.oriented->turned_shells;
    }
    return mended;
}

SliceResult cut_mesh(const MeshFile& mesh, const MendedMesh& mended, SliceOptions options, const SliceArguments& arguments,
                     StreamedOutputs* streamed, Stages& stages, ToolRun& run) {
    const bool in_ranges = !arguments.memory.empty();
    Result<SliceResult> result = stages.run("slicing", [&](const Control& control) {
        options.control = control;
        return in_ranges         ? slice_in_ranges(arguments.mesh, file_options(arguments, options), streamed, run)
               : mended.oriented ? slice(mended.oriented->mesh, options)
               : mended.welded   ? slice(*mended.welded, options)
                                 : slice(mesh, options);
    });
    if (!result && result.error().code == ErrorCode::empty_mesh && mended.welded && mended.welded->joined > 0) {
        throw Failure(bad_input, arguments.name() + ": welding at " + exact_text(*arguments.weld_mm) +
                                     " mm leaves nothing: " + result.error().message);
    }
    SliceResult sliced = in_ranges ? done_or_thrown(std::move(result)) : done_or_thrown(std::move(result), arguments.name());
    if (arguments.hash && !in_ranges) {
        run.hash = hash_result(sliced);
    }
    return sliced;
}

std::vector<std::string> warnings_of(const SlicedPart& part, std::optional<std::uint64_t> contours,
                                     const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image) {
    const SliceSummary& summary = part.result.summary;
    std::vector<std::string> warnings;
    if (part.open.layers > 0 && !arguments.outputs.strict) {  // which says the same
        warnings.push_back(arguments.name() + (arguments.split ? ", " + part.name : "") + ": " +
                           describe(part.open, "--close-gaps "));
    }
    if (summary.segments == 0) {
        warnings.push_back(why_nothing_is_cut(summary));
    }
    if (summary.emptied_layers > 0 && contours.value_or(part.result.contours.size()) == 0) {
        warnings.push_back(why_nothing_is_left(part.result));
    }
    if (summary.cancelled_layers > 0) {
        warnings.push_back("in " + counted(summary.cancelled_layers, "layer") +
                           " shells turned inwards overlap others, and where they do, both cancel: solid is missing there; "
                           "--orient-shells turns each shell outwards unless it bounds a cavity");
    }
    const std::vector<std::string> doubts = doubts_of(part.result, arguments, mesh, image);
    warnings.insert(warnings.end(), doubts.begin(), doubts.end());
    return warnings;
}

}  // namespace lamella::cli
