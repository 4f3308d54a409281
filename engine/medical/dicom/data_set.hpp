// A DICOM data set as bytes: implicit, little-endian, sequences and items of undefined length, so that nothing need be known
// of what follows. Explicit elements hold at most 65,534 bytes of contour data.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "medical/dicom/tags.hpp"

namespace lamella {

class DataSet {
public:
    /// Appends `value`, of even length by a padding byte.
    void put(dicom::Tag tag, std::string_view value, char padding = ' ');
    /// A UID is padded by NUL.
    void put_uid(dicom::Tag tag, std::string_view uid) { put(tag, uid, '\0'); }
    void put_number(dicom::Tag tag, std::uint64_t number) { put(tag, std::to_string(number)); }

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
    template <class PutElements>
    void put_sequence_of_one(dicom::Tag tag, PutElements put_elements) {
        put_sequence(tag, [&] { put_item(put_elements); });
    }

    /// The bytes so far; they may be taken away between two elements.
    std::string& bytes() noexcept { return bytes_; }

private:
    static constexpr std::uint32_t undefined = 0xffffffff;

    void put_head(dicom::Tag tag, std::uint32_t length);

    std::string bytes_;
};

/// The begin of a file: preamble and file meta information, explicit.
std::string file_meta(std::string_view class_uid, std::string_view instance_uid);

/// A number as DICOM writes decimals, at most 16 characters: with `decimals` of them, or fewer where it must, and without
/// zeros at its end.
void put_decimal(std::string& out, double value, int decimals);

}  // namespace lamella
