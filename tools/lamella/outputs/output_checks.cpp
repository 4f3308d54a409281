#include "outputs/output_checks.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "files/streams.hpp"
#include "lamella/medical.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

constexpr std::int64_t end_of_9999 = 253'402'300'799;  ///< DICOM writes four digits

const PlannedOutput* first_of(const std::vector<PlannedOutput>& outputs, OutputFormat format) {
    const auto found =
        std::find_if(outputs.begin(), outputs.end(), [&](const PlannedOutput& output) { return output.format == format; });
    return found == outputs.end() ? nullptr : &*found;
}

void require_picture_possible(const PlannedOutput* picture, const OutputArguments& arguments) {
    if (arguments.picture_layer && picture == nullptr) {
        throw Failure(bad_usage, "--picture-layer: no output is a PNG");
    }
    if (picture != nullptr && !can_write_pictures()) {
        throw Failure(bad_usage, "cannot write '" + picture->path + "': this build of lamella is without PNG (libpng-dev)");
    }
}

void require_structures_possible(const PlannedOutput* set, const OutputArguments& arguments, bool image_given,
                                 int subslices) {
    if (set == nullptr && (arguments.without_ct || arguments.holes_given)) {
        throw Failure(bad_usage, "--holes and --without-ct: no output is a structure set");
    }
    if (set == nullptr) {
        return;
    }
    if (!image_given) {
        throw Failure(bad_usage, "--output: '" + set->path + "' needs --like FOLDER, the CT" +
                                     (arguments.without_ct ? ", or --spacing X,Y,Z" : ""));
    }
    if (subslices > 1) {
        throw Failure(bad_usage, "--subslices: the contours of '" + set->path + "' lie on the slices themselves");
    }
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

/// Lower and upper corner of all voxels, in the frame of slicing.
std::array<std::array<double, 3>, 2> box_of(const ImageGeometry& image) {
    const std::vector<double> heights = image.slice_heights_mm();
    const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
    std::array<std::array<double, 3>, 2> box{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double half = image.spacing_mm[axis] / 2;
        box[0][axis] = (axis == 2 ? *low : 0) - half;
        box[1][axis] = (axis == 2 ? *high : static_cast<double>(image.size[axis] - 1) * image.spacing_mm[axis]) + half;
    }
    return box;
}

std::string range_text(double from, double to) {
    return rounded(from, 3) + " to " + rounded(to, 3) + " mm";
}

}  // namespace

std::optional<std::int64_t> source_date() {
    const char* const text = std::getenv("SOURCE_DATE_EPOCH");  // NOLINT(concurrency-mt-unsafe): nothing sets it
    if (text == nullptr || *text == '\0') {
        return std::nullopt;
    }
    const std::string_view all(text);
    std::int64_t seconds = 0;
    const auto [stop, problem] = std::from_chars(all.data(), all.data() + all.size(), seconds);
    if (problem != std::errc() || stop != all.data() + all.size() || seconds < 0 || seconds > end_of_9999) {
        throw Failure(bad_usage, "SOURCE_DATE_EPOCH: '" + std::string(all) +
                                     "' is not a number of seconds since 1970, before the year 10000");
    }
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
                      bool image_given, int subslices) {
    require_picture_possible(first_of(outputs, OutputFormat::png), arguments);
    if (const PlannedOutput* const archive = first_of(outputs, OutputFormat::hdf5); archive && !has_archives()) {
        throw Failure(bad_usage, "--output: '" + archive->path + "': this build has no HDF5");
    }
    require_structures_possible(first_of(outputs, OutputFormat::structure_set), arguments, image_given, subslices);
    bool mask = false;
    for (const PlannedOutput& output : outputs) {
        mask = mask || output.is_mask();
        if (output.one_mesh() && meshes > 1) {
            throw Failure(bad_usage, "--output: '" + output.path + "' takes one mesh, not several");
        }
        if (output.is_mask() && !image_given) {
            throw Failure(bad_usage, "--output: '" + output.path + "' needs --like IMAGE or --spacing X,Y,Z");
        }
        for (const PlannedOutput& other : outputs) {
            if (&other < &output) {
                require_no_file_shared(output, other, meshes > 1);
            }
        }
    }
    if ((arguments.coverage || subslices > 1) && mask && meshes > 1) {
        throw Failure(bad_usage, "--coverage and --subslices: one mesh a mask, not several");
    }
    if (subslices > 1 && !image_given) {
        throw Failure(bad_usage, "--subslices: needs --like IMAGE or --spacing X,Y,Z");
    }
    if (arguments.coverage && !mask) {
        throw Failure(bad_usage, "--coverage: no output is a mask");
    }
}

std::vector<PlannedOutput> plan_outputs(const OutputArguments& arguments, std::size_t meshes, bool image_given,
                                        int subslices, const NamedInputs& inputs) {
    std::vector<PlannedOutput> outputs;
    if (!arguments.outputs.empty() || !arguments.to.empty()) {
        outputs = planned_outputs(arguments.outputs, arguments.to);
    }
    require_together(outputs, arguments, meshes, image_given, subslices);
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

void require_image_serves(const ImageGeometry& image, const std::vector<PlannedOutput>& outputs,
                          const OutputArguments& arguments) {
    for (const PlannedOutput& output : outputs) {
        if (output.is_mask() && !image.uneven_slices_mm.empty()) {
            throw Failure(
                bad_input,
                "'" + output.path + "': the slices of the image are not evenly spaced, and a mask holds even ones only");
        }
        if (output.format == OutputFormat::structure_set && !image.series && !arguments.without_ct) {
            throw Failure(bad_input, "'" + output.path +
                                         "': a structure set is drawn on the slices of a CT: --like FOLDER "
                                         "with a DICOM series, or --without-ct");
        }
    }
}

void require_series_kept(const ImageGeometry& image, const std::vector<std::filesystem::path>& outputs) {
    if (!image.series) {
        return;
    }
    for (const std::filesystem::path& output : outputs) {
        std::error_code unknown;
        if (!std::filesystem::exists(output, unknown)) {
            continue;
        }
        for (const DicomSeries::Instance& slice : image.series->slices) {
            require_different(output.string(), slice.file, "--output", "a slice of --like");
        }
    }
}

void require_overlap(const ImageGeometry& image, const std::string& name, const SliceSummary& mesh) {
    const auto box = box_of(image);
    static constexpr std::array<const char*, 3> names = {"its rows", "its columns", "its slices' normal"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (mesh.max_mm[axis] < box[0][axis] || mesh.min_mm[axis] > box[1][axis]) {
            throw Failure(bad_input, name + ": lies outside of the image: along " + names[axis] + " the mesh reaches from " +
                                         range_text(mesh.min_mm[axis], mesh.max_mm[axis]) + ", the image from " +
                                         range_text(box[0][axis], box[1][axis]) + "; is the patient frame right?");
        }
    }
}

}  // namespace lamella::cli
