// A folder with series of DICOM images: which there are, and the geometry of one.
#include <cerrno>
#include <map>
#include <numeric>
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

std::size_t slices_of(const std::vector<DicomHeader>& images) {
    return std::accumulate(images.begin(), images.end(), std::size_t{0}, [](std::size_t sum, const DicomHeader& image) {
        return sum + std::max<std::size_t>(image.frames.size(), 1);
    });
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
                counted(slices_of(images), "slice") + ")";
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

/// The plane of a slice: an image, or a frame of one.
struct Slice {
    const DicomHeader* header = nullptr;
    std::size_t frame = 0;                ///< from 1 on; 0: the file is one image
    std::array<std::uint64_t, 2> size{};  ///< voxels along i, j
    std::array<double, 2> spacing_mm{};
    Direction along_i{};  ///< unit vectors
    Direction along_j{};
    Direction position{};
    double height = 0;  ///< along the normal

    [[noreturn]] void refuse(const std::string& what) const { header->refuse(what, frame); }
    std::string name() const { return (frame == 0 ? "" : "frame " + std::to_string(frame) + " of ") + header->file; }
};

/// Throws Refused unless the functional groups say where each frame of a file lies.
void require_groups(const DicomHeader& header) {
    const std::string frames = header.text(dicom::number_of_frames);
    if (header.frames.empty()) {
        header.refuse("its frames (" + one_line(frames) +
                      ") have no functional groups, which would say where each lies, as " + "a file of the class " +
                      one_line(header.text(dicom::sop_class_uid)) + "; convert it to a file a slice, or to NIfTI");
    }
    if (frames != std::to_string(header.frames.size())) {
        header.refuse("its functional groups are of " + counted(header.frames.size(), "frame") + ", its NumberOfFrames is " +
                      one_line(frames));
    }
}

Slice slice_of(const DicomHeader& header, std::size_t frame) {
    Slice slice;
    slice.header = &header;
    slice.frame = frame;
    slice.size = {header.side(dicom::columns, "Columns"), header.side(dicom::rows, "Rows")};
    slice.position = header.numbers<3>(dicom::image_position_patient, "ImagePositionPatient", frame);
    if (!(length(slice.position) <= largest_coordinate_mm)) {
        slice.refuse("ImagePositionPatient lies farther than " + exact_text(largest_coordinate_mm) + " mm away");
    }
    const std::array<double, 6> along =
        header.numbers<6>(dicom::image_orientation_patient, "ImageOrientationPatient", frame);
    slice.along_i = {along[0], along[1], along[2]};
    slice.along_j = {along[3], along[4], along[5]};
    for (Direction* const axis : {&slice.along_i, &slice.along_j}) {
        if (std::abs(length(*axis) - 1) > 1e-3) {
            slice.refuse("ImageOrientationPatient holds no unit vectors");
        }
        *axis = scaled(*axis, 1 / length(*axis));
    }
    const auto [of_rows, of_columns] = header.numbers<2>(dicom::pixel_spacing, "PixelSpacing", frame);
    slice.spacing_mm = {of_columns, of_rows};
    if (!(of_rows > 0 && of_columns > 0)) {
        slice.refuse("PixelSpacing is not above 0");
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
        slice.refuse(std::string("other ") + other + " than " + first.name() + ", which is of the same series");
    }
}

/// All slices, sorted along the normal.
std::vector<Slice> sorted_slices(const std::vector<DicomHeader>& images) {
    std::vector<Slice> slices;
    for (const DicomHeader& image : images) {
        if (image.has_several_frames()) {
            require_groups(image);
        }
        const std::size_t last = image.frames.size();
        for (std::size_t frame = std::min<std::size_t>(last, 1); frame <= last; ++frame) {
            Slice& slice = slices.emplace_back(slice_of(image, frame));
            require_alike(slice, slices.front());
            slice.height = dot(cross(slices.front().along_i, slices.front().along_j), slice.position);
        }
    }
    std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.height < b.height; });
    return slices;
}

/// How far slices lie aside along one of their axes for each mm along the normal: 0 where they lie upright. Throws Refused
/// where they lie on no line, which a few that are off do not turn.
double slope_along(const Direction& axis, const std::vector<Slice>& slices) {
    // Headers state places with few decimals.
    constexpr double shift_mm = 0.02;      // a slice may lie so far aside of the others, and
    constexpr double shift_per_mm = 1e-4;  // so much farther for each mm from the middle
    const double middle_height = slices[slices.size() / 2].height;
    std::vector<double> places(slices.size());
    std::vector<double> rests(slices.size());
    std::transform(slices.begin(), slices.end(), places.begin(),
                   [&](const Slice& slice) { return dot(axis, slice.position); });
    double slope = 0;
    for (const bool is_last : {false, true}) {
        std::transform(slices.begin(), slices.end(), places.begin(), rests.begin(),
                       [slope](const Slice& slice, double place) { return place - slope * slice.height; });
        const double middle = median(rests);
        std::size_t i = 0;
        while (i < slices.size() &&
               std::abs(rests[i] - middle) <= shift_mm + shift_per_mm * std::abs(slices[i].height - middle_height)) {
            ++i;
        }
        if (i == slices.size()) {
            break;
        }
        if (is_last) {
            slices[i].refuse("lies " + rounded_mm(std::abs(rests[i] - middle)) + " aside of the line of the other slices");
        }
        const std::size_t apart = slices.size() / 2;
        std::vector<double> slopes;
        for (std::size_t end = apart; end < slices.size(); ++end) {
            slopes.push_back((places[end] - places[end - apart]) / (slices[end].height - slices[end - apart].height));
        }
        slope = median(std::move(slopes));
    }
    return slope;
}

/// Of a series.
ImageGeometry geometry_of(const std::vector<DicomHeader>& images) {
    constexpr double same_place_mm = 1e-4;
    constexpr double even_share = 0.01;  // of the mean distance: so far slices may lie from even places
    const std::vector<Slice> slices = sorted_slices(images);
    for (std::size_t i = 1; i < slices.size(); ++i) {
        if (slices[i].height - slices[i - 1].height < same_place_mm) {
            slices[i].refuse("lies at the same place as " + slices[i - 1].name() +
                             (slices[i].frame == 0 ? "" : ", as of several times or stacks, where an image has one"));
        }
    }
    const Slice& first = slices.front();
    const double distance = slices.size() > 1
                                ? (slices.back().height - first.height) / static_cast<double>(slices.size() - 1)
                                : first.header->numbers<1>(dicom::slice_thickness, "SliceThickness", first.frame)[0];
    const Direction normal = cross(first.along_i, first.along_j);
    ImageGeometry image = upright(first.header->file, {first.size[0], first.size[1], slices.size()},
                                  {scaled(first.along_i, first.spacing_mm[0]), scaled(first.along_j, first.spacing_mm[1]),
                                   scaled(normal, distance / length(normal))},
                                  first.position);
    for (std::size_t axis = 0; axis < 2; ++axis) {
        image.shear_mm[axis] = distance * slope_along(image.axes[axis], slices);
    }
    warn_of_shear(image, first.header->file);
    DicomSeries& series = image.series.emplace();
    bool even = true;
    for (const Slice& slice : slices) {
        const double place = static_cast<double>(series.slices.size()) * distance;
        image.uneven_slices_mm.push_back(slice.height - first.height);
        even = even && std::abs(image.uneven_slices_mm.back() - place) <= even_share * distance;
        series.slices.push_back({slice.header->file, slice.header->text(dicom::sop_class_uid),
                                 slice.header->text(dicom::sop_instance_uid), slice.frame});
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

ImageGeometry read_dicom_file(const std::filesystem::path& path) {
    std::vector<DicomHeader> images;
    if (std::optional<DicomHeader> header = read_dicom_header(path); header && header->has_several_frames()) {
        images.push_back(*std::move(header));
        return geometry_of(images);
    }
    refuse_image(path_text(path), "one DICOM file; name the folder that holds its series");
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
