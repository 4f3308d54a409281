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

/// Within sequences, in every transfer syntax (PS3.5, 7.5).
inline constexpr Tag item = 0xfffee000;
inline constexpr Tag item_end = 0xfffee00d;
inline constexpr Tag sequence_end = 0xfffee0dd;

inline constexpr std::string_view implicit_little_endian = "1.2.840.10008.1.2";
inline constexpr std::string_view media_storage_directory = "1.2.840.10008.1.3.10";  ///< the class of DICOMDIR files

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
