// Attributes of DICOM by the names of PS3.6, and a structure set as bytes: implicit, little-endian, sequences and items of
// undefined length, so that nothing need be known of what follows. Explicit elements hold at most 65,534 bytes of contour
// data.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/little_endian.hpp"
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
inline constexpr Tag referenced_frame_number = 0x00081160;

/// Of functional groups.
inline constexpr Tag frame_content = 0x00209111;
inline constexpr Tag plane_position = 0x00209113;
inline constexpr Tag plane_orientation = 0x00209116;
inline constexpr Tag pixel_measures = 0x00289110;
inline constexpr Tag shared_groups = 0x52009229;
inline constexpr Tag per_frame_groups = 0x52009230;

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
inline constexpr std::array<SeriesText, 16> series_texts = {{
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
    {0x00200011, &DicomSeries::series_number},
    {study_description, &DicomSeries::study_description},
    {0x00080050, &DicomSeries::accession_number},
    {0x00080090, &DicomSeries::referring_physician_name},
    {0x00201040, &DicomSeries::position_reference_indicator},
}};

}  // namespace lamella::dicom

namespace lamella {

/// Of even length by a NUL.
inline std::string padded_uid(std::string_view uid) {
    return std::string(uid) + std::string(uid.size() % 2, '\0');
}

/// 2.25. and the UUID (version 8, RFC 9562) that the content's SHA-256 and the purpose give, in decimals: at most 44
/// characters.
std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose);

class DataSet {
public:
    /// Appends `value`, of even length by a space.
    void put(dicom::Tag tag, std::string_view value) {
        const std::size_t odd = value.size() % 2;
        put_head(tag, static_cast<std::uint32_t>(value.size() + odd));
        bytes_.append(value).append(odd, ' ');
    }

    void put_uid(dicom::Tag tag, std::string_view uid) { put(tag, padded_uid(uid)); }
    void put_number(dicom::Tag tag, std::uint64_t number) { put(tag, std::to_string(number)); }
    /// Binary: of two or four bytes each.
    template <class Integer, std::size_t count>
    void put_integers(dicom::Tag tag, const std::array<Integer, count>& values) {
        put_head(tag, static_cast<std::uint32_t>(sizeof values));
        bytes_.append(reinterpret_cast<const char*>(values.data()), sizeof values);
    }
    void put_short(dicom::Tag tag, std::size_t value) { put_integers(tag, std::array{static_cast<std::uint16_t>(value)}); }
    /// A tag as a value.
    void put_tag(dicom::Tag tag, dicom::Tag value) {
        put_integers(tag, std::array{static_cast<std::uint16_t>(value >> 16), static_cast<std::uint16_t>(value & 0xffff)});
    }
    /// The head of an element whose `length` bytes the caller writes, an even number.
    void begin_value(dicom::Tag tag, std::uint32_t length) { put_head(tag, length); }

    /// `put_items` puts the items, `put_elements` what is in one.
    template <class PutItems>
    void put_sequence(dicom::Tag tag, PutItems put_items) {
        put_head(tag, undefined);
        put_items();
        put_head(dicom::sequence_end, 0);
    }
    template <class PutElements>
    void put_item(PutElements put_elements) {
        put_head(dicom::item, undefined);
        put_elements();
        put_head(dicom::item_end, 0);
    }
    /// A sequence of an item for each of [0, count).
    template <class PutElements>
    void put_items(dicom::Tag tag, std::size_t count, PutElements put_elements) {
        put_sequence(tag, [&] {
            for (std::size_t i = 0; i < count; ++i) {
                put_item([&] { put_elements(i); });
            }
        });
    }

    /// Gives the bytes so far away, between two elements. They stay where they are until the next element.
    std::string_view take() noexcept {
        taken_.swap(bytes_);
        bytes_.clear();
        return taken_;
    }

    /// The begin of a file: preamble and file meta information, explicit.
    static std::string file_meta(std::string_view class_uid, std::string_view instance_uid) {
        std::string elements;
        put_explicit(elements, 0x00020001, "OB", std::string("\0\1", 2));
        put_explicit(elements, 0x00020002, "UI", padded_uid(class_uid));
        put_explicit(elements, 0x00020003, "UI", padded_uid(instance_uid));
        put_explicit(elements, dicom::transfer_syntax_uid, "UI", padded_uid(dicom::implicit_little_endian));
        // Lamella's own: a UUID that was drawn once.
        put_explicit(elements, 0x00020012, "UI", padded_uid("2.25.188650397291203361548463912043171620943"));
        put_explicit(elements, 0x00020013, "SH", "LAMELLA ");
        std::string length;
        put_little(length, static_cast<std::uint32_t>(elements.size()), 4);
        std::string all(128, '\0');
        all += "DICM";
        put_explicit(all, 0x00020000, "UL", length);
        return all + elements;
    }

private:
    static constexpr std::uint32_t undefined = 0xffffffff;

    static void put_little(std::string& out, std::uint32_t value, std::size_t bytes) {
        out.append(reinterpret_cast<const char*>(&value), bytes);
    }

    /// `value`: of even length.
    static void put_explicit(std::string& out, dicom::Tag tag, std::string_view type, const std::string& value) {
        put_little(out, tag >> 16, 2);
        put_little(out, tag & 0xffff, 2);
        out.append(type).append(type == "OB" ? 2 : 0, '\0');
        put_little(out, static_cast<std::uint32_t>(value.size()), type == "OB" ? 4 : 2);
        out.append(value);
    }

    void put_head(dicom::Tag tag, std::uint32_t length) {
        put_little(bytes_, tag >> 16, 2);
        put_little(bytes_, tag & 0xffff, 2);
        put_little(bytes_, length, 4);
    }

    std::string bytes_;
    std::string taken_;
};

/// A number as DICOM writes decimals, at most 16 characters: with `decimals` of them, or fewer where it must, and without
/// zeros at its end.
inline void put_decimal(std::string& out, double value, int decimals) {
    constexpr std::size_t most = 16;
    std::array<char, 64> text{};
    for (;; --decimals) {
        const char* end =
            std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals).ptr;
        std::string_view all(text.data(), static_cast<std::size_t>(end - text.data()));
        if (decimals > 0) {
            all = all.substr(0, all.find_last_not_of('0') + 1);
            all.remove_suffix(all.ends_with('.') ? 1 : 0);
        }
        if (all.size() <= most || decimals == 0) {
            out.append(all == "-0" ? "0" : all);
            return;
        }
    }
}

}  // namespace lamella
