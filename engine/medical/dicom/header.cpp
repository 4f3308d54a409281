// PS3.5, chapter 7: an element is its tag, in explicit syntaxes two letters for its type, the length of its value, the
// value. A sequence of undefined length ends with an element of its own, and so do its items.
#include "medical/dicom/header.hpp"

#include <memory>

#include <zlib.h>

#include "base/guard.hpp"
#include "io/read/input_file.hpp"

namespace lamella {

namespace {

constexpr std::size_t preamble_bytes = 132;
constexpr std::size_t first_window_bytes = std::size_t{1} << 16;
constexpr std::size_t largest_window_bytes = std::size_t{1} << 26;
constexpr std::uint32_t undefined_length = 0xffffffff;

constexpr std::string_view implicit_little_endian = "1.2.840.10008.1.2";
constexpr std::string_view explicit_big_endian = "1.2.840.10008.1.2.2";
constexpr std::string_view deflated_little_endian = "1.2.840.10008.1.2.1.99";

/// Longer ones are no texts or numbers that are used.
constexpr std::uint32_t longest_value = 4096;

/// Types whose length takes four bytes, after two that mean nothing.
constexpr std::string_view long_types = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";

std::string first_bytes(const std::filesystem::path& path, std::size_t size) {
    const InputFile file = require(InputFile::open(path));
    std::string bytes(std::min<std::uint64_t>(size, file.size()), '\0');
    require(file.read_at(0, std::as_writable_bytes(std::span(bytes))));
    return bytes;
}

/// Inflates `data`, which may be cut off. Throws Refused.
std::string inflated(const DicomHeader& header, std::string_view data) {
    z_stream stream{};
    constexpr int raw_window = -15;
    if (::inflateInit2(&stream, raw_window) != Z_OK) {
        throw std::bad_alloc();
    }
    const std::unique_ptr<z_stream, int (*)(z_streamp)> ended(&stream, &::inflateEnd);
    // zlib's type is not const, but it does not write there.
    stream.next_in =
        reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    stream.avail_in = static_cast<uInt>(data.size());
    std::string text;
    int answer = Z_OK;
    while (answer == Z_OK && text.size() < largest_window_bytes) {
        const std::size_t before = text.size();
        text.resize(before + first_window_bytes);
        stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
        stream.avail_out = static_cast<uInt>(first_window_bytes);
        answer = ::inflate(&stream, Z_SYNC_FLUSH);
        text.resize(text.size() - stream.avail_out);
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

/// An element up to its value.
struct Element {
    dicom::Tag tag = 0;
    std::uint32_t length = 0;
    std::size_t value = 0;    ///< where it begins
    bool is_unknown = false;  ///< of type UN: within, all is implicit and little-endian
};

/// The elements of a data set, one after the other.
class Elements {
public:
    /// Puts what is wanted into `header`. `file_offset`: of the first byte, for messages.
    Elements(std::string_view bytes, Encoding encoding, std::size_t file_offset, DicomHeader& header)
        : bytes_(bytes), encoding_(encoding), file_offset_(file_offset), header_(header) {}

    /// Up to `last`: where one follows that lies beyond; nothing where the bytes end before. Throws Refused where there is
    /// no element. Without recursion: sequences may be nested as deeply as a file is long.
    std::optional<std::size_t> collect(dicom::Tag last) const {
        std::size_t open = 0;           // sequences and items without an end so far
        std::size_t implicit_from = 0;  // how many were open where what is unknown began
        for (std::size_t at = 0; bytes_.size() - at >= 4;) {
            if (open == 0 && tag_at(at, encoding_.is_big_endian) > last) {
                return at;
            }
            const std::optional<Element> element = element_at(at, implicit_from != 0 ? Encoding{} : encoding_);
            if (!element) {
                break;
            }
            at = element->value;
            if (open > 0 && (element->tag == dicom::item_end || element->tag == dicom::sequence_end)) {
                --open;
                implicit_from = open < implicit_from ? 0 : implicit_from;
            } else if (element->length == undefined_length) {
                ++open;
                implicit_from = implicit_from == 0 && element->is_unknown ? open : implicit_from;
            } else if (element->length > bytes_.size() - at) {
                break;
            } else {
                if (open == 0 && element->length <= longest_value) {
                    keep(*element);
                }
                at += element->length;
            }
        }
        return std::nullopt;
    }

private:
    std::uint32_t number(std::size_t at, std::size_t bytes, bool big_endian) const noexcept {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < bytes; ++i) {
            value = value << 8 | static_cast<unsigned char>(bytes_[big_endian ? at + i : at + bytes - 1 - i]);
        }
        return value;
    }

    dicom::Tag tag_at(std::size_t at, bool big_endian) const noexcept {
        return number(at, 2, big_endian) << 16 | number(at + 2, 2, big_endian);
    }

    void keep(const Element& element) const {
        if (element.tag != dicom::rows && element.tag != dicom::columns) {
            header_.set(element.tag, std::string(bytes_.substr(element.value, element.length)));
        } else if (element.length == 2 || element.length == 4) {
            header_.set(element.tag, std::to_string(number(element.value, element.length, encoding_.is_big_endian)));
        }
    }

    /// Nothing where the bytes end before its value.
    std::optional<Element> element_at(std::size_t at, Encoding encoding) const {
        const bool big = encoding.is_big_endian;
        if (bytes_.size() - at < 8) {
            return std::nullopt;
        }
        Element element{tag_at(at, big), number(at + 4, 4, big), at + 8, false};
        if (!encoding.is_explicit || element.tag >> 16 == 0xfffe) {
            return element;
        }
        const std::string_view type = bytes_.substr(at + 4, 2);
        if (!std::all_of(type.begin(), type.end(), [](char c) { return c >= 'A' && c <= 'Z'; })) {
            header_.refuse("no DICOM element at byte " + std::to_string(file_offset_ + at));
        }
        if (long_types.find(type) == std::string_view::npos) {
            element.length = number(at + 6, 2, big);
            return element;
        }
        if (bytes_.size() - at < 12) {
            return std::nullopt;
        }
        return Element{element.tag, number(at + 8, 4, big), at + 12, type == "UN"};
    }

    std::string_view bytes_;
    Encoding encoding_;
    std::size_t file_offset_;
    DicomHeader& header_;
};

/// Returns whether `bytes` reach beyond the header. Throws Refused.
bool parse(std::string_view bytes, DicomHeader& header) {
    const std::optional<std::size_t> meta_bytes =
        Elements(bytes.substr(preamble_bytes), {.is_explicit = true}, preamble_bytes, header)
            .collect(dicom::last_of_file_meta);
    if (!meta_bytes) {
        return false;
    }
    const std::string syntax = header.text(dicom::transfer_syntax_uid);
    const std::size_t begin = preamble_bytes + *meta_bytes;
    std::string_view data = bytes.substr(begin);
    std::string text;
    if (syntax == deflated_little_endian) {
        text = inflated(header, data);
        data = text;
    }
    const bool is_explicit = !syntax.empty() && syntax != implicit_little_endian;
    return Elements(data, {is_explicit, syntax == explicit_big_endian}, begin, header).collect(dicom::pixel_spacing) ||
           header.text(dicom::sop_class_uid) == dicom::media_storage_directory;
}

}  // namespace

std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path) {
    for (const std::size_t size : {first_window_bytes, largest_window_bytes}) {
        const std::string bytes = first_bytes(path, size);
        if (bytes.size() < preamble_bytes || bytes.compare(preamble_bytes - 4, 4, "DICM") != 0) {
            return std::nullopt;
        }
        DicomHeader header(path.string());
        if (parse(bytes, header)) {
            return header;
        }
        if (bytes.size() < size) {
            header.refuse("cut off within its DICOM header");
        }
    }
    DicomHeader(path.string()).refuse("its DICOM header is longer than 64 MiB");
}

}  // namespace lamella
