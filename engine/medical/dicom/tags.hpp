// Attributes of DICOM by the names of PS3.6.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "lamella/medical/geometry.hpp"

namespace lamella::dicom {

/// Group and element.
using Tag = std::uint32_t;

inline constexpr Tag transfer_syntax_uid = 0x00020010;
inline constexpr Tag last_of_file_meta = 0x0002ffff;
inline constexpr Tag specific_character_set = 0x00080005;
inline constexpr Tag sop_class_uid = 0x00080016;
inline constexpr Tag sop_instance_uid = 0x00080018;
inline constexpr Tag modality = 0x00080060;
inline constexpr Tag study_description = 0x00081030;
inline constexpr Tag series_description = 0x0008103e;
inline constexpr Tag slice_thickness = 0x00180050;
inline constexpr Tag study_instance_uid = 0x0020000d;
inline constexpr Tag series_instance_uid = 0x0020000e;
inline constexpr Tag image_position_patient = 0x00200032;
inline constexpr Tag image_orientation_patient = 0x00200037;
inline constexpr Tag frame_of_reference_uid = 0x00200052;
inline constexpr Tag number_of_frames = 0x00280008;
inline constexpr Tag rows = 0x00280010;
inline constexpr Tag columns = 0x00280011;
inline constexpr Tag pixel_spacing = 0x00280030;

// Attributes that only structure sets have.
inline constexpr Tag manufacturer = 0x00080070;
inline constexpr Tag operators_name = 0x00081070;
inline constexpr Tag manufacturer_model_name = 0x00081090;
inline constexpr Tag referenced_sop_class_uid = 0x00081150;
inline constexpr Tag referenced_sop_instance_uid = 0x00081155;
inline constexpr Tag software_versions = 0x00181020;
inline constexpr Tag series_number = 0x00200011;
inline constexpr Tag structure_set_label = 0x30060002;
inline constexpr Tag structure_set_date = 0x30060008;
inline constexpr Tag structure_set_time = 0x30060009;
inline constexpr Tag referenced_frame_of_reference_sequence = 0x30060010;
inline constexpr Tag rt_referenced_study_sequence = 0x30060012;
inline constexpr Tag rt_referenced_series_sequence = 0x30060014;
inline constexpr Tag contour_image_sequence = 0x30060016;
inline constexpr Tag structure_set_roi_sequence = 0x30060020;
inline constexpr Tag roi_number = 0x30060022;
inline constexpr Tag referenced_frame_of_reference_uid = 0x30060024;
inline constexpr Tag roi_name = 0x30060026;
inline constexpr Tag roi_display_color = 0x3006002a;
inline constexpr Tag roi_generation_algorithm = 0x30060036;
inline constexpr Tag roi_contour_sequence = 0x30060039;
inline constexpr Tag contour_sequence = 0x30060040;
inline constexpr Tag contour_geometric_type = 0x30060042;
inline constexpr Tag number_of_contour_points = 0x30060046;
inline constexpr Tag contour_data = 0x30060050;
inline constexpr Tag rt_roi_observations_sequence = 0x30060080;
inline constexpr Tag observation_number = 0x30060082;
inline constexpr Tag referenced_roi_number = 0x30060084;
inline constexpr Tag rt_roi_interpreted_type = 0x300600a4;
inline constexpr Tag roi_interpreter = 0x300600a6;
inline constexpr Tag approval_status = 0x300e0002;

/// Within sequences, in every transfer syntax (PS3.5, 7.5).
inline constexpr Tag item = 0xfffee000;
inline constexpr Tag item_end = 0xfffee00d;
inline constexpr Tag sequence_end = 0xfffee0dd;

// Classes: of structure sets, of a study that is referred to, of DICOMDIR files.
inline constexpr std::string_view rt_structure_set_storage = "1.2.840.10008.5.1.4.1.1.481.3";
inline constexpr std::string_view detached_study_management = "1.2.840.10008.3.1.2.3.1";
inline constexpr std::string_view media_storage_directory = "1.2.840.10008.1.3.10";

/// A text of a series that its structure sets repeat.
struct SeriesText {
    Tag tag;
    std::string DicomSeries::*text;
};
inline constexpr std::array<SeriesText, 15> series_texts = {{
    {study_instance_uid, &DicomSeries::study_uid},
    {series_instance_uid, &DicomSeries::series_uid},
    {frame_of_reference_uid, &DicomSeries::frame_of_reference_uid},
    {specific_character_set, &DicomSeries::specific_character_set},
    {0x00100010, &DicomSeries::patient_name},
    {0x00100020, &DicomSeries::patient_id},
    {0x00100030, &DicomSeries::patient_birth_date},
    {0x00100040, &DicomSeries::patient_sex},
    {0x00080020, &DicomSeries::study_date},
    {0x00080030, &DicomSeries::study_time},
    {0x00200010, &DicomSeries::study_id},
    {study_description, &DicomSeries::study_description},
    {0x00080050, &DicomSeries::accession_number},
    {0x00080090, &DicomSeries::referring_physician_name},
    {0x00201040, &DicomSeries::position_reference_indicator},
}};

}  // namespace lamella::dicom
