#include "outputs/write_outputs.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "console.hpp"
#include "failure.hpp"
#include "lamella/io/svg.hpp"
#include "lamella/version.hpp"
#include "output_path.hpp"
#include "standard_streams.hpp"

namespace lamella::cli {

namespace {

using Note = std::function<void(const std::string&)>;

template <class T>
T done_or_thrown(Result<T> result) {
    if (!result) {
        throw failure_of(result.error());
    }
    return std::move(result).value();
}

void done_or_thrown(const Status& status) {
    if (!status) {
        throw failure_of(status.error());
    }
}

/// Colours that are told apart on black and on white, for labels 1, 2, ...
constexpr std::array<std::array<std::uint8_t, 3>, 8> label_colours = {{{230, 75, 53},
                                                                       {0, 114, 178},
                                                                       {0, 158, 115},
                                                                       {230, 159, 0},
                                                                       {204, 121, 167},
                                                                       {86, 180, 233},
                                                                       {213, 94, 0},
                                                                       {117, 112, 179}}};

std::optional<std::int64_t> source_date_epoch() {
    const char* const text = std::getenv("SOURCE_DATE_EPOCH");
    std::int64_t seconds = 0;
    if (text == nullptr) {
        return std::nullopt;
    }
    const std::string_view digits(text);
    const auto [stop, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), seconds);
    if (problem != std::errc() || stop != digits.data() + digits.size() || seconds < 0) {
        throw Failure(bad_usage, "SOURCE_DATE_EPOCH: '" + std::string(text) + "' is not a number of seconds");
    }
    return seconds;
}

std::string percent(double share) {
    return share < 0.0001 ? "less than 0.01 %" : rounded(share * 100, 2) + " %";
}

void note_open_slices(std::uint64_t slices, const PlannedOutput& output, const Note& note) {
    if (slices > 0) {
        note(output.path + ": " + counted(slices, "slice") + (slices == 1 ? " has" : " have") +
             " open polylines, which enclose nothing");
    }
}

void write_mask_of(const OutputJob& job, const PlannedOutput& output, const Control& control, const Note& note) {
    std::vector<MaskPart> parts;
    for (const SlicedPart& part : job.parts) {
        parts.push_back({&part.result, part.name});
    }
    const MaskSummary summary =
        done_or_thrown(write_mask(parts, *job.image, output.path,
                                  {.coverage = job.arguments.coverage, .subslices = job.subslices, .control = control}));
    if (summary.overlapped_voxels > 0) {
        note(output.path + ": " + counted(summary.overlapped_voxels, "voxel") +
             (summary.overlapped_voxels == 1 ? " lies" : " lie") + " in several meshes; the later label holds");
    }
    note_open_slices(summary.open_slices, output, note);
    for (std::size_t i = 0; i < summary.cut_off_share.size(); ++i) {
        const std::string& name = job.parts[i].name;
        if (summary.cut_off_share[i] > 0) {
            note(output.path + ": the image cuts off " + percent(summary.cut_off_share[i]) + " of the area of " + name);
        }
        if (summary.voxels[i] == 0) {
            note(output.path + ": no voxel lies in " + name);
        }
    }
}

void write_structure_set_of(const OutputJob& job, const PlannedOutput& output, const Control& control, const Note& note) {
    std::vector<Roi> rois;
    for (const SlicedPart& part : job.parts) {
        rois.push_back({&part.result, part.name, label_colours[rois.size() % label_colours.size()]});
    }
    const StructureSetSummary summary = done_or_thrown(write_structure_set(rois, *job.image, output.path,
                                                                           {.holes = job.arguments.holes,
                                                                            .without_ct = job.arguments.without_ct,
                                                                            .seconds_since_1970 = source_date_epoch(),
                                                                            .control = control}));
    note_open_slices(summary.open_slices, output, note);
}

void write_archive_of(const OutputJob& job, const PlannedOutput& output, const Control& control) {
    const SlicedPart& part = job.parts.front();
    const ArchiveInfo info{.name = part.name,
                           .mesh_sha256 = part.sha256,
                           .frame = part.frame,
                           .geometry = job.image,
                           .subslices = job.subslices,
                           .first_layer = job.first_layer,
                           .all_layers = job.all_layers};
    done_or_thrown(write_archive(part.result, info, output.path, control));
}

void write_table_of(const OutputJob& job, const PlannedOutput& output, const Control& control) {
    std::vector<TablePart> parts;
    for (const SlicedPart& part : job.parts) {
        parts.push_back({&part.result, part.name, part.facts ? &*part.facts : nullptr, job.first_layer});
    }
    done_or_thrown(write_layer_table(parts, output.path, control));
}

void write_picture_of(const OutputJob& job, const PlannedOutput& output, const Control& control) {
    std::vector<PicturePart> parts;
    for (const SlicedPart& part : job.parts) {
        parts.push_back({&part.result, part.name});
    }
    const PictureOptions options{.first_layer = job.first_layer, .control = control};
    const std::optional<std::uint64_t> layer = job.arguments.picture_layer;
    if (layer) {
        const std::uint64_t end = job.first_layer + job.parts.front().result.layers.size();
        if (*layer < job.first_layer || *layer >= end) {
            throw Failure(bad_usage, "--picture-layer: there are layers " + std::to_string(job.first_layer) + " to " +
                                         std::to_string(end) + ", the last left out");
        }
        done_or_thrown(write_layer_picture(parts, *layer - job.first_layer, output.path, options));
        return;
    }
    done_or_thrown(write_contact_sheet(parts, output.path, options));
}

void write_one(const OutputJob& job, const PlannedOutput& output, const Control& control, const Note& note) {
    switch (output.format) {
        case OutputFormat::svg: {
            const SlicedPart& part = job.parts.front();
            done_or_thrown(write_svg(part.result, output_path(output.path),
                                     {.welded = part.welded ? &*part.welded : nullptr, .control = control}));
            return;
        }
        case OutputFormat::nifti:
        case OutputFormat::nifti_gz:
        case OutputFormat::nrrd:
        case OutputFormat::segmentation:
            return write_mask_of(job, output, control, note);
        case OutputFormat::structure_set:
            return write_structure_set_of(job, output, control, note);
        case OutputFormat::archive:
            return write_archive_of(job, output, control);
        case OutputFormat::csv:
        case OutputFormat::json_lines:
            return write_table_of(job, output, control);
        case OutputFormat::png:
            return write_picture_of(job, output, control);
    }
}

std::string hexadecimal(std::uint64_t value) {
    char text[17];
    (void)std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

void write_record_of(const OutputJob& job, const PlannedOutput& output, const Control& control) {
    if (!output.has_record() || !std::filesystem::is_regular_file(output.path)) {
        return;
    }
    Record record;
    record.version = version;
    record.inputs = job.inputs;
    record.output = done_or_thrown(seal_file(output.path, control));
    record.output.path = std::filesystem::path(output.path).filename().string();
    record.options = job.options;
    record.patient_frame = name_of(job.parts.front().frame);
    record.fill_rule = name_of(job.parts.front().result.region.fill_rule);
    for (const SlicedPart& part : job.parts) {
        record.grid_mm.push_back(part.result.unit_mm);
        record.result_hashes.push_back(hexadecimal(hash_result(part.result)));
    }
    done_or_thrown(write_record(record, output.record_path()));
}

void require_closed(const OutputJob& job) {
    for (const SlicedPart& part : job.parts) {
        if (part.result.summary.open_contours > 0) {
            throw Failure(bad_input, part.name + ": --strict: " +
                                         counted(part.result.summary.open_contours, "open polyline") + " in its layers");
        }
    }
}

}  // namespace

void require_possible(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments, std::size_t meshes,
                      bool image_given, bool dicom_image, int subslices) {
    bool mask = false;
    bool structures = false;
    bool picture = false;
    for (const PlannedOutput& output : outputs) {
        require_writable(output.path);
        mask = mask || output.is_mask();
        structures = structures || output.format == OutputFormat::structure_set;
        picture = picture || output.format == OutputFormat::png;
        if (output.one_mesh() && meshes > 1) {
            throw Failure(bad_usage, "--output: '" + output.path + "' takes one mesh, not " + std::to_string(meshes));
        }
        if (output.in_patient() && !image_given) {
            throw Failure(bad_usage, "--output: '" + output.path + "' needs --like IMAGE or --spacing X,Y,Z");
        }
        for (const PlannedOutput& other : outputs) {
            if (&other < &output) {
                require_different_output(output.path, other.path, "--output", "another output");
            }
        }
    }
    if (structures && !dicom_image && !arguments.without_ct) {
        throw Failure(bad_usage, "a structure set needs the CT that it belongs to: --like FOLDER, or --without-ct");
    }
    if (structures && subslices > 1) {
        throw Failure(bad_usage, "--subslices: a structure set has one plane a slice");
    }
    if ((arguments.coverage || subslices > 1) && mask && meshes > 1) {
        throw Failure(bad_usage, "--coverage and --subslices: one mesh a mask, not " + std::to_string(meshes));
    }
    if ((arguments.coverage || subslices > 1) && !mask) {
        throw Failure(bad_usage, "--coverage and --subslices: no output is a mask");
    }
    if (arguments.picture_layer && !picture) {
        throw Failure(bad_usage, "--picture-layer: no output is a PNG");
    }
}

void write_outputs(const OutputJob& job, const Control& control, const Note& note) {
    if (job.arguments.strict) {
        require_closed(job);
    }
    for (const PlannedOutput& output : job.outputs) {
        write_one(job, output, control, note);
        write_record_of(job, output, control);
    }
}

std::string mesh_name_of(const std::string& path) {
    if (is_standard(path)) {
        return "mesh";
    }
    std::filesystem::path name = std::filesystem::path(path).filename();
    if (name.extension() == ".gz" && name.stem().has_extension()) {
        name = name.stem();
    }
    return name.stem().string();
}

}  // namespace lamella::cli
