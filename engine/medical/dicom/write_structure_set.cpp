#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/structure_set.hpp"
#include "lamella/version.hpp"
#include "medical/dicom/contour_items.hpp"
#include "medical/dicom/identity.hpp"
#include "medical/dicom/put_elements.hpp"
#include "medical/dicom/texts.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_slices_a_task = 4;

Refused refused(const std::filesystem::path& path, const std::string& what) {
    return {{ErrorCode::invalid_argument, "'" + path.string() + "': " + what}};
}

/// The UIDs that the file needs, and its texts.
struct Identity {
    std::string instance_uid;
    std::string series_uid;
    std::string study_uid;
    std::string frame_of_reference_uid;
    std::string date;
    std::string time;
    DicomTexts texts;
};

Identity identity_of(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options) {
    const std::array<unsigned char, 32> content = content_of(rois, image, options);
    Identity identity;
    identity.instance_uid = uid_of(content, "instance");
    identity.series_uid = uid_of(content, "series");
    identity.study_uid = image.series ? image.series->study_uid : uid_of(content, "study");
    identity.frame_of_reference_uid =
        image.series ? image.series->frame_of_reference_uid : uid_of(content, "frame of reference");
    if (options.seconds_since_1970) {
        const auto seconds = static_cast<std::time_t>(*options.seconds_since_1970);
        std::tm utc{};
        if (::gmtime_r(&seconds, &utc) == nullptr || utc.tm_year < -1900 || utc.tm_year > 9999 - 1900) {
            throw Refused{{ErrorCode::invalid_argument, "the time of the structure set lies beyond the year 9999"}};
        }
        std::array<char, 32> text{};
        (void)std::strftime(text.data(), text.size(), "%Y%m%d", &utc);
        // The C library does not pad years below 1000.
        identity.date = text.data();
        identity.date.insert(0, 8 - std::min<std::size_t>(8, identity.date.size()), '0');
        (void)std::strftime(text.data(), text.size(), "%H%M%S", &utc);
        identity.time = text.data();
    }
    identity.texts = dicom_texts(rois, image.series ? &*image.series : nullptr, options.label);
    return identity;
}

/// Modules Patient, General Study, RT Series, General Equipment, Frame of Reference.
void put_begin(std::string& out, const Identity& identity, const DicomSeries& series) {
    const DicomTexts& texts = identity.texts;
    if (!texts.character_set.empty()) {
        put_element(out, dicom::specific_character_set, texts.character_set);
    }
    put_uid(out, dicom::sop_class_uid, dicom::rt_structure_set_storage);
    put_uid(out, dicom::sop_instance_uid, identity.instance_uid);
    put_element(out, dicom::study_date, plain_text(series.study_date));
    put_element(out, dicom::study_time, plain_text(series.study_time));
    put_element(out, dicom::accession_number, plain_text(series.accession_number));
    put_element(out, dicom::modality, "RTSTRUCT");
    put_element(out, dicom::manufacturer, "lamella");
    put_element(out, dicom::referring_physician_name, plain_text(series.referring_physician_name));
    if (!series.study_description.empty()) {
        put_element(out, dicom::study_description, plain_text(series.study_description));
    }
    put_element(out, dicom::operators_name, "");
    put_element(out, dicom::manufacturer_model_name, "lamella");
    put_element(out, dicom::patient_name, plain_text(series.patient_name));
    put_element(out, dicom::patient_id, plain_text(series.patient_id));
    put_element(out, dicom::patient_birth_date, plain_text(series.patient_birth_date));
    put_element(out, dicom::patient_sex, plain_text(series.patient_sex));
    put_element(out, dicom::software_versions, version);
    put_uid(out, dicom::study_instance_uid, identity.study_uid);
    put_uid(out, dicom::series_instance_uid, identity.series_uid);
    put_element(out, dicom::study_id, plain_text(series.study_id));
    put_element(out, dicom::series_number, "");
    put_uid(out, dicom::frame_of_reference_uid, identity.frame_of_reference_uid);
    put_element(out, dicom::position_reference_indicator, plain_text(series.position_reference_indicator));
}

/// Which frame of reference, and which images.
void put_frame_of_reference(std::string& out, const Identity& identity, const ImageGeometry& image) {
    begin_sequence(out, dicom::referenced_frame_of_reference_sequence);
    put_uid(out, dicom::frame_of_reference_uid, identity.frame_of_reference_uid);
    if (image.series) {
        begin_sequence(out, dicom::rt_referenced_study_sequence);
        put_uid(out, dicom::referenced_sop_class_uid, dicom::detached_study_management);
        put_uid(out, dicom::referenced_sop_instance_uid, identity.study_uid);
        begin_sequence(out, dicom::rt_referenced_series_sequence);
        put_uid(out, dicom::series_instance_uid, image.series->series_uid);
        begin_empty_sequence(out, dicom::contour_image_sequence);
        for (const DicomSeries::Instance& slice : image.series->slices) {
            begin_item(out);
            put_uid(out, dicom::referenced_sop_class_uid, slice.sop_class_uid);
            put_uid(out, dicom::referenced_sop_instance_uid, slice.sop_instance_uid);
            end_item(out);
        }
        end_items(out);
        end_sequence(out);
        end_sequence(out);
    }
    end_sequence(out);
}

/// Module Structure Set.
void put_structure_set(std::string& out, const Identity& identity, const ImageGeometry& image) {
    put_element(out, dicom::structure_set_label, identity.texts.label);
    put_element(out, dicom::structure_set_date, identity.date);
    put_element(out, dicom::structure_set_time, identity.time);
    put_frame_of_reference(out, identity, image);
    begin_empty_sequence(out, dicom::structure_set_roi_sequence);
    for (std::size_t i = 0; i < identity.texts.roi_names.size(); ++i) {
        begin_item(out);
        put_number(out, dicom::roi_number, i + 1);
        put_uid(out, dicom::referenced_frame_of_reference_uid, identity.frame_of_reference_uid);
        put_element(out, dicom::roi_name, identity.texts.roi_names[i]);
        put_element(out, dicom::roi_generation_algorithm, "");
        end_item(out);
    }
    end_items(out);
}

/// Module RT ROI Observations, and the approval.
void put_end(std::string& out, std::size_t rois) {
    begin_empty_sequence(out, dicom::rt_roi_observations_sequence);
    for (std::size_t i = 0; i < rois; ++i) {
        begin_item(out);
        put_number(out, dicom::observation_number, i + 1);
        put_number(out, dicom::referenced_roi_number, i + 1);
        put_element(out, dicom::rt_roi_interpreted_type, "");
        put_element(out, dicom::roi_interpreter, "");
        end_item(out);
    }
    end_items(out);
    put_element(out, dicom::approval_status, "UNAPPROVED");
}

void add(StructureSetSummary& total, const StructureSetSummary& counts) {
    total.contours += counts.contours;
    total.points += counts.points;
    total.holes += counts.holes;
    total.open_contours += counts.open_contours;
    total.nested_contours += counts.nested_contours;
}

/// The contours of a ROI: slices become text on all threads, and are written in their order.
StructureSetSummary write_contours(const Roi& roi, const ImageGeometry& image, HoleForm holes, const Parallel& parallel,
                                   OutputFile& file) {
    const std::vector<double> heights = image.slice_heights_mm();
    const SlicePlacement placement(image, roi.result->unit_mm);
    const std::size_t at_once = most_slices_a_task * static_cast<std::size_t>(parallel.threads());
    std::vector<ContourItems> workers(static_cast<std::size_t>(parallel.threads()), {image, roi, placement, holes});
    std::vector<std::string> texts(at_once);
    std::vector<StructureSetSummary> counts(at_once);
    StructureSetSummary total;
    for (std::size_t first = 0; first < heights.size() && !file.failed(); first += at_once) {
        const std::size_t count = std::min(at_once, heights.size() - first);
        parallel.run(count, [&](std::size_t i, int worker) {
            texts[i].clear();
            counts[i] = {};
            workers[static_cast<std::size_t>(worker)].append(first + i, heights[first + i], texts[i], counts[i]);
        });
        for (std::size_t i = 0; i < count; ++i) {
            file.append(texts[i]);
            add(total, counts[i]);
        }
    }
    return total;
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
    const Identity identity = identity_of(rois, image, options);
    Parallel parallel(options.control);
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    std::string text = file_meta(dicom::rt_structure_set_storage, identity.instance_uid);
    put_begin(text, identity, image.series.value_or(DicomSeries{}));
    put_structure_set(text, identity, image);
    begin_empty_sequence(text, dicom::roi_contour_sequence);
    StructureSetSummary total;
    for (std::size_t i = 0; i < rois.size(); ++i) {
        begin_item(text);
        const auto& colour = rois[i].colour;
        put_element(text, dicom::roi_display_color,
                    std::to_string(colour[0]) + "\\" + std::to_string(colour[1]) + "\\" + std::to_string(colour[2]));
        begin_empty_sequence(text, dicom::contour_sequence);
        file->append(text);
        add(total, write_contours(rois[i], image, options.holes, parallel, *file));
        text.clear();
        end_items(text);
        put_number(text, dicom::referenced_roi_number, i + 1);
        end_item(text);
    }
    end_items(text);
    put_end(text, rois.size());
    file->append(text);
    if (const Status written = file->commit(); !written) {
        return written.error();
    }
    total.roi_names = identity.texts.roi_names;
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
