#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/structure_set.hpp"
#include "lamella/version.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/identity.hpp"
#include "medical/dicom/keyhole.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

// --- who a structure set says that it is

constexpr std::string_view rt_structure_set_storage = "1.2.840.10008.5.1.4.1.1.481.3";

/// SHA-256 over all that decides the bytes of a structure set.
Sha256::Digest content_of(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
                          const Context& context) {
    ContentHash hash;
    hash.add(std::string_view(version), static_cast<std::uint64_t>(options.holes), options.label,
             std::uint64_t{options.seconds_since_1970.has_value()},
             static_cast<std::uint64_t>(options.seconds_since_1970.value_or(0)));
    hash.add_image(image);
    const PacedStop stop(context.stop);
    for (const Roi& roi : rois) {
        stop.stop_if_asked();
        const auto [red, green, blue] = roi.colour;
        hash.add(roi.name, std::uint64_t{red}, std::uint64_t{green}, std::uint64_t{blue});
        hash.add_contours(*roi.result);
    }
    return hash.digest();
}

struct SetIdentity : Identity {
    std::string label;
    std::vector<std::string> roi_names;  ///< at most 64 characters; none repeats

    SetIdentity(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
                const Context& context)
        : Identity(image, content_of(rois, image, options, context), rt_structure_set_storage, "RTSTRUCT",
                   is_ascii(options.label) &&
                       std::all_of(rois.begin(), rois.end(), [](const Roi& roi) { return is_ascii(roi.name); }),
                   options.seconds_since_1970),
          label(name_text(options.label, 16)) {
        values[0x00081070] = "";  // OperatorsName
        for (const Roi& roi : rois) {
            roi_names.push_back(roi.name);
        }
        roi_names = distinct(roi_names);
    }
};

// --- the file

void put_images(DataSet& out, std::span<const DicomSeries::Instance> slices) {
    out.put_items(0x30060016, slices.size(), [&](std::size_t i) {  // ContourImageSequence
        put_reference(out, slices[i]);
    });
}

/// Module Structure Set.
void put_structure_set(DataSet& out, const SetIdentity& identity, const ImageGeometry& image) {
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
            file.append(data[i].take());
        }
    }
    for (const ContourItems& worker : workers) {
        for (const auto count : {&StructureSetSummary::contours, &StructureSetSummary::points, &StructureSetSummary::holes,
                                 &StructureSetSummary::open_contours, &StructureSetSummary::nested_contours}) {
            total.*count += worker.counts.*count;
        }
    }
}

}  // namespace

Result<StructureSetSummary> write_structure_set(std::span<const Roi> rois, const ImageGeometry& image,
                                                const std::filesystem::path& path, const StructureSetOptions& options,
                                                const Context& context) noexcept {
    return guarded(context, [&]() -> Result<StructureSetSummary> {
        require_series(image, path, options.without_ct, "a structure set");
        if (rois.empty()) {
            refuse_output(path, "a structure set of no mesh");
        }
        for (const Roi& roi : rois) {
            require_cut(roi.result, roi.name, image.size[2]);
            if (!has_any(*roi.result, Role::outer)) {
                refuse_output(path, "'" + roi.name + "' has no closed contour on any slice of the image");
            }
        }
        const SetIdentity identity(rois, image, options, context);
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
                file.append(data.take());
                write_contours(rois[i], image, options.holes, parallel, file, total);
            });
            data.put_number(0x30060084, i + 1);  // ReferencedROINumber
        });
        put_end(data, rois.size());
        file.append(data.take());
        require(file.commit());
        total.roi_names = identity.roi_names;
        return total;
    });
}

}  // namespace lamella
