#include "outputs/write_structure_output.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

constexpr std::int64_t end_of_9999 = 253'402'300'799;  ///< DICOM writes four digits

bool is_structure_set(const PlannedOutput& output) {
    return output.format == OutputFormat::structure_set;
}

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

void require_structures_possible(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments,
                                 bool image_given, int subslices) {
    const auto set = std::find_if(outputs.begin(), outputs.end(), is_structure_set);
    if (set == outputs.end()) {
        if (arguments.without_ct || arguments.holes_given) {
            throw Failure(bad_usage, "--holes and --without-ct: no output is a structure set");
        }
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

void require_image_serves(const ImageGeometry& image, const std::vector<PlannedOutput>& outputs,
                          const OutputArguments& arguments) {
    for (const PlannedOutput& output : outputs) {
        if (output.is_mask() && !image.uneven_slices_mm.empty()) {
            throw Failure(
                bad_input,
                "'" + output.path + "': the slices of the image are not evenly spaced, and a mask holds even ones only");
        }
        if (is_structure_set(output) && !image.series && !arguments.without_ct) {
            throw Failure(bad_input, "'" + output.path +
                                         "': a structure set is drawn on the slices of a CT: --like FOLDER "
                                         "with a DICOM series, or --without-ct");
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

void write_structure_output(const OutputJob& job, const PlannedOutput& output, const Control& control,
                            const std::function<void(const std::string&)>& note) {
    static constexpr std::array<std::array<std::uint8_t, 3>, 6> colours = {
        {{230, 77, 51}, {0, 115, 178}, {0, 158, 115}, {230, 158, 0}, {204, 120, 166}, {87, 181, 232}}};
    if (!job.image) {  // an archive that was sliced without one
        throw Failure(bad_input, "'" + output.path + "': no image says where the slices lie in the patient");
    }
    std::vector<Roi> rois;
    for (const SlicedPart& part : job.parts) {
        rois.push_back({&part.result, part.name, colours[rois.size() % colours.size()]});
    }
    StructureSetOptions options;
    options.holes = job.arguments.holes;
    options.without_ct = job.arguments.without_ct;
    options.seconds_since_1970 = source_date();
    options.control = control;
    const Result<StructureSetSummary> written = write_structure_set(rois, *job.image, output.path, options);
    if (!written) {  // what options can be wrong in was seen before
        const Failure failure = failure_of(written.error());
        throw Failure(failure.status() == bad_usage ? bad_input : failure.status(), failure.what());
    }
    for (std::size_t i = 0; i < rois.size(); ++i) {
        if (written->roi_names[i] != rois[i].name) {
            note(output.path + ": the name '" + rois[i].name + "' is written as '" + written->roi_names[i] +
                 "': a ROI's has at most 64 characters, of the CT's character set, and none repeats");
        }
    }
    if (written->nested_contours > 0) {
        note(output.path + ": " + counted(written->nested_contours, "contour") +
             " in the solid part of others, which readers may take for holes; --fill-rule non-zero unites them");
    }
}

}  // namespace lamella::cli
