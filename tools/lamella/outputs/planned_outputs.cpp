#include "outputs/planned_outputs.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <system_error>

#include "files/flags.hpp"
#include "files/streams.hpp"
#include "lamella/medical.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

struct NamedFormat {
    std::string_view name;  ///< for --to
    std::string_view end;   ///< of a file's name
    OutputFormat format;
};

/// Longer ends before those that they end in.
constexpr std::array<NamedFormat, 10> formats = {{
    {"svg", ".svg", OutputFormat::svg},
    {"nii.gz", ".nii.gz", OutputFormat::nifti_gz},
    {"nii", ".nii", OutputFormat::nifti},
    {"seg.nrrd", ".seg.nrrd", OutputFormat::segmentation},
    {"nrrd", ".nrrd", OutputFormat::nrrd},
    {"rtstruct", ".dcm", OutputFormat::structure_set},
    {"csv", ".csv", OutputFormat::csv},
    {"jsonl", ".jsonl", OutputFormat::json_lines},
    {"png", ".png", OutputFormat::png},
    {"h5", ".h5", OutputFormat::hdf5},
}};

std::string all_formats(std::string_view NamedFormat::*member) {
    std::vector<std::string_view> all;
    std::transform(formats.begin(), formats.end(), std::back_inserter(all), std::mem_fn(member));
    return joined(all);
}

const NamedFormat* format_by_end(const std::string& path) {
    const std::string name = lower_case(path);
    const auto* const found =
        std::find_if(formats.begin(), formats.end(), [&](const NamedFormat& format) { return name.ends_with(format.end); });
    return found == formats.end() ? nullptr : found;
}

/// The name without the end that tells its format.
std::string without_format_end(const std::string& path) {
    const NamedFormat* const format = format_by_end(path);
    return format == nullptr ? path : path.substr(0, path.size() - format->end.size());
}

PlannedOutput by_name(const std::string& path) {
    if (const NamedFormat* format = format_by_end(path)) {
        return {path, format->format};
    }
    require_extension(path, "--output", all_formats(&NamedFormat::end));
    return {path, OutputFormat::svg};
}

std::vector<const NamedFormat*> parse_formats(const std::string& to) {
    std::vector<const NamedFormat*> found;
    for (const std::string_view word : split(to, ',')) {
        const std::string name = lower_case(std::string(word));
        const auto* const format =
            std::find_if(formats.begin(), formats.end(), [&](const NamedFormat& known) { return known.name == name; });
        refuse_if(format == formats.end(), bad_usage,
                  "--to: '" + name + "' is not one of " + all_formats(&NamedFormat::name));
        refuse_if(std::find(found.begin(), found.end(), format) != found.end(), bad_usage,
                  "--to: '" + name + "' stands there twice");
        found.push_back(format);
    }
    return found;
}

constexpr std::int64_t end_of_9999 = 253'402'300'799;  ///< DICOM writes four digits

const PlannedOutput* first_of(const std::vector<PlannedOutput>& outputs, OutputFormat format) {
    const auto found =
        std::find_if(outputs.begin(), outputs.end(), [&](const PlannedOutput& output) { return output.format == format; });
    return found == outputs.end() ? nullptr : &*found;
}

void require_picture_possible(const PlannedOutput* picture, const OutputArguments& arguments) {
    refuse_if(arguments.picture_layer && picture == nullptr, bad_usage, "--picture-layer: no output is a PNG");
    if (picture != nullptr && !can_write_pictures()) {
        throw Failure(bad_usage, "cannot write '" + picture->path + "': this build of lamella is without PNG (libpng-dev)");
    }
}

void require_structures_possible(const PlannedOutput* set, const OutputArguments& arguments, const ImageArguments& image) {
    refuse_if(set == nullptr && (arguments.without_ct || arguments.holes), bad_usage,
              "--holes and --without-ct: no output is a structure set");
    if (set == nullptr) {
        return;
    }
    refuse_if(
        !image.given(), bad_usage,
        "--output: '" + set->path + "' needs --like FOLDER, the CT" + (arguments.without_ct ? ", or --spacing X,Y,Z" : ""));
    refuse_if(image.subslices > 1, bad_usage,
              "--subslices: the contours of '" + set->path + "' lie on the slices themselves");
    (void)source_date();
}

void require_no_file_shared(const PlannedOutput& output, const PlannedOutput& other, bool several_meshes) {
    if (output.is_mask() && other.is_mask()) {  // of one name they share a table of labels, which is the same
        return require_different_output(output.path, other.path, "--output", "another output");
    }
    for (const std::string& file : output.files(several_meshes)) {
        for (const std::string& others : other.files(several_meshes)) {
            require_different_output(file, others, "--output", "another output");
        }
    }
}

/// The box of all voxels, in the frame of slicing.
Box box_of(const ImageGeometry& image) {
    const std::vector<double> heights = image.slice_heights_mm();
    const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double half = image.spacing_mm[axis] / 2;
        box.min_mm[axis] = (axis == 2 ? *low : 0) - half;
        box.max_mm[axis] = (axis == 2 ? *high : static_cast<double>(image.size[axis] - 1) * image.spacing_mm[axis]) + half;
    }
    return box;
}

std::string range_text(double from, double to) {
    return rounded(from, 3) + " to " + rounded(to, 3) + " mm";
}

}  // namespace

void declare_outputs(CLI::App& command, OutputArguments& arguments) {
    static constexpr std::array<std::string_view, 2> holes = {"keyhole", "xor"};
    add_text(command, "-o,--output", arguments.outputs, "FILE|-",
             "File to write, by the end of its name: " + all_formats(&NamedFormat::end) +
                 "; repeatable; - for SVG on standard output");
    add_text(command, "--to", arguments.to, "FORMAT,...",
             "Write these formats, each as --output with the end of its name exchanged: " + all_formats(&NamedFormat::name));
    command.add_flag("--coverage", arguments.coverage, "Masks hold the share of each voxel's area that is inside");
    add(command, "--picture-layer", arguments.picture_layer, "N",
        "PNG shows this layer, counted from 0, not a contact sheet")
        ->check(CLI::Validator(CLI::NonNegativeNumber).description(""));
    add_choice(command, "--holes", holes,
               "Holes in a structure set: joined to their contour, or contours that exclude one another (keyhole)",
               [&arguments](std::size_t i) { arguments.holes = static_cast<HoleForm>(i); });
    command.add_flag("--without-ct", arguments.without_ct, "Write a structure set that refers to no CT");
    command.add_flag("--strict", arguments.strict, "Fail where a slice has open contours, of which no area is known");
}

void declare_image(CLI::App& command, ImageArguments& arguments) {
    static constexpr std::array<std::string_view, 2> frames = {"lps", "ras"};
    add_text(command, "--like", arguments.like, "IMAGE",
             "Cut at the slices of this image: NIfTI-1, NRRD, or a folder with a DICOM series");
    add_text(command, "--spacing", arguments.spacing, "X,Y,Z",
             "Cut for voxels of this size in mm around the mesh, along left, posterior, superior")
        ->excludes("--like");
    add_choice(command, "--frame", frames, "Patient frame of meshes that do not state one",
               [&arguments](std::size_t i) { arguments.frame = i == 0 ? PatientFrame::lps : PatientFrame::ras; });
    add(command, "--subslices", arguments.subslices, "N", "Masks hold the mean share over N planes a slice (1: off)")
        ->check(CLI::Range(1, 1000));
}

bool PlannedOutput::is_mask() const noexcept {
    return format == OutputFormat::nifti || format == OutputFormat::nifti_gz || format == OutputFormat::nrrd ||
           format == OutputFormat::segmentation;
}

std::vector<std::string> PlannedOutput::files(bool several_meshes) const {
    std::vector<std::string> all = {path};
    if (format == OutputFormat::csv) {
        all.push_back(without_format_end(path) + ".meshes.csv");
    }
    if (is_mask() && several_meshes) {
        all.push_back(without_format_end(path) + ".labels.csv");
    }
    if (has_record()) {
        all.push_back(record_path());
    }
    return all;
}

std::vector<PlannedOutput> planned_outputs(const OutputArguments& arguments) {
    const std::vector<std::string>& outputs = arguments.outputs;
    std::vector<PlannedOutput> planned;
    if (arguments.to.empty()) {
        for (const std::string& path : outputs) {
            planned.push_back(by_name(path));
        }
        return planned;
    }
    refuse_if(outputs.size() != 1 || is_standard(outputs.front()), bad_usage,
              "--to: needs one --output, a file, whose name the formats share");
    for (const NamedFormat* format : parse_formats(arguments.to)) {
        planned.push_back({without_format_end(outputs.front()) + std::string(format->end), format->format});
    }
    return planned;
}

std::optional<std::int64_t> source_date() {
    const char* const text = std::getenv("SOURCE_DATE_EPOCH");  // NOLINT(concurrency-mt-unsafe): nothing sets it
    if (text == nullptr || *text == '\0') {
        return std::nullopt;
    }
    std::int64_t seconds = 0;
    refuse_if(!parse_integer(std::string_view(text), seconds) || seconds < 0 || seconds > end_of_9999, bad_usage,
              "SOURCE_DATE_EPOCH: '" + std::string(text) + "' is not a number of seconds since 1970, before the year 10000");
    return seconds;
}

void require_no_input(const std::string& file, const NamedInputs& inputs, const std::string& option) {
    for (const auto& [path, what] : inputs) {
        if (!path.empty()) {
            require_different(file, path, option, what);
        }
    }
}

void require_together(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments, std::size_t meshes,
                      const ImageArguments& image) {
    require_picture_possible(first_of(outputs, OutputFormat::png), arguments);
    if (const PlannedOutput* const archive = first_of(outputs, OutputFormat::hdf5); archive && !has_archives()) {
        throw Failure(bad_usage, "--output: '" + archive->path + "': this build has no HDF5");
    }
    require_structures_possible(first_of(outputs, OutputFormat::structure_set), arguments, image);
    bool mask = false;
    for (const PlannedOutput& output : outputs) {
        mask = mask || output.is_mask();
        refuse_if(output.one_mesh() && meshes > 1, bad_usage, "--output: '" + output.path + "' takes one mesh, not several");
        refuse_if(output.is_mask() && !image.given(), bad_usage,
                  "--output: '" + output.path + "' needs --like IMAGE or --spacing X,Y,Z");
        for (const PlannedOutput& other : outputs) {
            if (&other < &output) {
                require_no_file_shared(output, other, meshes > 1);
            }
        }
    }
    refuse_if((arguments.coverage || image.subslices > 1) && mask && meshes > 1, bad_usage,
              "--coverage and --subslices: one mesh a mask, not several");
    refuse_if(image.subslices > 1 && !image.given(), bad_usage, "--subslices: needs --like IMAGE or --spacing X,Y,Z");
    refuse_if(arguments.coverage && !mask, bad_usage, "--coverage: no output is a mask");
}

std::vector<PlannedOutput> plan_outputs(const OutputArguments& arguments, std::size_t meshes, const ImageArguments& image,
                                        const NamedInputs& inputs) {
    for (const std::string& output : arguments.outputs) {  // as they were typed, before what their ends say
        require_writable(output);
        require_no_input(output, inputs, "--output");
    }
    std::vector<PlannedOutput> outputs = planned_outputs(arguments);
    require_together(outputs, arguments, meshes, image);
    for (const PlannedOutput& output : outputs) {
        require_writable(output.path);
    }
    for (const std::filesystem::path& file : files_of(outputs, meshes > 1)) {
        require_no_input(file.string(), inputs, "--output");
    }
    return outputs;
}

std::vector<std::filesystem::path> files_of(const std::vector<PlannedOutput>& outputs, bool several_meshes) {
    std::vector<std::filesystem::path> all;
    for (const PlannedOutput& output : outputs) {
        const std::vector<std::string> files = output.files(several_meshes);
        all.insert(all.end(), files.begin(), files.end());
    }
    return all;
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

void require_image_serves(const ImageGeometry& image, const std::vector<PlannedOutput>& outputs,
                          const OutputArguments& arguments) {
    for (const PlannedOutput& output : outputs) {
        refuse_if(output.is_mask() && !image.uneven_slices_mm.empty(), bad_input,
                  "'" + output.path + "': the slices of the image are not evenly spaced, and a mask holds even ones only");
        refuse_if(output.format == OutputFormat::structure_set && !image.series && !arguments.without_ct, bad_input,
                  "'" + output.path +
                      "': a structure set is drawn on the slices of a CT: --like FOLDER "
                      "with a DICOM series, or --without-ct");
    }
}

void require_series_kept(const ImageGeometry& image, const std::vector<std::filesystem::path>& outputs) {
    for (const std::filesystem::path& output : outputs) {
        std::error_code unknown;
        if (image.series && std::filesystem::exists(output, unknown)) {
            for (const DicomSeries::Instance& slice : image.series->slices) {
                require_different(output.string(), slice.file, "--output", "a slice of --like");
            }
        }
    }
}

void require_overlap(const ImageGeometry& image, const std::string& name, const Box& mesh) {
    const Box box = box_of(image);
    static constexpr std::array<const char*, 3> names = {"its rows", "its columns", "its slices' normal"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (mesh.max_mm[axis] < box.min_mm[axis] || mesh.min_mm[axis] > box.max_mm[axis]) {
            throw Failure(bad_input, name + ": lies outside of the image: along " + names[axis] + " the mesh reaches from " +
                                         range_text(mesh.min_mm[axis], mesh.max_mm[axis]) + ", the image from " +
                                         range_text(box.min_mm[axis], box.max_mm[axis]) + "; is the patient frame right?");
        }
    }
}

}  // namespace lamella::cli
