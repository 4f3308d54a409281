#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/structure_set.hpp"
#include "lamella/version.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/identity.hpp"
#include "medical/dicom/keyhole.hpp"
#include "medical/geometry/directions.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_slices_a_task = 4;

Refused refused(const std::filesystem::path& path, const std::string& what) {
    return {{ErrorCode::invalid_argument, "'" + path.string() + "': " + what}};
}

/// Modules Patient, General Study, RT Series, General Equipment, Frame of Reference.
void put_begin(DataSet& out, const StructureSetIdentity& identity, const DicomSeries& series) {
    if (!identity.character_set.empty()) {
        out.put(dicom::specific_character_set, identity.character_set);
    }
    out.put_uid(dicom::sop_class_uid, dicom::rt_structure_set_storage);
    out.put_uid(dicom::sop_instance_uid, identity.instance_uid);
    out.put(dicom::study_date, plain_text(series.study_date));
    out.put(dicom::study_time, plain_text(series.study_time));
    out.put(dicom::accession_number, plain_text(series.accession_number));
    out.put(dicom::modality, "RTSTRUCT");
    out.put(dicom::manufacturer, "lamella");
    out.put(dicom::referring_physician_name, plain_text(series.referring_physician_name));
    if (!series.study_description.empty()) {
        out.put(dicom::study_description, plain_text(series.study_description));
    }
    out.put(dicom::operators_name, "");
    out.put(dicom::manufacturer_model_name, "lamella");
    out.put(dicom::patient_name, plain_text(series.patient_name));
    out.put(dicom::patient_id, plain_text(series.patient_id));
    out.put(dicom::patient_birth_date, plain_text(series.patient_birth_date));
    out.put(dicom::patient_sex, plain_text(series.patient_sex));
    out.put(dicom::software_versions, version);
    out.put_uid(dicom::study_instance_uid, identity.study_uid);
    out.put_uid(dicom::series_instance_uid, identity.series_uid);
    out.put(dicom::study_id, plain_text(series.study_id));
    out.put(dicom::series_number, "");
    out.put_uid(dicom::frame_of_reference_uid, identity.frame_of_reference_uid);
    out.put(dicom::position_reference_indicator, plain_text(series.position_reference_indicator));
}

/// Which frame of reference, and which images.
void put_frame_of_reference(DataSet& out, const StructureSetIdentity& identity, const ImageGeometry& image) {
    const auto put_series = [&] {
        out.put_uid(dicom::series_instance_uid, image.series->series_uid);
        out.put_sequence(dicom::contour_image_sequence, [&] {
            for (const DicomSeries::Instance& slice : image.series->slices) {
                out.put_item([&] {
                    out.put_uid(dicom::referenced_sop_class_uid, slice.sop_class_uid);
                    out.put_uid(dicom::referenced_sop_instance_uid, slice.sop_instance_uid);
                });
            }
        });
    };
    const auto put_study = [&] {
        out.put_uid(dicom::referenced_sop_class_uid, dicom::detached_study_management);
        out.put_uid(dicom::referenced_sop_instance_uid, identity.study_uid);
        out.put_sequence_of_one(dicom::rt_referenced_series_sequence, put_series);
    };
    out.put_sequence_of_one(dicom::referenced_frame_of_reference_sequence, [&] {
        out.put_uid(dicom::frame_of_reference_uid, identity.frame_of_reference_uid);
        if (image.series) {
            out.put_sequence_of_one(dicom::rt_referenced_study_sequence, put_study);
        }
    });
}

/// Module Structure Set.
void put_structure_set(DataSet& out, const StructureSetIdentity& identity, const ImageGeometry& image) {
    out.put(dicom::structure_set_label, identity.label);
    out.put(dicom::structure_set_date, identity.date);
    out.put(dicom::structure_set_time, identity.time);
    put_frame_of_reference(out, identity, image);
    out.put_sequence(dicom::structure_set_roi_sequence, [&] {
        for (std::size_t i = 0; i < identity.roi_names.size(); ++i) {
            out.put_item([&] {
                out.put_number(dicom::roi_number, i + 1);
                out.put_uid(dicom::referenced_frame_of_reference_uid, identity.frame_of_reference_uid);
                out.put(dicom::roi_name, identity.roi_names[i]);
                out.put(dicom::roi_generation_algorithm, "");
            });
        }
    });
}

/// Module RT ROI Observations, and the approval.
void put_end(DataSet& out, std::size_t rois) {
    out.put_sequence(dicom::rt_roi_observations_sequence, [&] {
        for (std::size_t i = 0; i < rois; ++i) {
            out.put_item([&] {
                out.put_number(dicom::observation_number, i + 1);
                out.put_number(dicom::referenced_roi_number, i + 1);
                out.put(dicom::rt_roi_interpreted_type, "");
                out.put(dicom::roi_interpreter, "");
            });
        }
    });
    out.put(dicom::approval_status, "UNAPPROVED");
}

void flush(DataSet& data, OutputFile& file) {
    file.append(data.bytes());
    data.bytes().clear();
}

bool is_outer(const Contour& contour) {
    return contour.role == Role::outer;
}

bool is_hole(const Contour& contour) {
    return contour.role == Role::hole;
}

/// The contours of a ROI as items of a Contour Sequence. One a thread.
class ContourItems {
public:
    /// `image` and `roi` must outlive it.
    ContourItems(const ImageGeometry& image, const Roi& roi, HoleForm holes)
        : image_(image),
          roi_(roi),
          holes_(holes),
          exclusive_or_(holes == HoleForm::exclusive_or &&
                        std::any_of(roi.result->contours.begin(), roi.result->contours.end(), is_hole)),
          axes_{image.axes[0], image.axes[1], cross(image.axes[0], image.axes[1])},
          // So many that a number lies nearer to its point of the grid than to any other.
          decimals_(std::clamp(static_cast<int>(std::ceil(-std::log10(roi.result->unit_mm / 4))), 0, 14)) {}

    /// Puts the items of slice k, which lies at `height_mm`; counts. Throws Refused (invalid_argument) where a contour is
    /// too long for its element.
    void put(std::uint64_t slice, double height_mm, DataSet& out, StructureSetSummary& counts) {
        const SliceResult& result = *roi_.result;
        const std::span<const Contour> contours = result.contours_of(result.layers[result.layer_of[slice]]);
        for (std::size_t begin = 0; begin < contours.size();) {
            const Contour& first = contours[begin];
            if (!is_outer(first) && !is_hole(first)) {
                counts.open_contours += first.role == Role::open ? 1 : 0;
                ++begin;
                continue;
            }
            const std::size_t end = region_end(contours, begin);
            if (is_outer(first) && first.parent >= 0 && is_outer(result.contours[static_cast<std::size_t>(first.parent)])) {
                ++counts.nested_contours;
            }
            put_region({slice, height_mm, out, counts}, contours.subspan(begin, end - begin));
            begin = end;
        }
    }

private:
    struct Slice {
        std::uint64_t index;
        double height_mm;
        DataSet& out;
        StructureSetSummary& counts;
    };

    /// Where the holes end that follow their outer contour.
    std::size_t region_end(std::span<const Contour> contours, std::size_t begin) const {
        const auto own = &contours[begin] - roi_.result->contours.data();
        std::size_t end = begin + 1;
        while (is_outer(contours[begin]) && end < contours.size() && is_hole(contours[end]) && contours[end].parent == own) {
            ++end;
        }
        return end;
    }

    void put_region(const Slice& slice, std::span<const Contour> region) {
        points_.clear();
        for (const Contour& contour : region) {
            points_.push_back(roi_.result->points_of(contour));
            slice.counts.holes += is_hole(contour) ? 1 : 0;
        }
        if (holes_ == HoleForm::keyhole) {
            return put_item(slice, keyhole_.join(points_));
        }
        for (const std::span<const Point>& contour : points_) {
            put_item(slice, keyhole_.join({&contour, 1}));
        }
    }

    void put_item(const Slice& slice, std::span<const RingPoint> ring) {
        constexpr std::size_t most_bytes = 0xfffffff0;
        constexpr std::size_t most_bytes_a_point = 3 * 17;
        if (ring.size() > most_bytes / most_bytes_a_point) {
            throw Refused{{ErrorCode::invalid_argument, "'" + roi_.name + "': a contour of " + std::to_string(ring.size()) +
                                                            " points is too long for DICOM; --tolerance MM leaves fewer"}};
        }
        data_.clear();
        for (const RingPoint& point : ring) {
            write_point(point, slice.height_mm);
        }
        data_.pop_back();
        DataSet& out = slice.out;
        out.put_item([&] {
            if (image_.series) {
                out.put_sequence_of_one(dicom::contour_image_sequence, [&] {
                    out.put_uid(dicom::referenced_sop_class_uid, image_.series->slices[slice.index].sop_class_uid);
                    out.put_uid(dicom::referenced_sop_instance_uid, image_.series->slices[slice.index].sop_instance_uid);
                });
            }
            out.put(dicom::contour_geometric_type, exclusive_or_ ? "CLOSEDPLANAR_XOR" : "CLOSED_PLANAR");
            out.put_number(dicom::number_of_contour_points, ring.size());
            out.put(dicom::contour_data, data_);
        });
        ++slice.counts.contours;
        slice.counts.points += ring.size();
    }

    void write_point(const RingPoint& point, double height_mm) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double in_slice = roi_.result->unit_mm * (axes_[0][axis] * point.x + axes_[1][axis] * point.y);
            put_decimal(data_, image_.origin_mm[axis] + in_slice + axes_[2][axis] * height_mm, decimals_);
            data_ += '\\';
        }
    }

    const ImageGeometry& image_;
    const Roi& roi_;
    HoleForm holes_;
    bool exclusive_or_;
    std::array<Direction, 3> axes_;  ///< of x, y and z of the slicing, in the patient
    int decimals_;
    std::string data_;  ///< of a contour
    Keyhole keyhole_;
    std::vector<std::span<const Point>> points_;  ///< of a region
};

void add(StructureSetSummary& total, const StructureSetSummary& counts) {
    total.contours += counts.contours;
    total.points += counts.points;
    total.holes += counts.holes;
    total.open_contours += counts.open_contours;
    total.nested_contours += counts.nested_contours;
}

/// The contours of a ROI: slices become text on all threads, and are written in their order.
void write_contours(const Roi& roi, const ImageGeometry& image, HoleForm holes, const Parallel& parallel, OutputFile& file,
                    StructureSetSummary& total) {
    const std::vector<double> heights = image.slice_heights_mm();
    const std::size_t at_once = most_slices_a_task * static_cast<std::size_t>(parallel.threads());
    std::vector<ContourItems> workers(static_cast<std::size_t>(parallel.threads()), {image, roi, holes});
    std::vector<DataSet> data(at_once);
    std::vector<StructureSetSummary> counts(at_once);
    for (std::size_t first = 0; first < heights.size() && !file.failed(); first += at_once) {
        const std::size_t count = std::min(at_once, heights.size() - first);
        parallel.run(count, [&](std::size_t i, int worker) {
            counts[i] = {};
            workers[static_cast<std::size_t>(worker)].put(first + i, heights[first + i], data[i], counts[i]);
        });
        for (std::size_t i = 0; i < count; ++i) {
            flush(data[i], file);
            add(total, counts[i]);
        }
    }
}

void require_uid(const std::filesystem::path& path, const std::string& uid, const char* keyword, const std::string& where) {
    if (uid.empty() || uid.size() > 64 || uid.find_first_not_of("0123456789.") != std::string::npos) {
        throw refused(path, where + " states no usable " + keyword + ", which a structure set must name");
    }
}

void require_series(const ImageGeometry& image, const std::filesystem::path& path, bool without_ct) {
    if (!image.series) {
        if (!without_ct) {
            throw refused(path, "a structure set is drawn on the slices of a CT, a folder with a DICOM series");
        }
        return;
    }
    const DicomSeries& series = *image.series;
    if (series.slices.size() != image.size[2]) {
        throw refused(path, "the CT has other slices than its geometry");
    }
    require_uid(path, series.study_uid, "StudyInstanceUID", "the CT");
    require_uid(path, series.series_uid, "SeriesInstanceUID", "the CT");
    require_uid(path, series.frame_of_reference_uid, "FrameOfReferenceUID", "the CT");
    for (const DicomSeries::Instance& slice : series.slices) {
        require_uid(path, slice.sop_class_uid, "SOPClassUID", slice.file);
        require_uid(path, slice.sop_instance_uid, "SOPInstanceUID", slice.file);
    }
}

void require_contours(std::span<const Roi> rois, const ImageGeometry& image, const std::filesystem::path& path) {
    if (rois.empty()) {
        throw refused(path, "a structure set of no mesh");
    }
    for (const Roi& roi : rois) {
        if (roi.result == nullptr || roi.result->layer_of.size() != image.size[2] ||
            roi.result->layers.size() < roi.result->all_layers) {
            throw refused(path, "'" + roi.name + "' was not cut at the slices of the image, all of them");
        }
        if (std::none_of(roi.result->contours.begin(), roi.result->contours.end(),
                         [](const Contour& contour) { return contour.role == Role::outer || contour.role == Role::hole; })) {
            throw refused(path, "'" + roi.name + "' has no closed contour on any slice of the image");
        }
    }
}

Result<StructureSetSummary> write_all(std::span<const Roi> rois, const ImageGeometry& image,
                                      const std::filesystem::path& path, const StructureSetOptions& options) {
    const StructureSetIdentity identity = identity_of(rois, image, options);
    Parallel parallel(options.control);
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    file->append(file_meta(dicom::rt_structure_set_storage, identity.instance_uid));
    DataSet data;
    StructureSetSummary total;
    put_begin(data, identity, image.series.value_or(DicomSeries{}));
    put_structure_set(data, identity, image);
    data.put_sequence(dicom::roi_contour_sequence, [&] {
        for (std::size_t i = 0; i < rois.size(); ++i) {
            data.put_item([&] {
                const auto& colour = rois[i].colour;
                data.put(dicom::roi_display_color,
                         std::to_string(colour[0]) + "\\" + std::to_string(colour[1]) + "\\" + std::to_string(colour[2]));
                data.put_sequence(dicom::contour_sequence, [&] {
                    flush(data, *file);
                    write_contours(rois[i], image, options.holes, parallel, *file, total);
                });
                data.put_number(dicom::referenced_roi_number, i + 1);
            });
        }
    });
    put_end(data, rois.size());
    flush(data, *file);
    if (const Status written = file->commit(); !written) {
        return written.error();
    }
    total.roi_names = identity.roi_names;
    return total;
}

}  // namespace

Result<StructureSetSummary> write_structure_set(std::span<const Roi> rois, const ImageGeometry& image,
                                                const std::filesystem::path& path,
                                                const StructureSetOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<StructureSetSummary> {
        require_series(image, path, options.without_ct);
        require_contours(rois, image, path);
        return write_all(rois, image, path, options);
    });
}

}  // namespace lamella
