// A structure set as bytes: implicit, little-endian, sequences and items of undefined length, so that nothing need be known
// of what follows. Explicit elements hold at most 65,534 bytes of contour data.
#pragma once

#include <array>
#include <charconv>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/medical/structure_set.hpp"
#include "medical/dicom/tags.hpp"

namespace lamella {

/// Of even length by a NUL.
inline std::string padded_uid(std::string_view uid) {
    return std::string(uid) + std::string(uid.size() % 2, '\0');
}

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

    /// The bytes so far; they may be taken away between two elements.
    std::string& bytes() noexcept { return bytes_; }

    /// The begin of a file: preamble and file meta information, explicit.
    static std::string file_meta(std::string_view class_uid, std::string_view instance_uid) {
        std::string elements;
        put_explicit(elements, 0x00020001, "OB", std::string("\0\1", 2));
        put_explicit(elements, 0x00020002, "UI", padded_uid(class_uid));
        put_explicit(elements, 0x00020003, "UI", padded_uid(instance_uid));
        put_explicit(elements, dicom::transfer_syntax_uid, "UI", padded_uid("1.2.840.10008.1.2"));
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
    static void put_little(std::string& out, std::uint32_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) {
            out += static_cast<char>(value >> 8 * i & 0xff);
        }
    }

    /// `value`: of even length.
    static void put_explicit(std::string& out, dicom::Tag tag, std::string_view type, const std::string& value) {
        put_little(out, tag >> 16, 2);
        put_little(out, tag & 0xffff, 2);
        out.append(type);
        if (type == "OB") {
            out.append(2, '\0');
            put_little(out, static_cast<std::uint32_t>(value.size()), 4);
        } else {
            put_little(out, static_cast<std::uint32_t>(value.size()), 2);
        }
        out.append(value);
    }

    static constexpr std::uint32_t undefined = 0xffffffff;

    void put_head(dicom::Tag tag, std::uint32_t length) {
        put_little(bytes_, tag >> 16, 2);
        put_little(bytes_, tag & 0xffff, 2);
        put_little(bytes_, length, 4);
    }

    std::string bytes_;
};

/// A number as DICOM writes decimals, at most 16 characters: with `decimals` of them, or fewer where it must, and without
/// zeros at its end.
inline void put_decimal(std::string& out, double value, int decimals) {
    constexpr std::ptrdiff_t most = 16;
    std::array<char, 64> text{};
    for (;; --decimals) {
        char* end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals).ptr;
        if (decimals > 0) {
            while (end[-1] == '0') {
                --end;
            }
            end -= end[-1] == '.' ? 1 : 0;
        }
        if (end - text.data() <= most || decimals == 0) {
            const std::string_view all(text.data(), static_cast<std::size_t>(end - text.data()));
            out.append(all == "-0" ? "0" : all);
            return;
        }
    }
}

/// Who a structure set says that it is: UIDs by what it holds, and texts in one character set.
struct StructureSetIdentity {
    std::string instance_uid;
    std::string series_uid;
    std::string study_uid;
    std::string frame_of_reference_uid;
    std::string date;  ///< empty where none was asked for
    std::string time;
    std::string character_set;  ///< Specific Character Set, or nothing for ASCII
    std::string label;
    std::vector<std::string> roi_names;  ///< at most 64 characters; none repeats
};

/// Patient, study and frame of reference are the CT's where there is one, and so is the character set. Names are UTF-8:
/// where the CT has texts in another set, characters beyond ASCII become _. Throws Refused, Stopped, std::bad_alloc.
StructureSetIdentity identity_of(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
                                 const Context& context);

/// 2.25. and the UUID (version 8, RFC 9562) that the content's SHA-256 and the purpose give, in decimals: at most 44
/// characters.
std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose);

/// A text of the CT without control characters but those that switch character sets.
std::string plain_text(std::string text);

}  // namespace lamella
