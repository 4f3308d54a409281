#include <map>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/version.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/keyhole.hpp"
#include "medical/geometry/headers.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_slices_a_task = 4;

/// Modules Patient, General Study, RT Series, General Equipment, Frame of Reference.
void put_begin(DataSet& out, const StructureSetIdentity& identity, const DicomSeries& series) {
    std::map<dicom::Tag, std::string> values;  // in the order of tags, as a data set is
    for (const dicom::SeriesText& text : dicom::series_texts) {
        values[text.tag] = plain_text(series.*text.text);
    }
    for (const dicom::Tag tag : {dicom::operators_name, dicom::series_number}) {
        values[tag] = "";
    }
    values[dicom::specific_character_set] = identity.character_set;
    values[dicom::sop_class_uid] = padded_uid(dicom::rt_structure_set_storage);
    values[dicom::sop_instance_uid] = padded_uid(identity.instance_uid);
    values[dicom::study_instance_uid] = padded_uid(identity.study_uid);
    values[dicom::series_instance_uid] = padded_uid(identity.series_uid);
    values[dicom::frame_of_reference_uid] = padded_uid(identity.frame_of_reference_uid);
    values[dicom::modality] = "RTSTRUCT";
    values[dicom::manufacturer] = values[dicom::manufacturer_model_name] = "lamella";
    values[dicom::software_versions] = version;
    for (const auto& [tag, value] : values) {
        const bool is_left_out = tag == dicom::specific_character_set || tag == dicom::study_description;
        if (!value.empty() || !is_left_out) {
            out.put(tag, value);
        }
    }
}

void put_reference(DataSet& out, std::string_view class_uid, std::string_view instance_uid) {
    out.put_uid(dicom::referenced_sop_class_uid, class_uid);
    out.put_uid(dicom::referenced_sop_instance_uid, instance_uid);
}

void put_images(DataSet& out, std::span<const DicomSeries::Instance> slices) {
    out.put_items(dicom::contour_image_sequence, slices.size(),
                  [&](std::size_t i) { put_reference(out, slices[i].sop_class_uid, slices[i].sop_instance_uid); });
}

/// Which frame of reference, and which images.
void put_frame_of_reference(DataSet& out, const StructureSetIdentity& identity, const ImageGeometry& image) {
    const auto put_series = [&](std::size_t) {
        out.put_uid(dicom::series_instance_uid, image.series->series_uid);
        put_images(out, image.series->slices);
    };
    const auto put_study = [&](std::size_t) {
        put_reference(out, dicom::detached_study_management, identity.study_uid);
        out.put_items(dicom::rt_referenced_series_sequence, 1, put_series);
    };
    out.put_items(dicom::referenced_frame_of_reference_sequence, 1, [&](std::size_t) {
        out.put_uid(dicom::frame_of_reference_uid, identity.frame_of_reference_uid);
        if (image.series) {
            out.put_items(dicom::rt_referenced_study_sequence, 1, put_study);
        }
    });
}

/// Module Structure Set.
void put_structure_set(DataSet& out, const StructureSetIdentity& identity, const ImageGeometry& image) {
    out.put(dicom::structure_set_label, identity.label);
    out.put(dicom::structure_set_date, identity.date);
    out.put(dicom::structure_set_time, identity.time);
    put_frame_of_reference(out, identity, image);
    out.put_items(dicom::structure_set_roi_sequence, identity.roi_names.size(), [&](std::size_t i) {
        out.put_number(dicom::roi_number, i + 1);
        out.put_uid(dicom::referenced_frame_of_reference_uid, identity.frame_of_reference_uid);
        out.put(dicom::roi_name, identity.roi_names[i]);
        out.put(dicom::roi_generation_algorithm, "");
    });
}

/// Module RT ROI Observations, and the approval.
void put_end(DataSet& out, std::size_t rois) {
    out.put_items(dicom::rt_roi_observations_sequence, rois, [&](std::size_t i) {
        out.put_number(dicom::observation_number, i + 1);
        out.put_number(dicom::referenced_roi_number, i + 1);
        out.put(dicom::rt_roi_interpreted_type, "");
        out.put(dicom::roi_interpreter, "");
    });
    out.put(dicom::approval_status, "UNAPPROVED");
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
class ContourItems {
public:
    /// `image` and `roi` must outlive it.
    ContourItems(const ImageGeometry& image, const Roi& roi, HoleForm holes)
        : image_(image),
          roi_(roi),
          holes_(holes),
          exclusive_or_(holes == HoleForm::exclusive_or && has_any(*roi.result, Role::hole)),
          axes_{image.axes[0], image.axes[1], cross(image.axes[0], image.axes[1])},
          // So many that a number lies nearer to its point of the grid than to any other.
          decimals_(std::clamp(static_cast<int>(std::ceil(-std::log10(roi.result->info.grid_mm / 4))), 0, 14)) {}

    /// Puts the items of slice k, which lies at `height_mm`, and adds them to counts(). Throws Refused (invalid_argument)
    /// where a contour is too long for its element.
    void put(std::uint64_t slice, double height_mm, DataSet& out) {
        const LayerView layer = (*roi_.result)[roi_.result->info.layer_of[slice]];
        for (const Contour& contour : layer.contours) {
            counts_.open_contours += contour.role == Role::open ? 1 : 0;
        }
        for (const Island island : layer.islands()) {
            const Contour* const around = layer.parent_of(*island.outer);
            counts_.nested_contours += around != nullptr && around->role == Role::outer ? 1 : 0;
            counts_.holes += island.holes.size();
            points_.assign(1, layer.points_of(*island.outer));
            for (const Contour& hole : island.holes) {
                points_.push_back(layer.points_of(hole));
            }
            if (holes_ == HoleForm::keyhole) {
                put_item(slice, height_mm, keyhole_.join(points_), out);
                continue;
            }
            for (const std::span<const Point>& contour : points_) {
                put_item(slice, height_mm, keyhole_.join({&contour, 1}), out);
            }
        }
    }

    const StructureSetSummary& counts() const noexcept { return counts_; }

private:
    void put_item(std::uint64_t slice, double height_mm, std::span<const RingPoint> ring, DataSet& out) {
        constexpr std::size_t most_bytes = 0xfffffff0;
        constexpr std::size_t most_bytes_a_point = 3 * 17;
        if (ring.size() > most_bytes / most_bytes_a_point) {
            throw Refused{{ErrorCode::invalid_argument, "'" + roi_.name + "': a contour of " + std::to_string(ring.size()) +
                                                            " points is too long for DICOM; --simplify MM leaves fewer"}};
        }
        data_.clear();
        for (const RingPoint& point : ring) {
            write_point(point, height_mm);
        }
        data_.pop_back();
        out.put_item([&] {
            if (image_.series) {
                put_images(out, std::span(image_.series->slices).subspan(slice, 1));
            }
            out.put(dicom::contour_geometric_type, exclusive_or_ ? "CLOSEDPLANAR_XOR" : "CLOSED_PLANAR");
            out.put_number(dicom::number_of_contour_points, ring.size());
            out.put(dicom::contour_data, data_);
        });
        ++counts_.contours;
        counts_.points += ring.size();
    }

    void write_point(const RingPoint& point, double height_mm) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double in_slice = roi_.result->info.grid_mm * (axes_[0][axis] * point.x + axes_[1][axis] * point.y);
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
    StructureSetSummary counts_;
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
        add(total, worker.counts());
    }
}

void require_uid(const std::filesystem::path& path, const std::string& uid, const char* keyword, const std::string& where) {
    if (uid.empty() || uid.size() > 64 || uid.find_first_not_of("0123456789.") != std::string::npos) {
        refuse_output(path, where + " states no usable " + keyword + ", which a structure set must name");
    }
}

void require_series(const ImageGeometry& image, const std::filesystem::path& path, bool without_ct) {
    if (!image.series) {
        if (!without_ct) {
            refuse_output(path, "a structure set is drawn on the slices of a CT, a folder with a DICOM series");
        }
        return;
    }
    const DicomSeries& series = *image.series;
    if (series.slices.size() != image.size[2]) {
        refuse_output(path, "the CT has other slices than its geometry");
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
        refuse_output(path, "a structure set of no mesh");
    }
    for (const Roi& roi : rois) {
        require_cut(roi.result, roi.name, image.size[2]);
        if (!has_any(*roi.result, Role::outer)) {
            refuse_output(path, "'" + roi.name + "' has no closed contour on any slice of the image");
        }
    }
}

Result<StructureSetSummary> write_all(std::span<const Roi> rois, const ImageGeometry& image,
                                      const std::filesystem::path& path, const StructureSetOptions& options,
                                      const Context& context) {
    const StructureSetIdentity identity = identity_of(rois, image, options, context);
    const Parallel parallel(context);
    OutputFile file = require(OutputFile::create(path));
    file.append(DataSet::file_meta(dicom::rt_structure_set_storage, identity.instance_uid));
    DataSet data;
    StructureSetSummary total;
    put_begin(data, identity, image.series.value_or(DicomSeries{}));
    put_structure_set(data, identity, image);
    data.put_items(dicom::roi_contour_sequence, rois.size(), [&](std::size_t i) {
        const auto& colour = rois[i].colour;
        data.put(dicom::roi_display_color,
                 std::to_string(colour[0]) + "\\" + std::to_string(colour[1]) + "\\" + std::to_string(colour[2]));
        data.put_sequence(dicom::contour_sequence, [&] {
            flush(data, file);
            write_contours(rois[i], image, options.holes, parallel, file, total);
        });
        data.put_number(dicom::referenced_roi_number, i + 1);
    });
    put_end(data, rois.size());
    flush(data, file);
    require(file.commit());
    total.roi_names = identity.roi_names;
    return total;
}

}  // namespace

Result<StructureSetSummary> write_structure_set(std::span<const Roi> rois, const ImageGeometry& image,
                                                const std::filesystem::path& path, const StructureSetOptions& options,
                                                const Context& context) noexcept {
    return guarded(context, [&]() -> Result<StructureSetSummary> {
        require_series(image, path, options.without_ct);
        require_contours(rois, image, path);
        return write_all(rois, image, path, options, context);
    });
}

}  // namespace lamella
