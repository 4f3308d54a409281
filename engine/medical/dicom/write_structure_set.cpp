#include <chrono>
#include <map>
#include <type_traits>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/system/sha256.hpp"
#include "base/utf8.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/medical/structure_set.hpp"
#include "lamella/version.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/keyhole.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

// --- who a structure set says that it is

constexpr std::string_view rt_structure_set_storage = "1.2.840.10008.5.1.4.1.1.481.3";

/// Adds bytes of values, little-endian as the host's; of a text, or of points, after their number.
template <class Value>
void add_to(Sha256& hash, const Value& value) noexcept {
    if constexpr (std::is_arithmetic_v<Value>) {
        static_assert(sizeof value == 8);
        hash.add(&value, sizeof value);
    } else {
        add_to(hash, std::uint64_t{std::size(value)});
        hash.add(std::data(value), std::size(value) * sizeof(*std::data(value)));
    }
}

/// SHA-256 over all that decides the bytes of a structure set.
Sha256::Digest content_of(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
                          const Context& context) {
    Sha256 hash;
    const auto add = [&hash](const auto&... values) { (add_to(hash, values), ...); };
    add(std::string_view(version), static_cast<std::uint64_t>(options.holes), options.label,
        std::uint64_t{options.seconds_since_1970.has_value()},
        static_cast<std::uint64_t>(options.seconds_since_1970.value_or(0)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& [x, y, z] = image.axes[axis];
        add(image.size[axis], image.spacing_mm[axis], image.origin_mm[axis], x, y, z);
    }
    for (const double height : image.slice_heights_mm()) {
        add(height);
    }
    add(std::uint64_t{image.series.has_value()});
    if (image.series) {
        for (const dicom::SeriesText& text : dicom::series_texts) {
            add(*image.series.*text.text);
        }
        for (const DicomSeries::Instance& slice : image.series->slices) {
            add(slice.sop_class_uid, slice.sop_instance_uid, slice.frame);
        }
    }
    const PacedStop stop(context.stop);
    for (const Roi& roi : rois) {
        stop.stop_if_asked();
        const auto [red, green, blue] = roi.colour;
        add(roi.name, std::uint64_t{red}, std::uint64_t{green}, std::uint64_t{blue}, roi.result->info.grid_mm);
        for (const std::uint64_t index : roi.result->info.layer_of) {
            const Layer& layer = roi.result->layers[index];
            add(std::uint64_t{layer.contour_count});
            for (const Contour& contour : roi.result->contours_of(layer)) {
                add(static_cast<std::uint64_t>(contour.role), roi.result->points_of(contour));
            }
        }
    }
    return hash.digest();
}

bool is_ascii(const std::string& text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

/// At most `most` characters; what a text of DICOM must not hold becomes _.
std::string name_text(const std::string& name, std::size_t most, bool beyond_ascii) {
    std::string text;
    std::size_t characters = 0;
    for (std::size_t at = 0; at < name.size() && characters < most; ++characters) {
        const std::size_t bytes = character_bytes(name, at);
        const bool allowed =
            bytes == 1 ? name[at] >= ' ' && name[at] != '\\' && name[at] != 0x7f : bytes > 1 && beyond_ascii;
        text += allowed ? name.substr(at, bytes) : "_";
        at += std::max<std::size_t>(bytes, 1);
    }
    return text;
}

/// A text of the CT without control characters but those that switch character sets.
std::string plain_text(std::string text) {
    constexpr char escape = 0x1b;
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' && c != escape; }, ' ');
    return text;
}

/// The date and the time of day, UTC.
std::array<std::string, 2> date_and_time(std::int64_t seconds_since_1970) {
    constexpr std::int64_t begin_of_year_0 = -62'167'219'200;
    constexpr std::int64_t end_of_year_9999 = 253'402'300'800;
    if (seconds_since_1970 < begin_of_year_0 || seconds_since_1970 >= end_of_year_9999) {
        throw Refused{{ErrorCode::invalid_argument, "the time of the structure set lies beyond the year 9999"}};
    }
    const std::chrono::sys_seconds at{std::chrono::seconds(seconds_since_1970)};
    const auto midnight = std::chrono::floor<std::chrono::days>(at);
    const std::chrono::year_month_day date(midnight);
    const std::chrono::hh_mm_ss time(at - midnight);
    const auto digits = [](std::int64_t number, std::size_t count) {
        const std::string text = std::to_string(number);
        return std::string(count - text.size(), '0') + text;
    };
    return {digits(int{date.year()}, 4) + digits(unsigned{date.month()}, 2) + digits(unsigned{date.day()}, 2),
            digits(time.hours().count(), 2) + digits(time.minutes().count(), 2) + digits(time.seconds().count(), 2)};
}

/// Patient, study and frame of reference are the CT's where there is one, and so is the character set. Names are UTF-8:
/// where the CT has texts in another set, characters beyond ASCII become _.
struct Identity {
    /// Of the modules Patient, General Study, RT Series, General Equipment and Frame of Reference, in the order of tags, as
    /// a data set is.
    std::map<dicom::Tag, std::string> values;
    std::array<std::string, 2> date_and_time{};  ///< empty where none was asked for
    std::string label;
    std::vector<std::string> roi_names;  ///< at most 64 characters; none repeats

    Identity(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
             const Context& context) {
        const DicomSeries series = image.series.value_or(DicomSeries{});
        bool ct_in_ascii = true;
        for (const dicom::SeriesText& text : dicom::series_texts) {
            ct_in_ascii = ct_in_ascii && is_ascii(series.*text.text);
            values[text.tag] = plain_text(series.*text.text);
        }
        const Sha256::Digest content = content_of(rois, image, options, context);
        values[dicom::sop_class_uid] = padded_uid(rt_structure_set_storage);
        values[dicom::sop_instance_uid] = padded_uid(uid_of(content, "instance"));
        values[dicom::series_instance_uid] = padded_uid(uid_of(content, "series"));
        values[dicom::study_instance_uid] = padded_uid(image.series ? series.study_uid : uid_of(content, "study"));
        values[dicom::frame_of_reference_uid] =
            padded_uid(image.series ? series.frame_of_reference_uid : uid_of(content, "frame of reference"));
        values[dicom::modality] = "RTSTRUCT";
        values[0x00080070] = "lamella";  // Manufacturer
        values[0x00081070] = "";         // OperatorsName
        values[0x00081090] = "lamella";  // ManufacturerModelName
        values[0x00181020] = version;    // SoftwareVersions
        if (options.seconds_since_1970) {
            date_and_time = lamella::date_and_time(*options.seconds_since_1970);
        }
        constexpr const char* utf_8 = "ISO_IR 192";
        constexpr std::size_t most_of_name = 64;
        std::string& character_set = values[dicom::specific_character_set];
        const bool names_in_ascii = is_ascii(options.label) &&
                                    std::all_of(rois.begin(), rois.end(), [](const Roi& roi) { return is_ascii(roi.name); });
        // Texts that switch sets are ASCII by their bytes.
        if (!names_in_ascii && ct_in_ascii && character_set.find("2022") == std::string::npos) {
            character_set = utf_8;
        }
        label = name_text(options.label, 16, character_set == utf_8);
        for (const Roi& roi : rois) {
            roi_names.push_back(name_text(roi.name, most_of_name, character_set == utf_8));
        }
        roi_names = distinct_names(roi_names, most_of_name);
        for (const dicom::Tag tag : {dicom::specific_character_set, dicom::study_description}) {
            if (values[tag].empty()) {
                values.erase(tag);
            }
        }
    }
};

// --- the file

void put_reference(DataSet& out, std::string_view class_uid, std::string_view instance_uid) {
    out.put_uid(0x00081150, class_uid);     // ReferencedSOPClassUID
    out.put_uid(0x00081155, instance_uid);  // ReferencedSOPInstanceUID
}

void put_images(DataSet& out, std::span<const DicomSeries::Instance> slices) {
    out.put_items(0x30060016, slices.size(), [&](std::size_t i) {  // ContourImageSequence
        put_reference(out, slices[i].sop_class_uid, slices[i].sop_instance_uid);
        if (slices[i].frame != 0) {
            out.put_number(dicom::referenced_frame_number, slices[i].frame);
        }
    });
}

/// Module Structure Set.
void put_structure_set(DataSet& out, const Identity& identity, const ImageGeometry& image) {
    const auto put_series = [&](std::size_t) {
        out.put_uid(dicom::series_instance_uid, image.series->series_uid);
        put_images(out, image.series->slices);
    };
    const auto put_study = [&](std::size_t) {
        put_reference(out, "1.2.840.10008.3.1.2.3.1",
                      identity.values.at(dicom::study_instance_uid));  // Detached Study Management
        out.put_items(0x30060014, 1, put_series);                      // RTReferencedSeriesSequence
    };
    out.put(0x30060002, identity.label);             // StructureSetLabel
    out.put(0x30060008, identity.date_and_time[0]);  // StructureSetDate
    out.put(0x30060009, identity.date_and_time[1]);  // StructureSetTime
    out.put_items(0x30060010, 1, [&](std::size_t) {  // ReferencedFrameOfReferenceSequence
        out.put_uid(dicom::frame_of_reference_uid, identity.values.at(dicom::frame_of_reference_uid));
        if (image.series) {
            out.put_items(0x30060012, 1, put_study);  // RTReferencedStudySequence
        }
    });
    out.put_items(0x30060020, identity.roi_names.size(), [&](std::size_t i) {        // StructureSetROISequence
        out.put_number(0x30060022, i + 1);                                           // ROINumber
        out.put_uid(0x30060024, identity.values.at(dicom::frame_of_reference_uid));  // ReferencedFrameOfReferenceUID
        out.put(0x30060026, identity.roi_names[i]);                                  // ROIName
        out.put(0x30060036, "");                                                     // ROIGenerationAlgorithm
    });
}

/// Module RT ROI Observations, and the approval.
void put_end(DataSet& out, std::size_t rois) {
    out.put_items(0x30060080, rois, [&](std::size_t i) {  // RTROIObservationsSequence
        out.put_number(0x30060082, i + 1);                // ObservationNumber
        out.put_number(0x30060084, i + 1);                // ReferencedROINumber
        out.put(0x300600a4, "");                          // RTROIInterpretedType
        out.put(0x300600a6, "");                          // ROIInterpreter
    });
    out.put(0x300e0002, "UNAPPROVED");  // ApprovalStatus
}

void flush(DataSet& data, OutputFile& file) {
    file.append(data.bytes());
    data.bytes().clear();
}

bool has_any(const SliceResult& result, Role role) {
    return std::any_of(result.contours.begin(), result.contours.end(),
                       [role](const Contour& contour) { return contour.role == role; });
}

/// The contours of a ROI as items of a Contour Sequence. One a thread.
struct ContourItems {
    const ImageGeometry& image;
    const Roi& roi;
    HoleForm holes;
    const char* type;  ///< ContourGeometricType
    StructureSetSummary counts{};
    std::string data{};  ///< of a contour
    Keyhole keyhole{};
    std::vector<std::span<const Point>> points{};  ///< of a region

    /// Puts the items of slice k, which lies at `height_mm`, and counts them. Throws Refused (invalid_argument) where a
    /// contour is too long for its element.
    void put(std::uint64_t slice, double height_mm, DataSet& out) {
        const LayerView layer = (*roi.result)[roi.result->info.layer_of[slice]];
        for (const Contour& contour : layer.contours) {
            counts.open_contours += contour.role == Role::open ? 1 : 0;
        }
        for (const Island island : layer.islands()) {
            const Contour* const around = layer.parent_of(*island.outer);
            counts.nested_contours += around != nullptr && around->role == Role::outer ? 1 : 0;
            counts.holes += island.holes.size();
            points.assign(1, layer.points_of(*island.outer));
            for (const Contour& hole : island.holes) {
                points.push_back(layer.points_of(hole));
            }
            const std::size_t at_once = holes == HoleForm::keyhole ? points.size() : 1;
            for (std::size_t first = 0; first < points.size(); first += at_once) {
                put_item(slice, height_mm, keyhole.join(std::span(points).subspan(first, at_once)), out);
            }
        }
    }

    void put_item(std::uint64_t slice, double height_mm, std::span<const RingPoint> ring, DataSet& out) {
        constexpr std::size_t most_bytes = 0xfffffff0;
        constexpr std::size_t most_bytes_a_point = 3 * 17;
        if (ring.size() >= most_bytes / most_bytes_a_point) {
            throw Refused{{ErrorCode::invalid_argument, "'" + roi.name + "': a contour of " + std::to_string(ring.size()) +
                                                            " points is too long for DICOM; --simplify MM leaves fewer"}};
        }
        const double grid_mm = roi.result->info.grid_mm;
        // So many that a number lies nearer to its point of the grid than to any other.
        const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(grid_mm / 4))), 0, 14);
        const Direction normal = cross(image.axes[0], image.axes[1]);
        data.clear();
        const auto add = [&](const RingPoint& point) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double in_slice = grid_mm * (image.axes[0][axis] * point.x + image.axes[1][axis] * point.y);
                put_decimal(data, image.origin_mm[axis] + in_slice + normal[axis] * height_mm, decimals);
                data += '\\';
            }
        };
        std::for_each(ring.begin(), ring.end(), add);
        // In the middle of the closing edge: plastimatch passes over the last point of contours that are not axial.
        add({(ring.front().x + ring.back().x) / 2, (ring.front().y + ring.back().y) / 2});
        data.pop_back();
        out.put_item([&] {
            if (image.series) {
                put_images(out, std::span(image.series->slices).subspan(slice, 1));
            }
            out.put(0x30060042, type);                    // ContourGeometricType
            out.put_number(0x30060046, ring.size() + 1);  // NumberOfContourPoints
            out.put(0x30060050, data);                    // ContourData
        });
        ++counts.contours;
        counts.points += ring.size() + 1;
    }
};

/// The contours of a ROI: slices become text on all threads, and are written in their order.
void write_contours(const Roi& roi, const ImageGeometry& image, HoleForm holes, const Parallel& parallel, OutputFile& file,
                    StructureSetSummary& total) {
    constexpr std::size_t most_slices_a_task = 4;
    const std::vector<double> heights = image.slice_heights_mm();
    const std::size_t at_once = most_slices_a_task * static_cast<std::size_t>(parallel.threads());
    const bool excludes = holes == HoleForm::exclusive_or && has_any(*roi.result, Role::hole);
    std::vector<ContourItems> workers(static_cast<std::size_t>(parallel.threads()),
                                      {image, roi, holes, excludes ? "CLOSEDPLANAR_XOR" : "CLOSED_PLANAR"});
    std::vector<DataSet> data(at_once);
    for (std::size_t first = 0; first < heights.size() && !file.failed(); first += at_once) {
        const std::size_t count = std::min(at_once, heights.size() - first);
        parallel.run(count, [&](std::size_t i, int worker) {
            workers[static_cast<std::size_t>(worker)].put(first + i, heights[first + i], data[i]);
        });
        for (std::size_t i = 0; i < count; ++i) {
            flush(data[i], file);
        }
    }
    for (const ContourItems& worker : workers) {
        for (const auto count : {&StructureSetSummary::contours, &StructureSetSummary::points, &StructureSetSummary::holes,
                                 &StructureSetSummary::open_contours, &StructureSetSummary::nested_contours}) {
            total.*count += worker.counts.*count;
        }
    }
}

void require_series(const ImageGeometry& image, const std::filesystem::path& path, bool without_ct) {
    if (!image.series) {
        if (!without_ct) {
            refuse_output(path, "a structure set is drawn on the slices of a CT, a folder with a DICOM series");
        }
        return;
    }
    const auto require_uid = [&](const std::string& uid, const char* keyword, const std::string& where) {
        if (uid.empty() || uid.size() > 64 || uid.find_first_not_of("0123456789.") != std::string::npos) {
            refuse_output(path, where + " states no usable " + keyword + ", which a structure set must name");
        }
    };
    const DicomSeries& series = *image.series;
    if (series.slices.size() != image.size[2]) {
        refuse_output(path, "the CT has other slices than its geometry");
    }
    require_uid(series.study_uid, "StudyInstanceUID", "the CT");
    require_uid(series.series_uid, "SeriesInstanceUID", "the CT");
    require_uid(series.frame_of_reference_uid, "FrameOfReferenceUID", "the CT");
    for (const DicomSeries::Instance& slice : series.slices) {
        require_uid(slice.sop_class_uid, "SOPClassUID", slice.file);
        require_uid(slice.sop_instance_uid, "SOPInstanceUID", slice.file);
    }
}

}  // namespace

std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose) {
    Sha256 hash;
    hash.add(content.data(), content.size());
    hash.add(purpose.data(), purpose.size());
    Sha256::Digest uuid = hash.digest();  // its first 16 bytes, the most significant one first
    uuid[6] = static_cast<unsigned char>((uuid[6] & 0x0f) | 0x80);
    uuid[8] = static_cast<unsigned char>((uuid[8] & 0x3f) | 0x80);
    std::string decimals;
    for (bool is_done = false; !is_done;) {  // divides them by 10
        unsigned rest = 0;
        is_done = true;
        for (unsigned char& byte : std::span(uuid).first<16>()) {
            rest = rest << 8 | byte;
            byte = static_cast<unsigned char>(rest / 10);
            rest %= 10;
            is_done = is_done && byte == 0;
        }
        decimals += static_cast<char>('0' + rest);
    }
    std::reverse(decimals.begin(), decimals.end());
    return "2.25." + decimals;
}

Result<StructureSetSummary> write_structure_set(std::span<const Roi> rois, const ImageGeometry& image,
                                                const std::filesystem::path& path, const StructureSetOptions& options,
                                                const Context& context) noexcept {
    return guarded(context, [&]() -> Result<StructureSetSummary> {
        require_series(image, path, options.without_ct);
        if (rois.empty()) {
            refuse_output(path, "a structure set of no mesh");
        }
        for (const Roi& roi : rois) {
            require_cut(roi.result, roi.name, image.size[2]);
            if (!has_any(*roi.result, Role::outer)) {
                refuse_output(path, "'" + roi.name + "' has no closed contour on any slice of the image");
            }
        }
        const Identity identity(rois, image, options, context);
        const Parallel parallel(context);
        OutputFile file = require(OutputFile::create(path));
        file.append(DataSet::file_meta(rt_structure_set_storage, identity.values.at(dicom::sop_instance_uid)));
        DataSet data;
        StructureSetSummary total;
        for (const auto& [tag, value] : identity.values) {
            data.put(tag, value);
        }
        put_structure_set(data, identity, image);
        data.put_items(0x30060039, rois.size(), [&](std::size_t i) {  // ROIContourSequence
            const auto& [red, green, blue] = rois[i].colour;
            data.put(0x3006002a,  // ROIDisplayColor
                     std::to_string(red) + "\\" + std::to_string(green) + "\\" + std::to_string(blue));
            data.put_sequence(0x30060040, [&] {  // ContourSequence
                flush(data, file);
                write_contours(rois[i], image, options.holes, parallel, file, total);
            });
            data.put_number(0x30060084, i + 1);  // ReferencedROINumber
        });
        put_end(data, rois.size());
        flush(data, file);
        require(file.commit());
        total.roi_names = identity.roi_names;
        return total;
    });
}

}  // namespace lamella
