// A folder with series of DICOM images: which there are, and the geometry of one.
#include <cerrno>
#include <map>
#include <system_error>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "base/words.hpp"
#include "io/text/text.hpp"
#include "lamella/grid.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/header.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code problem;
    if (!can_list(folder)) {
        refuse_unreadable(path_text(folder), ENAMETOOLONG);
    }
    std::filesystem::directory_iterator entry(folder, problem);
    for (; !problem && entry != std::filesystem::directory_iterator(); entry.increment(problem)) {
        std::error_code unknown;
        if (entry->is_regular_file(unknown)) {
            files.push_back(entry->path());
        }
    }
    if (problem) {
        refuse_unreadable(path_text(folder), problem.value());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// The images of each series, by their UIDs.
using SeriesImages = std::map<std::string, std::vector<DicomHeader>>;

SeriesImages series_in(const std::filesystem::path& folder, const StopCheck& host) {
    SeriesImages series;
    bool any = false;
    const PacedStop stop(host);
    for (const std::filesystem::path& file : files_in(folder)) {
        stop.stop_if_asked();
        std::optional<DicomHeader> header = read_dicom_header(file);
        any = any || header;
        if (header && !header->text(dicom::rows).empty()) {
            const std::string uid = header->required_text(dicom::series_instance_uid, "SeriesInstanceUID");
            series[uid].push_back(*std::move(header));
        }
    }
    if (series.empty()) {
        refuse_image(path_text(folder),
                     any ? "a folder with DICOM files, none of which is an image" : "a folder without DICOM files");
    }
    return series;
}

/// "1.2.3 'Thorax' (40 slices); ...", for messages.
std::string list_text(const SeriesImages& series) {
    constexpr std::size_t most_listed = 20;
    std::string list;
    std::size_t listed = 0;
    for (const auto& [uid, images] : series) {
        if (listed++ == most_listed) {
            return list + "; ...";
        }
        const std::string description = one_line(images.front().text(dicom::series_description));
        list += (listed == 1 ? " " : "; ") + one_line(uid) + (description.empty() ? "" : " '" + description + "'") + " (" +
                counted(images.size(), "slice") + ")";
    }
    return list;
}

/// The images of the series with this UID, or of the one in the folder.
std::vector<DicomHeader> images_in(const std::filesystem::path& folder, const std::string& series_uid,
                                   const StopCheck& stop) {
    SeriesImages series = series_in(folder, stop);
    if (const auto chosen = series.find(series_uid); chosen != series.end()) {
        return std::move(chosen->second);
    }
    if (!series_uid.empty()) {
        refuse_image(path_text(folder),
                     "no images of the series " + one_line(series_uid) + "; there is" + list_text(series));
    }
    if (series.size() > 1) {
        refuse_image(path_text(folder),
                     std::to_string(series.size()) + " DICOM series, of which --series UID takes one:" + list_text(series));
    }
    return std::move(series.begin()->second);
}

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

Slice slice_of(const DicomHeader& header) {
    const std::string frames = header.text(dicom::number_of_frames);
    if (!frames.empty() && frames != "1") {
        header.refuse("a DICOM file of several frames (" + one_line(frames) +
                      "), which is not read; convert it to a file a slice, or to NIfTI");
    }
    Slice slice;
    slice.header = &header;
    slice.size = {header.side(dicom::columns, "Columns"), header.side(dicom::rows, "Rows")};
    slice.position = header.numbers<3>(dicom::image_position_patient, "ImagePositionPatient");
    if (!(length(slice.position) <= largest_coordinate_mm)) {
        header.refuse("ImagePositionPatient lies farther than " + exact_text(largest_coordinate_mm) + " mm away");
    }
    const std::array<double, 6> along = header.numbers<6>(dicom::image_orientation_patient, "ImageOrientationPatient");
    slice.along_i = {along[0], along[1], along[2]};
    slice.along_j = {along[3], along[4], along[5]};
    for (Direction* const axis : {&slice.along_i, &slice.along_j}) {
        if (std::abs(length(*axis) - 1) > 1e-3) {
            header.refuse("ImageOrientationPatient holds no unit vectors");
        }
        *axis = scaled(*axis, 1 / length(*axis));
    }
    const auto [of_rows, of_columns] = header.numbers<2>(dicom::pixel_spacing, "PixelSpacing");
    slice.spacing_mm = {of_columns, of_rows};
    if (!(of_rows > 0 && of_columns > 0)) {
        header.refuse("PixelSpacing is not above 0");
    }
    return slice;
}

void require_alike(const Slice& slice, const Slice& first) {
    const auto frame = [](const Slice& of) { return of.header->text(dicom::frame_of_reference_uid); };
    const auto same = [](const Direction& a, const Direction& b) {
        constexpr double most = 1e-4;  // difference of unit vectors
        return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) { return std::abs(x - y) <= most; });
    };
    const char* const other = slice.size != first.size               ? "Rows and Columns"
                              : slice.spacing_mm != first.spacing_mm ? "PixelSpacing"
                              : !same(slice.along_i, first.along_i) || !same(slice.along_j, first.along_j)
                                  ? "ImageOrientationPatient"
                              : frame(slice) != frame(first) ? "FrameOfReferenceUID"
                                                             : nullptr;
    if (other != nullptr) {
        slice.header->refuse(std::string("other ") + other + " than " + first.header->file +
                             ", which is of the same series");
    }
}

/// All slices, sorted along the normal.
std::vector<Slice> sorted_slices(const std::vector<DicomHeader>& images) {
    std::vector<Slice> slices;
    slices.reserve(images.size());
    for (const DicomHeader& image : images) {
        Slice& slice = slices.emplace_back(slice_of(image));
        require_alike(slice, slices.front());
        slice.height = dot(cross(slices.front().along_i, slices.front().along_j), slice.position);
    }
    std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.height < b.height; });
    return slices;
}

void require_stacked(const std::vector<Slice>& slices) {
    constexpr double same_place_mm = 1e-4;
    // Headers state places with few decimals.
    constexpr double shift_mm = 0.02;      // a slice may lie so far aside of the others, and
    constexpr double shift_per_mm = 1e-4;  // so much farther for each mm above the first
    const Slice& first = slices.front();
    for (std::size_t i = 1; i < slices.size(); ++i) {
        const Slice& slice = slices[i];
        if (slice.height - slices[i - 1].height < same_place_mm) {
            slice.header->refuse("lies at the same place as " + slices[i - 1].header->file);
        }
        Direction step{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            step[axis] = slice.position[axis] - first.position[axis];
        }
        const double aside = std::max(std::abs(dot(step, first.along_i)), std::abs(dot(step, first.along_j)));
        if (aside > shift_mm + shift_per_mm * (slice.height - first.height)) {
            slice.header->refuse("sheared, as by a tilted gantry: the slice lies " +
                                 exact_text(std::round(1000 * aside) / 1000) + " mm aside of " + first.header->file);
        }
    }
}

/// Of a series.
ImageGeometry geometry_of(const std::vector<DicomHeader>& images) {
    constexpr double even_share = 0.01;  // of the mean distance: so far slices may lie from even places
    const std::vector<Slice> slices = sorted_slices(images);
    require_stacked(slices);
    const Slice& first = slices.front();
    const double distance = slices.size() > 1
                                ? (slices.back().height - first.height) / static_cast<double>(slices.size() - 1)
                                : first.header->numbers<1>(dicom::slice_thickness, "SliceThickness")[0];
    const Direction normal = cross(first.along_i, first.along_j);
    ImageGeometry image = upright(first.header->file, {first.size[0], first.size[1], slices.size()},
                                  {scaled(first.along_i, first.spacing_mm[0]), scaled(first.along_j, first.spacing_mm[1]),
                                   scaled(normal, distance / length(normal))},
                                  first.position);
    DicomSeries& series = image.series.emplace();
    bool even = true;
    for (const Slice& slice : slices) {
        const double place = static_cast<double>(series.slices.size()) * distance;
        image.uneven_slices_mm.push_back(slice.height - first.height);
        even = even && std::abs(image.uneven_slices_mm.back() - place) <= even_share * distance;
        series.slices.push_back(
            {slice.header->file, slice.header->text(dicom::sop_class_uid), slice.header->text(dicom::sop_instance_uid)});
    }
    if (even) {
        image.uneven_slices_mm.clear();
    }
    for (const dicom::SeriesText& text : dicom::series_texts) {
        series.*text.text = first.header->text(text.tag);
    }
    return image;
}

}  // namespace

ImageGeometry read_dicom_folder(const std::filesystem::path& folder, const std::string& series_uid, const StopCheck& stop) {
    return geometry_of(images_in(folder, series_uid, stop));
}

Result<std::vector<DicomSeriesInfo>> list_series(const std::filesystem::path& folder, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<std::vector<DicomSeriesInfo>> {
        std::vector<DicomSeriesInfo> list;
        for (const auto& [uid, images] : series_in(folder, context.stop)) {
            const DicomHeader& first = images.front();
            DicomSeriesInfo& info = list.emplace_back();
            info = {uid, first.text(dicom::modality), first.text(dicom::series_description), images.size(), {}};
            try {
                (void)geometry_of(images);
            } catch (const Refused& refused) {
                info.refusal = refused.error.message;
            }
        }
        return list;
    });
}

}  // namespace lamella
