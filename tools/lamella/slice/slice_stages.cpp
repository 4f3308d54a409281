#include "slice/slice.hpp"

#include <atomic>
#include <cmath>
#include <memory>
#include <utility>

#include "files/streams.hpp"
#include "lamella/io/svg.hpp"
#include "lamella/medical/table.hpp"
#include "outputs/outputs.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

/// The least distance between two planes at different heights, if there are two.
std::optional<double> least_plane_distance(const SliceOptions& options) {
    if (!options.heights_mm) {
        return options.layer_height_mm;
    }
    std::optional<double> least;
    std::vector<double> heights = *options.heights_mm;
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    for (std::size_t i = 1; i < heights.size(); ++i) {
        least = std::min(least.value_or(heights[i] - heights[i - 1]), heights[i] - heights[i - 1]);
    }
    return least;
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

/// Outputs that take one layer after the other.
struct Streams {
    std::vector<SvgStream> svgs;
    std::vector<LayerTableStream> tables;
    Status begun;

    template <class Use>
    void for_each(Use use) {
        std::for_each(svgs.begin(), svgs.end(), use);
        std::for_each(tables.begin(), tables.end(), use);
    }

    void begin(const OutputJob& job, const std::string& mesh_name, const SliceInfo& info) {
        const ImageGeometry* const image = job.image ? &*job.image : nullptr;
        const auto add = [this](auto stream, auto& streams) {
            if (stream) {
                streams.push_back(std::move(stream).value());
            } else {
                begun = stream.error();
            }
        };
        for (auto output = job.outputs.begin(); begun && output != job.outputs.end(); ++output) {
            output->format == OutputFormat::svg ? add(SvgStream::begin(info, output_path(output->path)), svgs)
                                                : add(LayerTableStream::begin(mesh_name, output->path, image), tables);
        }
    }

    bool failed() noexcept {
        bool any = !begun;
        for_each([&](const auto& stream) { any = any || stream.failed(); });
        return any;
    }

    /// Puts the files in their places, or none where some failed before. Throws Failure.
    void finish() {
        Status status = begun;
        // Streams that failed come first: they ended the slicing, and the others lack layers.
        for (const bool failed : {true, false}) {
            for_each([&](auto& stream) { status = status && stream.failed() == failed ? stream.finish() : status; });
        }
        done_or_thrown(status);
    }
};

template <class T>
void copy_to(Array<T>& array, const std::vector<T>& from) {
    array.resize_discarding(from.size());
    std::copy(from.begin(), from.end(), array.begin());
}

}  // namespace

std::vector<std::string> warnings_of(const SlicedPart& part, const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image) {
    const SliceInfo& info = part.result.info;
    std::vector<std::string> warnings;
    if (part.open.layers > 0 && !arguments.outputs.strict) {  // which says the same
        warnings.push_back(arguments.name() + (arguments.split ? ", " + part.name : "") + ": " + said_of(part.open));
    }
    if (info.segments == 0) {
        warnings.push_back("no plane meets the mesh, which reaches from " + exact_text(info.box.min_mm[2]) + " to " +
                           exact_text(info.box.max_mm[2]) + " mm along the slicing direction");
    }
    if (info.emptied_layers > 0 && info.contours == 0) {
        const double offset_mm = info.options.region.offset_mm;
        warnings.push_back((offset_mm < 0 ? "an offset of " + exact_text(offset_mm) + " mm" : "the fill rule") +
                           " leaves nothing: " +
                           (info.emptied_layers == 1
                                ? "the one layer that the mesh crosses is empty"
                                : "all " + counted(info.emptied_layers, "layer") + " that the mesh crosses are empty"));
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

std::function<void()> slice_streamed(const OutputJob& job, SlicedPart& part, const Source& mesh, const SliceOptions& options,
                                     const Tuning& tuning, bool hash, Context context) {
    const auto streams = std::make_shared<Streams>();
    const Context asked{.stop = context.stop};
    std::atomic<bool> out_of_memory = false;
    std::optional<LayerHash> hashes;
    std::vector<Layer> layers;
    std::vector<Stitch> stitches;
    const auto guard = [&](const auto& call) noexcept {
        try {
            call();
        } catch (...) {
            out_of_memory = true;
        }
    };
    const auto begin = [&](const SliceInfo& info) noexcept {
        guard([&] {
            if (hash || std::any_of(job.outputs.begin(), job.outputs.end(), std::mem_fn(&PlannedOutput::has_record))) {
                hashes.emplace(info.layers);
            }
            streams->begin(job, part.name, info);
        });
    };
    const auto take = [&](const LayerView& view) noexcept {
        guard([&] {
            if (hashes) {
                hashes->add(view);
            }
            layers.push_back(view);
            const Result<OpenLayers> open = find_open_layer(view, options.stitch_direction, asked);
            out_of_memory = out_of_memory || (!open && open.error().code == ErrorCode::out_of_memory);
            part.open.add(open ? *open : OpenLayers{});
            stitches.insert(stitches.end(), view.stitches.begin(), view.stitches.end());
            streams->for_each([&](auto& stream) { stream.add(view); });
        });
    };
    const auto stop = [&]() noexcept { return out_of_memory || streams->failed() || (asked.stop && asked.stop()); };
    context.stop = stop;
    Slicer slicer;
    const LayerSink sink{.take = take, .begin = begin};
    const Result<SliceInfo> info = slice_tuned(slicer, sink, mesh, options, tuning, context);
    refuse_if(out_of_memory, bad_input, "out of memory");
    if (streams->failed()) {
        streams->finish();  // throws
    }
    part.result.info = done_or_thrown(info);  // messages name the file
    copy_to(part.result.layers, layers);
    copy_to(part.result.stitches, stitches);
    if (hashes) {
        part.hash = hashes->value();
    }
    return [streams] { streams->finish(); };
}

}  // namespace lamella::cli
