// Headers are read as far as the place of the image: up to PixelSpacing, or the functional groups of several frames.
//
// Not by DCMTK, which overflows the stack on sequences nested deeply enough, logs by a logger of the whole process, and
// needs a dictionary that an environment variable finds. A header takes a file's first 64 KiB as a rule, and no recursion.
#include "medical/dicom/header.hpp"

#include <span>

#include "base/guard.hpp"
#include "io/read/inflater.hpp"
#include "io/read/input_file.hpp"

namespace lamella {

namespace {

constexpr std::size_t preamble_bytes = 132;
constexpr std::size_t first_window_bytes = std::size_t{1} << 16;
constexpr std::size_t largest_window_bytes = std::size_t{1} << 26;

/// Inflates `data`, which may be cut off. Throws Refused.
std::string inflated(const DicomHeader& header, std::string_view data) {
    constexpr int raw_window = -15;
    Inflater inflater(raw_window);
    std::span<const std::byte> packed = std::as_bytes(std::span(data));
    std::string text;
    int answer = Z_OK;
    while (answer == Z_OK && text.size() < largest_window_bytes) {
        const std::size_t before = text.size();
        text.resize(before + first_window_bytes);
        std::span<std::byte> room = std::as_writable_bytes(std::span(text)).subspan(before);
        answer = inflater.step(packed, room);
        text.resize(text.size() - room.size());
    }
    if (answer != Z_OK && answer != Z_STREAM_END && answer != Z_BUF_ERROR) {
        header.refuse("damaged deflated data within its header");
    }
    return text;
}

struct Encoding {
    bool is_explicit = false;  ///< each element names the type of its value
    bool is_big_endian = false;
};

std::uint32_t number_at(std::string_view bytes, std::size_t at, std::size_t count, bool big_endian) noexcept {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i) {
        value = value << 8 | static_cast<unsigned char>(bytes[big_endian ? at + i : at + count - 1 - i]);
    }
    return value;
}

dicom::Tag tag_at(std::string_view bytes, std::size_t at, bool big_endian) noexcept {
    return number_at(bytes, at, 2, big_endian) << 16 | number_at(bytes, at + 2, 2, big_endian);
}

/// An element of a data set up to its value: its tag, in explicit syntaxes two letters for its type, the length of its value
/// (PS3.5, chapter 7).
struct Element {
    dicom::Tag tag = 0;
    std::uint32_t length = 0;
    std::size_t value = 0;    ///< where it begins
    bool is_unknown = false;  ///< of type UN: within, all is implicit and little-endian
};

/// Elements one after the other: a data set, or what a sequence or an item holds.
struct Elements {
    std::string_view bytes;
    Encoding encoding{};
    std::size_t file_offset = 0;  ///< of the first byte

    Elements part(std::size_t at, std::size_t length, Encoding of_part) const {
        return {bytes.substr(at, length), of_part, file_offset + at};
    }
};

/// Nothing where the bytes end before its value. Throws Refused where there is no element.
std::optional<Element> element_at(const Elements& in, std::size_t at, Encoding encoding, const DicomHeader& header) {
    // Types whose length takes four bytes, after two that mean nothing.
    static constexpr std::string_view long_types = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
    const std::string_view bytes = in.bytes;
    const bool big = encoding.is_big_endian;
    if (bytes.size() - at < 8) {
        return std::nullopt;
    }
    const dicom::Tag tag = tag_at(bytes, at, big);
    if (!encoding.is_explicit || tag >> 16 == 0xfffe) {
        return Element{tag, number_at(bytes, at + 4, 4, big), at + 8};
    }
    const std::string_view type = bytes.substr(at + 4, 2);
    if (!std::all_of(type.begin(), type.end(), [](char c) { return c >= 'A' && c <= 'Z'; })) {
        header.refuse("no DICOM element at byte " + std::to_string(in.file_offset + at));
    }
    if (long_types.find(type) == std::string_view::npos) {
        return Element{tag, number_at(bytes, at + 6, 2, big), at + 8};
    }
    return bytes.size() - at < 12 ? std::nullopt
                                  : std::optional(Element{tag, number_at(bytes, at + 8, 4, big), at + 12, type == "UN"});
}

/// An element with its value: the elements in it, where it is a sequence or an item.
struct Value {
    dicom::Tag tag = 0;
    Elements inside;
};

/// The element at `at`, which moves after it; nothing where the bytes end before. Throws Refused. A sequence of undefined
/// length ends with an element of its own, and so do its items. Without recursion: sequences may be nested as deeply as a
/// file is long.
std::optional<Value> next_value(const Elements& in, std::size_t& at, const DicomHeader& header) {
    constexpr std::uint32_t undefined_length = 0xffffffff;
    const std::optional<Element> head = element_at(in, at, in.encoding, header);
    if (!head) {
        return std::nullopt;
    }
    const auto value_until = [&](std::size_t end) {
        return Value{head->tag, in.part(head->value, end - head->value, head->is_unknown ? Encoding{} : in.encoding)};
    };
    at = head->value;
    if (head->length != undefined_length) {
        if (head->length > in.bytes.size() - at) {
            return std::nullopt;
        }
        at += head->length;
        return value_until(at);
    }
    std::size_t open = 1;                                  // sequences and items without an end so far
    std::size_t implicit_from = head->is_unknown ? 1 : 0;  // how many were open where what is unknown began
    for (;;) {
        const std::size_t begin = at;
        const std::optional<Element> element = element_at(in, at, implicit_from != 0 ? Encoding{} : in.encoding, header);
        if (!element) {
            return std::nullopt;
        }
        const auto [tag, length, value, is_unknown] = *element;
        at = value;
        if (tag == dicom::item_end || tag == dicom::sequence_end) {
            if (--open == 0) {
                return value_until(begin);
            }
            implicit_from = open < implicit_from ? 0 : implicit_from;
        } else if (length == undefined_length) {
            ++open;
            implicit_from = implicit_from == 0 && is_unknown ? open : implicit_from;
        } else if (length > in.bytes.size() - at) {
            return std::nullopt;
        } else {
            at += length;
        }
    }
}

/// Calls take(value) for each element up to `last`. Returns where one follows that lies beyond; nothing where the bytes end
/// before. Throws Refused.
template <class Take>
std::optional<std::size_t> for_each_value(const Elements& in, dicom::Tag last, const DicomHeader& header, Take take) {
    for (std::size_t at = 0; in.bytes.size() - at >= 4;) {
        if (tag_at(in.bytes, at, in.encoding.is_big_endian) > last) {
            return at;
        }
        const std::optional<Value> value = next_value(in, at, header);
        if (!value) {
            break;
        }
        take(*value);
    }
    return std::nullopt;
}

/// Where it is a text or a number that may be used.
void keep(const Value& value, DicomHeader::Values& values) {
    constexpr std::size_t longest_value = 4096;
    const std::string_view bytes = value.inside.bytes;
    if (value.tag != dicom::rows && value.tag != dicom::columns) {
        if (bytes.size() <= longest_value) {
            values[value.tag] = bytes;
        }
    } else if (bytes.size() == 2) {
        values[value.tag] = std::to_string(number_at(bytes, 0, 2, value.inside.encoding.is_big_endian));
    }
}

/// What the functional groups (PS3.3, C.7.6.16) in an item say of the place of a frame, or of all.
void keep_groups(const Elements& groups, const DicomHeader& header, DicomHeader::Values& values) {
    constexpr dicom::Tag all = 0xffffffff;
    static constexpr std::array<dicom::Tag, 7> wanted = {
        dicom::plane_position, dicom::image_position_patient, dicom::plane_orientation, dicom::image_orientation_patient,
        dicom::pixel_measures, dicom::pixel_spacing,          dicom::slice_thickness};
    const auto is_wanted = [](const Value& value) {
        return std::find(wanted.begin(), wanted.end(), value.tag) != wanted.end();
    };
    for_each_value(groups, all, header, [&](const Value& group) {
        const Elements items = is_wanted(group) ? group.inside : Elements{};
        for_each_value(items, all, header, [&](const Value& item) {
            for_each_value(item.inside, all, header, [&](const Value& value) {
                if (is_wanted(value)) {
                    keep(value, values);
                }
            });
        });
    });
}

/// Returns whether `bytes` reach beyond the header. Throws Refused.
bool parse(std::string_view bytes, DicomHeader& header) {
    const auto keep_in_header = [&](const Value& value) { keep(value, header.values); };
    const std::optional<std::size_t> meta_bytes =
        for_each_value({bytes.substr(preamble_bytes), {.is_explicit = true}, preamble_bytes}, dicom::last_of_file_meta,
                       header, keep_in_header);
    if (!meta_bytes) {
        return false;
    }
    const std::string syntax = header.text(dicom::transfer_syntax_uid);
    const std::size_t begin = preamble_bytes + *meta_bytes;
    const bool is_deflated = syntax == "1.2.840.10008.1.2.1.99";
    const std::string text = is_deflated ? inflated(header, bytes.substr(begin)) : std::string();
    const Encoding encoding{.is_explicit = !syntax.empty() && syntax != dicom::implicit_little_endian,
                            .is_big_endian = syntax == "1.2.840.10008.1.2.2"};
    const Elements all{is_deflated ? text : bytes.substr(begin), encoding, begin};
    const std::optional<std::size_t> end = for_each_value(all, dicom::pixel_spacing, header, keep_in_header);
    if (end && header.has_several_frames()) {
        constexpr std::size_t most_frames = 65535;
        const auto keep_frames = [&](const Value& value) {
            const bool shared = value.tag == dicom::shared_groups;
            const Elements items = shared || value.tag == dicom::per_frame_groups ? value.inside : Elements{};
            for_each_value(items, dicom::item, header, [&](const Value& item) {
                if (header.frames.size() == most_frames) {
                    header.refuse("more than " + std::to_string(most_frames) + " frames");
                }
                keep_groups(item.inside, header, shared ? header.shared : header.frames.emplace_back());
            });
        };
        return for_each_value(all.part(*end, all.bytes.size(), encoding), dicom::per_frame_groups, header, keep_frames)
            .has_value();
    }
    return end || header.text(dicom::sop_class_uid) == dicom::media_storage_directory;
}

}  // namespace

std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path) {
    const InputFile file = require(InputFile::open(path));
    for (std::size_t size = first_window_bytes; size <= largest_window_bytes; size *= 32) {
        std::string bytes(std::min<std::uint64_t>(size, file.size()), '\0');
        require(file.read_at(0, std::as_writable_bytes(std::span(bytes))));
        if (bytes.size() < preamble_bytes || bytes.compare(preamble_bytes - 4, 4, "DICM") != 0) {
            return std::nullopt;
        }
        DicomHeader header{path_text(path)};
        if (parse(bytes, header)) {
            return header;
        }
        if (bytes.size() < size) {
            header.refuse("cut off within its DICOM header");
        }
    }
    refuse_image(path_text(path), "its DICOM header is longer than 64 MiB");
}

}  // namespace lamella
