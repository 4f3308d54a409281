// Elements of DICOM as bytes: implicit, little-endian, sequences and items of undefined length, so that nothing need be
// known of what follows. Explicit elements hold at most 65,534 bytes of contour data.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "medical/dicom/tags.hpp"

namespace lamella {

/// Appends `value`, of even length by a padding byte.
void put_element(std::string& out, dicom::Tag tag, std::string_view value, char padding = ' ');
/// A UID is padded by NUL.
inline void put_uid(std::string& out, dicom::Tag tag, std::string_view uid) {
    put_element(out, tag, uid, '\0');
}
void put_number(std::string& out, dicom::Tag tag, std::uint64_t number);

/// Begins a sequence, and its first item.
void begin_sequence(std::string& out, dicom::Tag tag);
/// Ends an item and begins the next.
void next_item(std::string& out);
/// Ends the last item, and the sequence.
void end_sequence(std::string& out);
/// For sequences without an item: a head, and an end.
void begin_empty_sequence(std::string& out, dicom::Tag tag);
void begin_item(std::string& out);
void end_item(std::string& out);
void end_items(std::string& out);

/// What a file begins with: preamble and file meta information, explicit.
std::string file_meta(std::string_view class_uid, std::string_view instance_uid);

/// A number as DICOM writes decimals, at most 16 characters: with `decimals` of them, or fewer where it must, and without
/// zeros at its end.
void put_decimal(std::string& out, double value, int decimals);

}  // namespace lamella
