// PS3.5, chapter 7: an element is its tag, in explicit syntaxes two letters for its type, the length of its value, the
// value. A sequence of undefined length ends with an element of its own, and so do its items.
#include "medical/dicom/elements.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "base/guard.hpp"

namespace lamella {

namespace {

constexpr std::uint32_t undefined_length = 0xffffffff;

constexpr std::array<dicom::Tag, 26> wanted = {dicom::transfer_syntax_uid,
                                               dicom::specific_character_set,
                                               dicom::sop_class_uid,
                                               dicom::sop_instance_uid,
                                               dicom::study_date,
                                               dicom::study_time,
                                               dicom::accession_number,
                                               dicom::modality,
                                               dicom::referring_physician_name,
                                               dicom::study_description,
                                               dicom::series_description,
                                               dicom::patient_name,
                                               dicom::patient_id,
                                               dicom::patient_birth_date,
                                               dicom::patient_sex,
                                               dicom::slice_thickness,
                                               dicom::study_instance_uid,
                                               dicom::series_instance_uid,
                                               dicom::study_id,
                                               dicom::image_position_patient,
                                               dicom::image_orientation_patient,
                                               dicom::frame_of_reference_uid,
                                               dicom::position_reference_indicator,
                                               dicom::number_of_frames,
                                               dicom::rows,
                                               dicom::columns};

bool is_wanted(dicom::Tag tag) {
    return tag == dicom::pixel_spacing || std::find(wanted.begin(), wanted.end(), tag) != wanted.end();
}

bool is_binary(dicom::Tag tag) {
    return tag == dicom::rows || tag == dicom::columns;
}

/// Types whose length takes four bytes, after two that mean nothing.
bool has_long_length(std::string_view type) {
    static constexpr std::array<std::string_view, 13> long_types = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                                    "SV", "UC", "UN", "UR", "UT", "UV"};
    return std::find(long_types.begin(), long_types.end(), type) != long_types.end();
}

bool is_type(std::string_view type) {
    return std::all_of(type.begin(), type.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
}

}  // namespace

std::uint64_t DicomElements::number(std::size_t at, std::size_t bytes, bool big_endian) const noexcept {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
        const std::size_t from = big_endian ? at + i : at + bytes - 1 - i;
        value = value << 8 | static_cast<unsigned char>(bytes_[from]);
    }
    return value;
}

dicom::Tag DicomElements::tag_at(std::size_t at, bool big_endian) const noexcept {
    return static_cast<dicom::Tag>(number(at, 2, big_endian) << 16 | number(at + 2, 2, big_endian));
}

bool DicomElements::skip_bytes(std::uint64_t count) noexcept {
    if (count > bytes_.size() - at_) {
        return false;
    }
    at_ += static_cast<std::size_t>(count);
    return true;
}

/// Its head, up to the value. False where the bytes end within it.
bool DicomElements::read_element(DicomEncoding encoding, Element& element, const DicomHeader& header) {
    constexpr std::size_t head_bytes = 8;
    const std::size_t begin = at_;
    if (!skip_bytes(head_bytes)) {
        return false;
    }
    element.tag = tag_at(begin, encoding.is_big_endian);
    element.unknown = false;
    const bool has_type = encoding.is_explicit && element.tag >> 16 != 0xfffe;
    if (!has_type) {
        element.length = static_cast<std::uint32_t>(number(begin + 4, 4, encoding.is_big_endian));
        return true;
    }
    const std::string_view type = bytes_.substr(begin + 4, 2);
    if (!is_type(type)) {
        throw Refused{header.refused("no DICOM element at byte " + std::to_string(file_offset_ + begin))};
    }
    if (!has_long_length(type)) {
        element.length = static_cast<std::uint32_t>(number(begin + 6, 2, encoding.is_big_endian));
        return true;
    }
    element.unknown = type == "UN";
    if (!skip_bytes(4)) {
        return false;
    }
    element.length = static_cast<std::uint32_t>(number(begin + head_bytes, 4, encoding.is_big_endian));
    return true;
}

/// False where the bytes end within it.
bool DicomElements::skip_value(const Element& element, const DicomHeader& header) {
    if (element.length != undefined_length) {
        return skip_bytes(element.length);
    }
    std::uint64_t open = 1;                                 // sequences and items without an end so far
    std::uint64_t implicit_from = element.unknown ? 1 : 0;  // how many were open where what is unknown began
    while (open > 0) {
        const DicomEncoding encoding = implicit_from != 0 ? DicomEncoding{} : encoding_;
        Element inner;
        if (!read_element(encoding, inner, header)) {
            return false;
        }
        if (inner.tag == dicom::item_end || inner.tag == dicom::sequence_end) {
            --open;
            implicit_from = open < implicit_from ? 0 : implicit_from;
        } else if (inner.length == undefined_length) {
            ++open;
            implicit_from = implicit_from == 0 && inner.unknown ? open : implicit_from;
        } else if (!skip_bytes(inner.length)) {
            return false;
        }
    }
    return true;
}

DicomElements::End DicomElements::collect(dicom::Tag last, DicomHeader& header) {
    while (bytes_.size() - at_ >= 4) {
        if (tag_at(at_, encoding_.is_big_endian) > last) {
            return End::passed;
        }
        Element element;
        if (!read_element(encoding_, element, header)) {
            return End::bytes_end;
        }
        const std::size_t begin = at_;
        if (!skip_value(element, header)) {
            return End::bytes_end;
        }
        if (element.length == undefined_length || !is_wanted(element.tag)) {
            continue;
        }
        if (!is_binary(element.tag)) {
            header.set(element.tag, std::string(bytes_.substr(begin, element.length)));
        } else if (element.length == 2 || element.length == 4) {
            header.set(element.tag, std::to_string(number(begin, element.length, encoding_.is_big_endian)));
        }
    }
    return End::bytes_end;
}

}  // namespace lamella
