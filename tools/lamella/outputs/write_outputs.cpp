#include "outputs/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "files/flags.hpp"
#include "files/mesh_input.hpp"
#include "lamella/version.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

using Note = std::function<void(const std::string&)>;

/// The parts as a writer takes them.
template <class Make>
auto parts_of(const OutputJob& job, Make make) {
    std::vector<decltype(make(job.parts.front()))> parts;
    for (const SlicedPart& part : job.parts) {
        parts.push_back(make(part));
    }
    return parts;
}

void note_beyond_slices(const OutputJob& job, const SlicedPart& part, const PlannedOutput& output, const Note& note) {
    const Box& mesh = part.result.info.box;
    const std::vector<double> heights = job.image->slice_heights_mm();
    const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
    const double half = job.image->spacing_mm[2] / 2;
    const double beyond = std::max({0.0, *low - half - mesh.min_mm[2], mesh.max_mm[2] - *high - half});
    if (beyond > 1e-3 * job.image->spacing_mm[2]) {  // else rounding, as of an image around the mesh
        note(output.path + ": " + part.name + " reaches " + rounded(beyond, 3) + " mm beyond the image's slices");
    }
}

/// Voxels are in by their centres, which thin walls slip between.
void note_thin_walls(const OutputJob& job, const SlicedPart& part, double wall_mm, const PlannedOutput& output,
                     const Note& note) {
    const Box& mesh = part.result.info.box;
    const std::array<double, 3>& voxel = job.image->spacing_mm;
    const auto thin = [&](std::size_t axis) { return mesh.max_mm[axis] - mesh.min_mm[axis] < voxel[axis]; };
    const bool in_slices = !job.arguments.coverage && (wall_mm < std::min(voxel[0], voxel[1]) || thin(0) || thin(1));
    if (in_slices || (job.subslices == 1 && thin(2))) {
        note(output.path + ": " + part.name + " is thinner than a voxel: its box is " +
             measure_text(mesh.max_mm[0] - mesh.min_mm[0]) + " x " + measure_text(mesh.max_mm[1] - mesh.min_mm[1]) + " x " +
             measure_text(mesh.max_mm[2] - mesh.min_mm[2]) + " mm" +
             (std::isnan(wall_mm) ? "" : ", its walls " + measure_text(wall_mm) + " mm on average") +
             "; --coverage --subslices 8 writes how much of each voxel is inside");
    }
}

std::vector<MaskPart> mask_parts_of(const OutputJob& job) {
    return parts_of(job, [](const SlicedPart& part) { return MaskPart{&part.result, part.labelled(), part.terms}; });
}

/// What cannot be seen in a mask.
void note_mask(const OutputJob& job, const PlannedOutput& output, const MaskSummary& summary, const Note& note) {
    if (summary.overlapped_voxels > 0) {
        note(output.path + ": " + counted(summary.overlapped_voxels, "voxel") +
             (summary.overlapped_voxels == 1 ? " lies" : " lie") + " in several meshes; the later label holds");
    }
    for (std::size_t i = 0; i < summary.cut_off_share.size(); ++i) {
        const std::string& name = job.parts[i].name;
        if (summary.cut_off_share[i] > 0) {
            const double share = summary.cut_off_share[i];
            note(output.path + ": the image cuts off " + (share < 0.0001 ? "less than 0.01" : rounded(share * 100, 2)) +
                 " % of the area of " + name);
        }
        note_beyond_slices(job, job.parts[i], output, note);
        note_thin_walls(job, job.parts[i], summary.mean_wall_mm[i], output, note);
        if (summary.voxels[i] == 0) {
            note(output.path + ": no voxel lies in " + name);
        }
    }
}

void note_renamed(const OutputJob& job, const PlannedOutput& output, const std::vector<std::string>& written,
                  const char* whose, const Note& note) {
    for (std::size_t i = 0; i < written.size(); ++i) {
        if (const std::string& name = job.parts[i].labelled(); written[i] != name) {
            note(output.path + ": the name '" + name + "' is written as '" + written[i] + "': a " + whose +
                 " has at most 64 characters, of the CT's character set, and none repeats");
        }
    }
}

/// Of a call whose options were seen before: what it refuses is the input.
template <class T>
T done_or_bad_input(Result<T> result) {
    if (!result) {
        const Failure failure = failure_of(result.error());
        throw Failure(failure.status() == bad_usage ? bad_input : failure.status(), failure.what());
    }
    return std::move(result).value();
}

void write_segmentation_of(const OutputJob& job, const PlannedOutput& output, const Context& context, const Note& note) {
    const SegmentationOptions options{.coverage = job.arguments.coverage,
                                      .subslices = job.subslices,
                                      .without_ct = job.arguments.without_ct,
                                      .seconds_since_1970 = source_date()};
    const SegmentationSummary written =
        done_or_bad_input(write_segmentation(mask_parts_of(job), *job.image, path_of(output.path), options, context));
    note_renamed(job, output, written.segment_names, "segment's", note);
    note_mask(job, output, written.mask, note);
}

void write_structure_set_of(const OutputJob& job, const PlannedOutput& output, const Context& context, const Note& note) {
    if (!job.image) {  // an archive that was sliced without one
        throw Failure(bad_input, "'" + output.path + "': no image says where the slices lie in the patient");
    }
    std::size_t next = 0;
    const auto rois = parts_of(job, [&](const SlicedPart& part) {
        return Roi{&part.result, part.labelled(), part.terms.colour_of(next++)};
    });
    const StructureSetOptions options{.holes = job.arguments.holes.value_or(HoleForm::keyhole),
                                      .without_ct = job.arguments.without_ct,
                                      .seconds_since_1970 = source_date()};
    const StructureSetSummary written =
        done_or_bad_input(write_structure_set(rois, *job.image, path_of(output.path), options, context));
    note_renamed(job, output, written.roi_names, "ROI's", note);
    if (written.nested_contours > 0) {
        note(output.path + ": " + counted(written.nested_contours, "contour") +
             " in the solid part of others, which readers may take for holes; --fill-rule non-zero unites them");
    }
}

/// What a file of layers cannot show of the slice.
void note_layers(OutputJob& job, const PlannedOutput& output, const LayerFileSummary& summary, const Note& note) {
    static constexpr std::array<std::string_view, 3> heights = {"bottom", "plane", "top"};
    std::array<char, 16> rounding{};
    (void)std::snprintf(rounding.data(), rounding.size(), "%.1g", summary.rounding_mm);
    job.words[output.path] = when(summary.files != 1, counted(summary.files, "file") + ", ") +
                             counted(summary.layers, "layer") +
                             ", z = " + std::string(heights[static_cast<std::size_t>(summary.format->height)]) +
                             when(summary.rounding_mm > 0, std::string(", rounded by ") + rounding.data() + " mm");
    if (summary.names_changed > 0) {
        note(output.path + ": " + counted(summary.names_changed, "name") +
             " of parts written with other characters, for readers of the format");
    }
    if (summary.open_left_out > 0) {
        note(output.path + ": " + counted(summary.open_left_out, "open contour") + " left out, which " +
             std::string(output.layer_format) + " cannot hold");
    }
    if (output.layer_format.starts_with("cli") && job.parts.front().result.info.box.min_mm[2] < 0) {
        note(output.path + ": the mesh reaches below z = 0, where some readers of CLI leave layers out");
    }
}

void write_one(OutputJob& job, const PlannedOutput& output, const Context& context, const Note& note) {
    const ImageGeometry* const image = job.image ? &*job.image : nullptr;
    switch (output.format) {
        case OutputFormat::layers: {
            const SliceResult& result = job.whole ? *job.whole : job.parts.front().result;
            const LayerFileOptions options = layer_options(job, output);
            return note_layers(job, output, done_or_thrown(write_layers(result, output_path(output.path), options, context)),
                               note);
        }
        case OutputFormat::mask:
            return note_mask(
                job, output,
                done_or_thrown(write_mask(mask_parts_of(job), *job.image, path_of(output.path),
                                          {.coverage = job.arguments.coverage, .subslices = job.subslices}, context)),
                note);
        case OutputFormat::segmentation:
            return write_segmentation_of(job, output, context, note);
        case OutputFormat::structure_set:
            write_structure_set_of(job, output, context, note);
            for (const SlicedPart& part : job.parts) {
                note_beyond_slices(job, part, output, note);
            }
            return;
        case OutputFormat::table:
            return done_or_thrown(write_layer_table(
                parts_of(job,
                         [](const SlicedPart& part) {
                             return TablePart{&part.result, part.name, part.facts ? &*part.facts : nullptr};
                         }),
                path_of(output.path), image, job.arguments.islands, context));
        case OutputFormat::png: {
            const auto parts = parts_of(job, [](const SlicedPart& part) { return PicturePart{&part.result, part.name}; });
            const std::optional<std::uint64_t> layer = job.arguments.picture_layer;
            return done_or_thrown(layer ? write_layer_picture(parts, *layer, path_of(output.path), {.image = image}, context)
                                        : write_contact_sheet(parts, path_of(output.path), {.image = image}, context));
        }
        case OutputFormat::hdf5: {
            const SlicedPart& part = job.parts.front();
            ArchiveInfo info{.name = part.name,
                             .mesh_sha256 = part.mesh_sha256,
                             .frame = part.frame,
                             .geometry = job.image,
                             .subslices = job.subslices};
            if (part.welded) {
                info.weld = ArchiveWeld{part.welded->tolerance_mm, part.welded->joined};
            }
            return done_or_thrown(write_archive(part.result, info, path_of(output.path), context));
        }
    }
}

Record record_of(const OutputJob& job, const PlannedOutput& output) {
    static constexpr std::array of_layers = {"--screen", "--pixel",    "--mirror",         "--turn",     "--levels",
                                             "--place",  "--exposure", "--first-exposure", "--leave-out"};
    Record record;
    record.command = job.command;
    record.inputs = job.inputs;
    for (const RecordedOption& option : job.options) {
        const std::string& name = option.name;
        if ((name == "--holes" && output.format != OutputFormat::structure_set) ||
            (name == "--without-ct" && !output.is_dicom()) || (name == "--coverage" && !output.is_mask()) ||
            (name == "--islands" && output.format != OutputFormat::table) ||
            (name == "--picture-layer" && output.format != OutputFormat::png) ||
            std::find(of_layers.begin(), of_layers.end(), name) != of_layers.end()) {
            continue;  // it says nothing of this output
        }
        record.options.push_back(name);
        if (option.value) {
            record.options.push_back(*option.value);
        }
    }
    if (const char* const epoch = std::getenv("SOURCE_DATE_EPOCH")) {
        record.source_date_epoch = epoch;
    }
    record.patient_frame = name_of(job.parts.front().frame);
    record.fill_rule = name_of(job.parts.front().result.info.options.region.fill_rule);
    for (const SlicedPart& part : job.parts) {
        record.grid_mm.push_back(part.result.info.grid_mm);
        record.stitch_mm.push_back(part.reach_mm());
        record.result_hashes.push_back(hex_text(part.hash ? *part.hash : part.result.hash()));
    }
    return record;
}

}  // namespace

bool is_recorded(const std::string& name) {
    static constexpr std::array<std::string_view, 14> without_effect = {
        "",  // hidden options have no name
        "mesh",     "archives", "parts", "--output", "--to",   "--threads", "--progress",
        "--report", "--quiet",  "--map", "--band",   "--form", "--help"};
    return std::find(without_effect.begin(), without_effect.end(), name) == without_effect.end();
}

bool is_flag(const CLI::Option& option) {
    return option.get_items_expected_max() == 0;
}

bool RecordedOption::names_file() const {
    return name == "--like" || name == "--negative" || name == "--label-table" || is_file_of(name, value.value_or(""));
}

std::vector<RecordedOption> recorded_options(const CLI::App& slice_command) {
    std::vector<RecordedOption> options;
    for (const CLI::Option* option : slice_command.get_options()) {
        const std::string name = option->get_name();
        for (const ChangedDefault& changed : changed_defaults) {
            if (option->count() == 0 && name == changed.name) {
                options.push_back({name, std::string(changed.now)});
            }
        }
        if (option->count() == 0 || !is_recorded(name)) {
            continue;
        }
        if (is_flag(*option)) {
            options.push_back({name, std::nullopt});
            continue;
        }
        for (const std::string& value : option->results()) {
            options.push_back({name, value});
        }
    }
    return options;
}

bool takes_record(const PlannedOutput& output) {
    return output.has_record() && std::filesystem::is_regular_file(path_of(output.path));
}

void write_record_beside(const PlannedOutput& output, Record record, const Context& context) {
    record.version = version;
    record.output = done_or_thrown(seal_file(path_of(output.path), context));
    record.output.path = path_of(output.path).filename().string();
    done_or_thrown(write_record(record, path_of(output.record_path())));
}

LayerFileOptions layer_options(const OutputJob& job, const PlannedOutput& output) {
    const bool is_welded = !job.parts.empty() && job.parts.front().welded;
    return {.format = output.layer_format,
            .leave_out_open = job.arguments.leave_out,
            .welded = is_welded ? &*job.parts.front().welded : nullptr,
            .screen = job.arguments.screen.screen(),
            .times = job.arguments.screen.times,
            .part_names = job.part_names};
}

OpenLayers open_layers_of(const SliceResult& result, const Context& context) {
    return *done_or_thrown(audit(result, MeshView{}, {.volume = false, .ledger = false, .crossings = false}, context)).open;
}

void write_outputs(OutputJob& job, const Context& context, const Note& note) {
    for (const LabelRow& row : label_rows(job.arguments, job.parts.size())) {
        job.parts[row.label - 1].label_name = row.name;
        job.parts[row.label - 1].terms = row.terms;
    }
    const std::vector<std::string> distinct =
        distinct_names(parts_of(job, [](const SlicedPart& part) { return part.name; }));
    for (std::size_t i = 0; i < distinct.size(); ++i) {
        std::string& name = job.parts[i].name;
        if (distinct[i] != name) {
            note("the name '" + name + "' repeats: mesh " + std::to_string(i + 1) + " is called '" + distinct[i] + "'");
            name = distinct[i];
        }
    }
    for (const SlicedPart& part : job.parts) {
        refuse_if(job.arguments.strict && part.open.layers > 0, bad_input, part.name + ": --strict: " + part.open_words());
    }
    if (job.finish_streamed) {
        job.finish_streamed(
            [&](const PlannedOutput& output, const LayerFileSummary& summary) { note_layers(job, output, summary, note); });
    }
    for (const PlannedOutput& output : job.outputs) {
        try {
            if (!job.finish_streamed) {
                write_one(job, output, context, note);
            }
            if (takes_record(output)) {
                write_record_beside(output, record_of(job, output), context);
            }
            job.written.push_back(output.path);
        } catch (const Failure& failure) {
            if (context.stop && context.stop()) {
                throw;
            }
            if (job.failure) {
                complain(failure.what());
            } else {
                job.failure = failure;
            }
        }
    }
    if (job.failure && job.written.empty()) {
        throw Failure(*job.failure);
    }
}

std::string mesh_name_of(const std::string& path) {
    if (is_standard(path)) {
        return "mesh";
    }
    std::filesystem::path name = path_of(path).filename();
    if (name.extension() == ".gz" && name.stem().has_extension()) {
        name = name.stem();
    }
    return name.stem().string();
}

std::string wrote(const std::vector<std::string>& outputs, const std::map<std::string, std::string>& words) {
    std::string text;
    for (const std::string& output : outputs) {
        std::error_code unknown;  // of a pipe, and of a device
        const std::uintmax_t bytes = is_standard(output) ? 0 : std::filesystem::file_size(path_of(output), unknown);
        const auto more = words.find(output);
        text += "wrote     " + output_name(output) + when(!is_standard(output) && !unknown, ", " + file_size_text(bytes)) +
                (more == words.end() ? "" : ": " + more->second) + "\n";
    }
    return text;
}

}  // namespace lamella::cli
