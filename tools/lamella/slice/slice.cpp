#include "slice/slice.hpp"

#include <array>
#include <atomic>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>
#include <utility>
#include <variant>

#include "files/flags.hpp"
#include "lamella/medical/table.hpp"
#include "options/asked.hpp"

namespace lamella::cli {

namespace {

// --- flags

/// The heading in the help of what neither prints nor pictures need.
constexpr const char* experiments = "Experiments";

void declare_mending(CLI::App& command, SliceArguments& arguments) {
    add_number(command, "--weld", "MM", "Join vertices at most MM apart before slicing (off)",
               [&arguments](double mm) { arguments.weld_mm = mm; });
    command.add_flag("--orient-shells", arguments.orient_shells,
                     "Turn each closed shell outwards, or inwards where it bounds a cavity, before slicing");
    add_triple(command, "--normal", "Cut perpendicular to this direction",
               [&arguments](const std::array<double, 3>& normal) {
                   const double length = std::hypot(normal[0], normal[1], normal[2]);
                   if (!(length > 0 && std::isfinite(length))) {
                       return " has no direction";
                   }
                   arguments.options.frame.transform = Transform::from_normal(normal[0], normal[1], normal[2]);
                   return "";
               });
}

void declare_experiments(CLI::App& command, SliceArguments& arguments) {
    static constexpr std::array<std::string_view, 2> forms = {"swept", "assembled"};
    Tuning& tuning = arguments.tuning;
    const auto random_heights = [&tuning]() -> RandomHeights& {
        return tuning.random_heights ? *tuning.random_heights : tuning.random_heights.emplace();
    };
    add_range(command, "--random-heights", "Random steps between MIN and MAX mm",
              [random_heights](double least, double most) {
                  random_heights().min_step_mm = least;
                  random_heights().max_step_mm = most;
              })
        ->group(experiments);
    add_count(command, "--seed", "Seed of the random heights (1)",
              [random_heights](std::uint64_t seed) { random_heights().seed = seed; })
        ->needs("--random-heights")
        ->group(experiments);
    add(command, "--band", tuning.band_planes, "N", "Planes swept as one task (0: chosen by the work)")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()))
        ->group(experiments);
    add_choice(command, "--form", forms, "How contours are built (swept); the results are identical", tuning.form)
        ->group(experiments);
    add_choice(command, "--instructions", instruction_set_names,
               "Instructions of the inner loops (the processor's highest); the results are identical",
               [&tuning](std::size_t level) { tuning.instructions = static_cast<InstructionSet>(level); })
        ->group(experiments);
}

void declare_how(CLI::App& command, SliceArguments& arguments) {
    static constexpr std::array<std::string_view, 1> objects = {"objects"};
    command.add_flag("--map", arguments.map_file, "Map the mesh file into memory instead of reading it");
    add_bytes(command, "--memory", "BYTES[k|M|G]",
              "Slice a binary STL or PLY file larger than memory, in ranges of layers within so many bytes (at least 300k a "
              "thread)",
              arguments.memory_bytes);
    add_choice(command, "--split", objects,
               "Make each 3MF object, OBJ object or group, or STL solid a mesh with its own label, ROI and row",
               [&arguments](std::size_t) { arguments.split = arguments.outputs.objects = true; });
    add_text(command, "--negative", arguments.negative, "MESH",
             "Take what is inside this mesh out of all that is sliced, as negative volumes of a 3MF file are");
    command.add_flag("--hash", arguments.hash, "Print the hash of the result");
    add_text(command, "--report", arguments.report, "FILE|-", "JSON report to write; - for standard output");
}

// --- stages

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
class Streams {
public:
    void begin(const OutputJob& job, const std::string& mesh_name, const SliceInfo& info, const Context& context) {
        const ImageGeometry* const image = job.image ? &*job.image : nullptr;
        for (const PlannedOutput& output : job.outputs) {
            output.format == OutputFormat::layers
                ? add(LayerFile::begin(info, output_path(output.path), layer_options(job, output), context))
                : add(LayerTableStream::begin(mesh_name, path_of(output.path), image, job.arguments.islands));
        }
    }

    void add(const LayerView& layer) {
        for (Any& stream : streams_) {
            std::visit([&](auto& one) { one.add(layer); }, stream);
        }
    }

    bool failed() const noexcept { return !begun_ || std::any_of(streams_.begin(), streams_.end(), has_failed); }

    /// Puts the files in their places, or none where some failed before. Throws Failure.
    void finish(const OutputJob& job, const ToldLayers& told) {
        done_or_thrown(begun_);
        // Streams that failed come first: they ended the slicing, and the others lack layers.
        std::stable_partition(streams_.begin(), streams_.end(), has_failed);
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            if (auto* const file = std::get_if<LayerFile>(&streams_[i])) {
                told(job.outputs[i], done_or_thrown(file->finish()));
            } else {
                done_or_thrown(std::get<LayerTableStream>(streams_[i]).finish());
            }
        }
    }

private:
    using Any = std::variant<LayerFile, LayerTableStream>;

    static bool has_failed(const Any& stream) {
        return std::visit([](const auto& one) { return one.failed(); }, stream);
    }

    template <class Stream>
    void add(Result<Stream> stream) {
        if (begun_ && stream) {
            streams_.emplace_back(std::move(stream).value());
        } else if (begun_) {
            begun_ = stream.error();
        }
    }

    std::vector<Any> streams_;
    Status begun_;
};

template <class T>
void copy_to(Array<T>& array, const std::vector<T>& from) {
    array.resize_discarding(from.size());
    std::copy(from.begin(), from.end(), array.begin());
}

// --- the summary

std::string planes_line(const SliceInfo& info, const ToolRun& run) {
    const bool all = info.layers == info.planned_layers;
    const std::optional<RandomHeights>& random = run.random_heights;
    return "planes    " + grouped(info.layers) +
           (all ? "" : " from " + std::to_string(info.first_layer) + " on, of " + grouped(info.planned_layers)) + ": " +
           (random ? exact_text(random->min_step_mm) + " to " + exact_text(random->max_step_mm) + " mm apart by seed " +
                         std::to_string(random->seed) + ", from the mesh's lowest vertex up"
                   : heights_in_short(info.options)) +
           "\nrounding  as a vertex, then " + side_in_short(info.options) + ", grid " + exact_text(info.grid_mm) + " mm\n";
}

/// How closed contours became regions, what was left as it is, and layers in which nothing is left of what the mesh has
/// there.
std::string regions(const SliceResult& result) {
    const RegionRules& rules = result.info.options.region;
    std::string text = rules_in_short(rules, counted(result.info.would_close_contours, "contour"));
    const std::uint64_t emptied = result.info.emptied_layers;
    if (rules.keeps_contours() || emptied == 0) {
        return text;
    }
    const auto crossed = static_cast<std::uint64_t>(
        std::count_if(result.layers.begin(), result.layers.end(), [](const Layer& layer) { return layer.segments > 0; }));
    return text + "emptied   " + (emptied == crossed ? "all " : grouped(emptied) + " of ") + counted(crossed, "layer") +
           " that the mesh crosses\n";
}

/// Lines on the work beyond cutting, if any.
std::string mending(const SlicedPart& part, const ReportParts& parts, const ToolRun& run) {
    const SliceResult& result = part.result;
    std::string text;
    if (parts.welded != nullptr) {
        text += "welded    " + counted(parts.welded->joined, "vertex", "vertices") + " onto others at most " +
                exact_text(parts.welded->tolerance_mm) + " mm away, the farthest " +
                measure_text(parts.welded->largest_move_mm) + " mm\n";
    }
    text += when(run.shells > 0,
                 "oriented  " + counted(run.turned_shells, "shell") + " turned, of " + grouped(run.shells) + "\n");
    if (!result.stitches.empty()) {
        double longest = 0;
        for (const auto& [layer, from, to] : result.stitches) {
            longest = std::max(longest, std::hypot(static_cast<double>(to.x) - from.x, static_cast<double>(to.y) - from.y) *
                                            result.info.grid_mm);
        }
        text += "gaps      " + grouped(result.stitches.size()) + " closed of up to " + measure_text(part.reach_mm()) +
                " mm, the longest " + measure_text(longest) + " mm\n";
    }
    return text + regions(result);
}

std::string times(const SliceInfo& info, const ToolRun& run) {
    std::map<std::string_view, double> ms = run.ms;
    ms["fill"] = info.ms.fill;
    std::erase_if(ms, [](const auto& stage) { return stage.second == 0; });  // what was not asked for
    ms.insert({{"bucket", info.ms.bucket},
               {"sweep", info.ms.sweep},
               {"contours", info.ms.contours},
               {"nesting", info.ms.nesting}});
    std::string text = "time      " + rounded(ms["total"], 1) + " ms: read " + rounded(ms["read"], 1);
    for (const char* const what : {"parse", "weld", "heights", "bucket", "sweep", "contours", "nesting", "fill", "write",
                                   "ledger", "certificate", "crossings", "report"}) {
        if (const auto took = ms.find(what); took != ms.end()) {
            text.append(", ").append(what).append(" ").append(rounded(took->second, 1));
        }
    }
    return text + " (" + counted(static_cast<std::uint64_t>(info.threads), "thread") + ", " + counted(info.bands, "band") +
           ")\n";
}

std::string volume_line(const VolumeCertificate& volume) {
    if (!volume.applies()) {
        return "volume    " + words_for(volume) + "\n";
    }
    std::string text = "volume    " + measure_text(volume.mesh_mm3) + " mm3, ";
    if (volume.verdict == VolumeVerdict::volumes_differ) {
        text += "but the slabs between planes sum to " + measure_text(volume.slabs_mm3) + " mm3";
    } else {
        text += volume.verdict == VolumeVerdict::holds ? "certified" : "but areas differ";
    }
    if (volume.worst_allowed_mm2 > 0) {
        text += "; areas differ most in layer " + std::to_string(volume.worst_layer) + ", by " +
                rounded(100 * volume.worst_difference_mm2 / volume.worst_allowed_mm2, 0) + " % of what rounding may do";
    }
    return text + "\n";
}

/// Lines on the report's findings, if there is a report.
std::string findings(const ReportParts& parts) {
    if (parts.audit == nullptr) {
        return {};
    }
    std::string text;
    if (const std::optional<Ledger>& books = parts.audit->ledger) {
        text += "unseen    between planes: shells " + grouped(books->shells.count) + ", peaks " +
                grouped(books->peaks.count) + ", pits " + grouped(books->pits.count) + ", triangles " +
                grouped(books->between) + "\n";
    }
    if (parts.audit->volume) {
        text += volume_line(*parts.audit->volume);
    }
    if (const std::optional<Crossings>& found = parts.audit->crossings; found && found->count > 0) {
        text += "crossings " + std::string(found->at_least ? "at least " : "") + grouped(found->count) +
                " of contours, in layers " + grouped(found->layers.size()) + "\n";
    }
    return text;
}

}  // namespace

void declare(CLI::App& command, SliceArguments& arguments) {
    add_text(command, "mesh", arguments.meshes, "MESH|-", mesh_help("Mesh files, or - for standard input"))->required();
    declare_reading(command, arguments);
    declare_quiet(command, arguments);
    declare_outputs(command, arguments.outputs);
    declare_image(command, arguments.image);
    declare_options(command, arguments.options);
    declare_mending(command, arguments);
    declare_experiments(command, arguments);
    declare_how(command, arguments);
    const auto exclude = [&command](const char* one, std::initializer_list<const char*> others) {
        for (const char* const other : others) {
            command.get_option(one)->excludes(command.get_option(other));
        }
    };
    exclude("--layer-height", {"--planes", "--random-heights"});
    exclude("--planes", {"--random-heights", "--first-height", "--datum"});
    exclude("--random-heights", {"--first-height", "--datum"});
    exclude("--normal", {"--transform"});
    exclude("--memory", {"--weld", "--orient-shells", "--map", "--split"});
    declare_adaptive(command, arguments);
    for (const char* const image : {"--like", "--spacing"}) {
        exclude(image,
                {"--layer-height", "--planes", "--random-heights", "--first-height", "--datum", "--normal", "--transform"});
    }
}

void cut_at(SliceOptions& options, std::vector<double> heights) {
    options.heights_mm = std::move(heights);
    options.planes.first_height_mm.reset();
    options.planes.datum = Datum::mesh_min;
}

std::vector<std::string> warnings_of(const SlicedPart& part, const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image) {
    const SliceInfo& info = part.result.info;
    std::vector<std::string> warnings;
    if (part.open.layers > 0 && !arguments.outputs.strict) {  // which says the same
        warnings.push_back(arguments.name() + (arguments.split ? ", " + part.name : "") + ": " + part.open_words());
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

std::function<void(const ToldLayers&)> slice_streamed(const OutputJob& job, SlicedPart& part, const Source& mesh,
                                                      const SliceOptions& options, const Tuning& tuning, bool hash,
                                                      Context context) {
    const auto streams = std::make_shared<Streams>();
    const Context asked{.threads = context.threads, .stop = context.stop};
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
            streams->begin(job, part.name, info, asked);
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
            streams->add(view);
        });
    };
    const auto stop = [&]() noexcept { return out_of_memory || streams->failed() || (asked.stop && asked.stop()); };
    context.stop = stop;
    Slicer slicer;
    const LayerSink sink{.take = take, .begin = begin};
    const Result<SliceInfo> info = slice_tuned(slicer, sink, mesh, options, tuning, context);
    refuse_if(out_of_memory, bad_input, "out of memory");
    if (streams->failed()) {
        streams->finish(job, {});  // throws
    }
    part.result.info = done_or_thrown(info);  // messages name the file
    copy_to(part.result.layers, layers);
    copy_to(part.result.stitches, stitches);
    if (hashes) {
        part.hash = hashes->value();
    }
    return [streams, &job](const ToldLayers& told) { streams->finish(job, told); };
}

std::vector<ReportMember> members_of(const ToolRun& run) {
    decltype(ReportMember::value) output = nullptr;
    if (run.outputs.size() == 1) {
        output = std::string_view(run.outputs.front());
    } else if (!run.outputs.empty()) {
        output = std::span<const std::string>(run.outputs);
    }
    std::vector<ReportMember> members = {{ReportPlace::after_mesh, "output", output}};
    for (const char* const what : {"read", "parse", "weld", "write", "ledger", "certificate", "crossings", "total"}) {
        const auto found = run.ms.find(what);
        members.push_back({ReportPlace::in_times, what, found == run.ms.end() ? 0 : found->second});
    }
    members.push_back({ReportPlace::after_times, "peak_rss_bytes", run.peak_rss_bytes});
    members.push_back({ReportPlace::at_end, "warnings", std::span<const std::string>(run.warnings)});
    return members;
}

std::string summary(const SlicedPart& part, const ReportParts& parts, const ToolRun& run) {
    const SliceInfo& info = part.result.info;
    std::string text = "mesh      " + input_name(std::string(parts.mesh_name)) + ", " + counted(info.triangles, "triangle") +
                       ", " + description(*parts.file) +
                       when(info.degenerate > 0, "; " + grouped(info.degenerate) + " degenerate, dropped") + "\n";
    text += planes_line(info, run) + mending(part, parts, run);
    text += "segments  " + grouped(info.segments) + "\ncontours  " + grouped(info.contours) + ", of them holes " +
            grouped(info.holes) + ", open " + grouped(info.open_contours);
    text += when(info.flat_contours > 0, ", without area " + grouped(info.flat_contours));
    text += when(info.overruled_contours > 0, ", turned against their facets " + grouped(info.overruled_contours)) + "\n";
    text += when(part.open.layers > 0, "open      " + part.open_words() + "\n");
    text += when(run.print_hash && part.hash, "hash      " + hex_text(part.hash.value_or(0)) + "\n");
    return text + findings(parts) + times(info, run) + "memory    " + file_size_text(run.peak_rss_bytes) + " at the peak\n" +
           run.ranges + wrote(run.outputs, run.words);
}

}  // namespace lamella::cli
