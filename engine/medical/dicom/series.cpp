#include <system_error>

#include "base/guard.hpp"
#include "lamella/grid.hpp"
#include "medical/dicom/header.hpp"

namespace lamella {

namespace {

constexpr double same_direction = 1e-4;  ///< as the difference of two unit vectors
constexpr double same_place_mm = 1e-4;
constexpr double even_share = 0.01;  ///< of the mean distance: so far slices may lie from even places
// Headers state places with few decimals.
constexpr double shift_mm = 0.02;      ///< a slice may lie so far aside of the others, and
constexpr double shift_per_mm = 1e-4;  ///< so much farther for each mm above the first

/// The plane of a slice.
struct Slice {
    const DicomHeader* header = nullptr;
    std::array<std::uint64_t, 2> size{};  ///< voxels along i, j
    std::array<double, 2> spacing_mm{};
    Direction along_i{};  ///< unit vectors
    Direction along_j{};
    Direction position{};
    double height = 0;  ///< along the normal
};

std::string text_of(double value) {
    std::array<char, 32> text{};
    (void)std::snprintf(text.data(), text.size(), "%.6g", value);
    return text.data();
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code problem;
    std::filesystem::directory_iterator entry(folder, problem);
    for (; !problem && entry != std::filesystem::directory_iterator(); entry.increment(problem)) {
        std::error_code unknown;
        if (entry->is_regular_file(unknown)) {
            files.push_back(entry->path());
        }
    }
    if (problem) {
        refuse_unreadable(folder.string(), problem.value());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// The images of the one series in a folder.
std::vector<DicomHeader> images_in(const std::filesystem::path& folder) {
    std::map<std::string, std::vector<DicomHeader>> series;
    bool any = false;
    for (const std::filesystem::path& file : files_in(folder)) {
        std::optional<DicomHeader> header = read_dicom_header(file);
        any = any || header;
        if (header && header->has(dicom::rows)) {
            const std::string uid = header->required_text(dicom::series_instance_uid, "SeriesInstanceUID");
            series[uid].push_back(*std::move(header));
        }
    }
    if (series.size() == 1) {
        return std::move(series.begin()->second);
    }
    if (series.empty()) {
        refuse_image(folder.string(),
                     any ? "a folder with DICOM files, none of which is an image" : "a folder without DICOM files");
    }
    std::string list;
    std::size_t listed = 0;
    for (const auto& [uid, images] : series) {
        constexpr std::size_t most_listed = 20;
        if (++listed > most_listed) {
            list += "; ...";
            break;
        }
        const std::string description = one_line(images.front().text(dicom::series_description));
        list.append(listed == 1 ? " " : "; ").append(one_line(uid));
        list.append(description.empty() ? "" : " '" + description + "'");
        list.append(" (").append(counted(images.size(), "slice")).append(")");
    }
    refuse_image(folder.string(), std::to_string(series.size()) + " DICOM series in the folder, and one is taken:" + list);
}

Direction unit_vector(const DicomHeader& header, const std::vector<double>& numbers, std::size_t at) {
    const Direction along = {numbers[at], numbers[at + 1], numbers[at + 2]};
    if (std::abs(length(along) - 1) > 1e-3) {
        header.refuse("ImageOrientationPatient holds no unit vectors");
    }
    return scaled(along, 1 / length(along));
}

std::uint64_t side(const DicomHeader& header, dicom::Tag tag, const char* keyword) {
    const double count = header.required_numbers(tag, keyword, 1)[0];
    if (!(count >= 1 && count <= 65535)) {
        header.refuse(std::string(keyword) + " is " + text_of(count));
    }
    return static_cast<std::uint64_t>(count);
}

Slice slice_of(const DicomHeader& header) {
    const std::string frames = header.text(dicom::number_of_frames);
    if (!frames.empty() && frames != "1") {
        header.refuse("a DICOM file of several frames (" + one_line(frames) +
                      "), which is not read; convert it to a file a slice, or to NIfTI");
    }
    Slice slice;
    slice.header = &header;
    slice.size = {side(header, dicom::columns, "Columns"), side(header, dicom::rows, "Rows")};
    const std::vector<double> at = header.required_numbers(dicom::image_position_patient, "ImagePositionPatient", 3);
    slice.position = {at[0], at[1], at[2]};
    if (!(length(slice.position) <= largest_coordinate_mm)) {
        header.refuse("ImagePositionPatient lies farther than " + text_of(largest_coordinate_mm) + " mm away");
    }
    const std::vector<double> along =
        header.required_numbers(dicom::image_orientation_patient, "ImageOrientationPatient", 6);
    slice.along_i = unit_vector(header, along, 0);
    slice.along_j = unit_vector(header, along, 3);
    // The first is the distance of rows.
    const std::vector<double> spacing = header.required_numbers(dicom::pixel_spacing, "PixelSpacing", 2);
    slice.spacing_mm = {spacing[1], spacing[0]};
    if (!(spacing[0] > 0 && spacing[1] > 0)) {
        header.refuse("PixelSpacing is not above 0");
    }
    return slice;
}

bool same(const Direction& a, const Direction& b) {
    return std::equal(a.begin(), a.end(), b.begin(),
                      [](double one, double other) { return std::abs(one - other) <= same_direction; });
}

void require_alike(const Slice& slice, const Slice& first) {
    const auto frame = [](const Slice& of) { return of.header->text(dicom::frame_of_reference_uid); };
    const char* const other = slice.size != first.size               ? "Rows and Columns"
                              : slice.spacing_mm != first.spacing_mm ? "PixelSpacing"
                              : !same(slice.along_i, first.along_i) || !same(slice.along_j, first.along_j)
                                  ? "ImageOrientationPatient"
                              : frame(slice) != frame(first) ? "FrameOfReferenceUID"
                                                             : nullptr;
    if (other != nullptr) {
        slice.header->refuse(std::string("other ") + other + " than " + first.header->file() +
                             ", which is of the same series");
    }
}

/// All slices, sorted along the normal.
std::vector<Slice> sorted_slices(const std::vector<DicomHeader>& images) {
    std::vector<Slice> slices;
    for (const DicomHeader& image : images) {
        slices.push_back(slice_of(image));
        require_alike(slices.back(), slices.front());
    }
    const Direction normal = cross(slices.front().along_i, slices.front().along_j);
    for (Slice& slice : slices) {
        slice.height = dot(normal, slice.position);
    }
    std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.height < b.height; });
    return slices;
}

void require_stacked(const std::vector<Slice>& slices) {
    const Slice& first = slices.front();
    for (std::size_t i = 1; i < slices.size(); ++i) {
        const Slice& slice = slices[i];
        if (slice.height - slices[i - 1].height < same_place_mm) {
            slice.header->refuse("lies at the same place as " + slices[i - 1].header->file());
        }
        Direction step{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            step[axis] = slice.position[axis] - first.position[axis];
        }
        const double aside = std::max(std::abs(dot(step, first.along_i)), std::abs(dot(step, first.along_j)));
        if (aside > shift_mm + shift_per_mm * (slice.height - first.height)) {
            slice.header->refuse("sheared, as by a tilted gantry: the slice lies " + text_of(aside) + " mm aside of " +
                                 first.header->file());
        }
    }
}

DicomSeries series_of(const std::vector<Slice>& slices) {
    const DicomHeader& header = *slices.front().header;
    DicomSeries series;
    for (const Slice& slice : slices) {
        series.slices.push_back(
            {slice.header->file(), slice.header->text(dicom::sop_class_uid), slice.header->text(dicom::sop_instance_uid)});
    }
    for (const dicom::SeriesText& text : dicom::series_texts) {
        series.*text.text = header.text(text.tag);
    }
    return series;
}

}  // namespace

ImageGeometry read_dicom_folder(const std::filesystem::path& folder) {
    const std::vector<DicomHeader> images = images_in(folder);
    const std::vector<Slice> slices = sorted_slices(images);
    require_stacked(slices);
    const Slice& first = slices.front();
    const double distance = slices.size() > 1
                                ? (slices.back().height - first.height) / static_cast<double>(slices.size() - 1)
                                : first.header->required_numbers(dicom::slice_thickness, "SliceThickness", 1)[0];
    const Direction normal = cross(first.along_i, first.along_j);
    ImageGeometry image = upright(first.header->file(), {first.size[0], first.size[1], slices.size()},
                                  {scaled(first.along_i, first.spacing_mm[0]), scaled(first.along_j, first.spacing_mm[1]),
                                   scaled(normal, distance / length(normal))},
                                  first.position);
    bool even = true;
    for (std::size_t i = 0; i < slices.size(); ++i) {
        image.uneven_slices_mm.push_back(slices[i].height - first.height);
        even = even && std::abs(image.uneven_slices_mm.back() - static_cast<double>(i) * distance) <= even_share * distance;
    }
    if (even) {
        image.uneven_slices_mm.clear();
    }
    image.series = series_of(slices);
    return image;
}

}  // namespace lamella
