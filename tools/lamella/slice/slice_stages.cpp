#include "slice/slice_stages.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "files/streams.hpp"
#include "outputs/planned_outputs.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

/// For what a mesh larger than memory does not leave in it.
std::filesystem::path folder_beside(const SliceArguments& arguments) {
    const char* const asked = std::getenv("TMPDIR");
    // Else beside the output: the system's own folder is often held in memory.
    if ((asked == nullptr || *asked == 0) && !arguments.outputs.outputs.empty() && !arguments.output_to_stdout()) {
        const std::filesystem::path folder = std::filesystem::path(arguments.outputs.outputs.front()).parent_path();
        return folder.empty() ? "." : folder;
    }
    return temporary_folder();
}

std::string why_nothing_is_cut(const Box& box) {
    return "no plane meets the mesh, which reaches from " + exact_text(box.min_mm[2]) + " to " + exact_text(box.max_mm[2]) +
           " mm along the slicing direction";
}

std::string why_nothing_is_left(const SliceInfo& info) {
    const double offset_mm = info.options.region.offset_mm;
    return (offset_mm < 0 ? "an offset of " + exact_text(offset_mm) + " mm" : "the fill rule") + " leaves nothing: " +
           (info.emptied_layers == 1 ? "the one layer that the mesh crosses is empty"
                                     : "all " + counted(info.emptied_layers, "layer") + " that the mesh crosses are empty");
}

std::vector<std::string> doubts_of(const SliceInfo& info, const SliceArguments& arguments, const MeshFile& mesh,
                                   const std::optional<ImageGeometry>& image) {
    const std::optional<double> distance =
        arguments.tuning.random_heights ? arguments.tuning.random_heights->min_step_mm : least_plane_distance(info.options);
    MeasuredMesh measured{.box = info.box,
                          .grid_mm = info.grid_mm,
                          .plane_distance_mm = distance,
                          .detail_mm = distance.value_or(common_layer_mm),
                          .moved = !arguments.options.frame.transform.is_identity()};
    if (image) {
        measured.detail_mm = std::min({measured.detail_mm, image->spacing_mm[0], image->spacing_mm[1]});
        for (const std::array<double, 3>& corner : {info.box.min_mm, info.box.max_mm}) {
            for (const double at : image->to_lps(corner)) {
                measured.farthest_mm = std::max(measured.farthest_mm.value_or(0), std::abs(at));
            }
        }
    }
    return doubts_of_scale(arguments, mesh, measured);
}

template <class T>
void copy_to(Array<T>& array, const std::vector<T>& from) {
    array.resize_discarding(from.size());
    std::copy(from.begin(), from.end(), array.begin());
}

}  // namespace

MeshToSlice read_for_slicing(const SliceArguments& arguments, Stages& stages) {
    MeshToSlice mesh;
    if (arguments.in_ranges()) {
        const StreamOptions options{.memory_bytes = arguments.memory_bytes,
                                    .temporary_folder = folder_beside(arguments),
                                    .read = {.mm_per_unit = arguments.unit_mm.value_or(1)}};
        mesh.stream = done_or_thrown(open_mesh(arguments.mesh, options));
    } else {
        mesh.file = read_mesh_of(arguments, stages.bar());
    }
    mesh.warnings = mesh.about().warnings;
    const PatientFrame asked = arguments.image.frame;
    const PatientFrame stated = mesh.about().patient_frame;
    if (asked != PatientFrame::unstated && stated != PatientFrame::unstated && stated != asked) {
        mesh.warnings.push_back(arguments.name() + ": states the patient frame " + std::string(name_of(stated)) +
                                ", which holds instead of --frame " + std::string(name_of(asked)));
    }
    return mesh;
}

void mend(MeshToSlice& mesh, const SliceArguments& arguments, Stages& stages, ToolRun& run) {
    mesh.welded.reset();
    mesh.oriented.reset();
    if (arguments.weld_mm) {
        const auto join = [&](const Context& context) { return weld(mesh.view(), *arguments.weld_mm, context); };
        const Stopwatch watch;
        mesh.welded = done_or_thrown(stages.run("welding", join), arguments.name());
        run.ms["weld"] = watch.ms();
    }
    if (arguments.orient_shells) {
        const auto turn = [&](const Context& context) { return orient_shells(mesh.view(), 0, context); };
        mesh.oriented = done_or_thrown(stages.run("turning shells", turn), arguments.name());
        run.shells = mesh.oriented->shells;
        run.turned_shells = mesh.oriented->turned_shells;
    }
}

ImageGeometry image_for(const std::vector<MeshToSlice>& meshes, const SliceArguments& arguments) {
    if (!arguments.image.like.empty()) {
        return done_or_thrown(read_image_geometry(arguments.image.like));
    }
    const std::vector<double> spacing = parse_triple(arguments.image.spacing, "--spacing");
    Box all;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        SliceOptions options = arguments.options;
        const PatientFrame frame = patient_frame_of(meshes[i].about(), arguments.image, arguments.meshes[i]);
        cut_at(options, {});
        options.frame.transform = ImageGeometry{}.slicing_frame(frame);
        const Box box = done_or_thrown(Slicer().outline(meshes[i].source(), options)).box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            all.min_mm[axis] = i == 0 ? box.min_mm[axis] : std::min(all.min_mm[axis], box.min_mm[axis]);
            all.max_mm[axis] = i == 0 ? box.max_mm[axis] : std::max(all.max_mm[axis], box.max_mm[axis]);
        }
    }
    return done_or_thrown(geometry_around(all, {spacing[0], spacing[1], spacing[2]}));
}

std::vector<std::string> warnings_of(const SlicedPart& part, const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image) {
    const SliceInfo& info = part.result.info;
    std::vector<std::string> warnings;
    if (part.open.layers > 0 && !arguments.outputs.strict) {  // which says the same
        warnings.push_back(arguments.name() + (arguments.split ? ", " + part.name : "") + ": " +
                           describe(part.open, "--stitch "));
    }
    if (info.segments == 0) {
        warnings.push_back(why_nothing_is_cut(info.box));
    }
    if (info.emptied_layers > 0 && info.contours == 0) {
        warnings.push_back(why_nothing_is_left(info));
    }
    if (info.cancelled_layers > 0) {
        warnings.push_back("in " + counted(info.cancelled_layers, "layer") +
                           " shells turned inwards overlap others, and where they do, both cancel: solid is missing there; "
                           "--orient-shells turns each shell outwards unless it bounds a cavity");
    }
    const std::vector<std::string> doubts = doubts_of(info, arguments, mesh, image);
    warnings.insert(warnings.end(), doubts.begin(), doubts.end());
    return warnings;
}

bool StreamedOutputs::serve(const std::vector<PlannedOutput>& outputs) {
    return std::all_of(outputs.begin(), outputs.end(), [](const PlannedOutput& output) {
        return output.format == OutputFormat::svg || output.format == OutputFormat::csv ||
               output.format == OutputFormat::json_lines;
    });
}

Status StreamedOutputs::slice(SlicedPart& part, const Source& mesh, const SliceOptions& options, const Tuning& tuning,
                              bool hash, Context context) {
    const Context asked{.stop = context.stop};
    const auto stop = [&]() noexcept { return out_of_memory_ || failed() || (asked.stop && asked.stop()); };
    hash = hash ||
           std::any_of(outputs_.begin(), outputs_.end(), [](const PlannedOutput& output) { return output.has_record(); });
    const auto begin_all = [&](const SliceInfo& info) noexcept { begin(info, hash); };
    const auto take_layer = [&](const LayerView& view) noexcept { take(view, asked); };
    context.stop = stop;
    direction_ = options.stitch_direction;
    Slicer slicer;
    const LayerSink sink{.take = take_layer, .begin = begin_all};
    const Result<SliceInfo> info = slice_tuned(slicer, sink, mesh, options, tuning, context);
    if (out_of_memory_) {
        return Error{ErrorCode::out_of_memory, "out of memory"};
    }
    if (failed()) {
        finish();  // throws
    }
    if (!info) {
        return info.error();
    }
    copy_to(part.result.layers, layers_);
    copy_to(part.result.stitches, stitches_);
    part.result.info = *info;
    if (hash_) {
        part.hash = hash_->value();
    }
    part.open = open_;
    return {};
}

void StreamedOutputs::begin(const SliceInfo& info, bool hash) noexcept {
    if (hash) {
        hash_.emplace(info.layers);
    }
    try {
        const auto add = [this](auto begun, auto& streams) {
            if (begun) {
                streams.push_back(std::move(begun).value());
            } else {
                begun_ = begun.error();
            }
        };
        for (auto output = outputs_.begin(); begun_ && output != outputs_.end(); ++output) {
            output->format == OutputFormat::svg ? add(SvgStream::begin(info, output_path(output->path)), svgs_)
                                                : add(LayerTableStream::begin(mesh_name_, output->path, image_), tables_);
        }
    } catch (...) {
        out_of_memory_ = true;
    }
}

void StreamedOutputs::take(const LayerView& view, const Context& context) noexcept {
    if (hash_) {
        hash_->add(view);
    }
    try {
        layers_.push_back(view);
        const Result<OpenLayers> open = find_open_layer(view, direction_, context);
        out_of_memory_ = out_of_memory_ || (!open && open.error().code == ErrorCode::out_of_memory);
        open_.add(open ? *open : OpenLayers{});
        stitches_.insert(stitches_.end(), view.stitches.begin(), view.stitches.end());
    } catch (...) {
        out_of_memory_ = true;
    }
    for_each([&](auto& stream) { stream.add(view); });
}

bool StreamedOutputs::failed() noexcept {
    bool any = !begun_;
    for_each([&](const auto& stream) { any = any || stream.failed(); });
    return any;
}

void StreamedOutputs::finish() {
    Status status = begun_;
    // Streams that failed come first: they ended the slicing, and the others lack layers.
    for (const bool failed : {true, false}) {
        for_each([&](auto& stream) { status = status && stream.failed() == failed ? stream.finish() : status; });
    }
    done_or_thrown(status);
}

}  // namespace lamella::cli
