#include "medical/dicom/header.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string_view>
#include <system_error>

#include <zlib.h>

#include <fast_float/fast_float.h>

#include "base/guard.hpp"
#include "medical/dicom/elements.hpp"

namespace lamella {

namespace {

constexpr std::size_t preamble_bytes = 132;
constexpr std::size_t first_window_bytes = std::size_t{1} << 16;
constexpr std::size_t largest_window_bytes = std::size_t{1} << 26;

constexpr std::string_view implicit_little_endian = "1.2.840.10008.1.2";
constexpr std::string_view explicit_big_endian = "1.2.840.10008.1.2.2";
constexpr std::string_view deflated_little_endian = "1.2.840.10008.1.2.1.99";

Error unreadable(const std::string& name, int error_number) {
    return {.code = ErrorCode::unreadable_file,
            .message = "cannot read '" + name + "': " + std::generic_category().message(error_number)};
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view padding("\0 ", 2);
    const std::size_t begin = text.find_first_not_of(padding);
    return begin == std::string_view::npos ? std::string_view()
                                           : text.substr(begin, text.find_last_not_of(padding) - begin + 1);
}

/// The first bytes of a file, more and more of them.
class Window {
public:
    explicit Window(const std::filesystem::path& path)
        : name_(path.string()), file_(std::fopen(path.c_str(), "rb"), &std::fclose) {
        if (!file_) {
            throw Refused{unreadable(name_, errno)};
        }
        grow(preamble_bytes);
    }

    std::string_view bytes() const noexcept { return bytes_; }
    bool whole() const noexcept { return whole_; }

    void grow(std::size_t size) {
        const std::size_t before = bytes_.size();
        bytes_.resize(size);
        const std::size_t count = std::fread(bytes_.data() + before, 1, size - before, file_.get());
        if (std::ferror(file_.get()) != 0) {
            throw Refused{unreadable(name_, errno)};
        }
        bytes_.resize(before + count);
        whole_ = bytes_.size() < size;
    }

private:
    std::string name_;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
    std::string bytes_;
    bool whole_ = false;
};

/// What `data`, which may be cut off, was deflated from. Throws Refused.
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
        throw Refused{header.refused("damaged deflated data within its header")};
    }
    return text;
}

/// Whether `bytes` reach beyond the header. Throws Refused.
bool parse(std::string_view bytes, DicomHeader& header) {
    DicomElements meta(bytes.substr(preamble_bytes), {.is_explicit = true}, preamble_bytes);
    if (meta.collect(dicom::last_of_file_meta, header) != DicomElements::End::passed) {
        return false;
    }
    const std::string syntax = header.text(dicom::transfer_syntax_uid);
    const std::size_t begin = preamble_bytes + meta.position();
    std::string_view data = bytes.substr(begin);
    std::string text;
    if (syntax == deflated_little_endian) {
        text = inflated(header, data);
        data = text;
    }
    DicomElements elements(
        data,
        {.is_explicit = !syntax.empty() && syntax != implicit_little_endian, .is_big_endian = syntax == explicit_big_endian},
        begin);
    return elements.collect(dicom::pixel_spacing, header) == DicomElements::End::passed ||
           header.text(dicom::sop_class_uid) == dicom::media_storage_directory;
}

}  // namespace

std::string DicomHeader::text(dicom::Tag tag) const {
    const auto found = values_.find(tag);
    return found == values_.end() ? std::string() : std::string(trimmed(found->second));
}

std::string DicomHeader::required_text(dicom::Tag tag, const char* keyword) const {
    std::string found = text(tag);
    if (found.empty()) {
        std::array<char, 16> number{};
        (void)std::snprintf(number.data(), number.size(), " (%04x,%04x)", tag >> 16, tag & 0xffffU);
        throw Refused{refused(std::string("its header states no ") + keyword + number.data())};
    }
    return found;
}

std::vector<double> DicomHeader::required_numbers(dicom::Tag tag, const char* keyword, std::size_t count) const {
    const std::string all = required_text(tag, keyword);
    std::vector<double> numbers;
    for (std::size_t begin = 0; begin <= all.size() && numbers.size() <= count;) {
        const std::size_t end = std::min(all.find('\\', begin), all.size());
        std::string_view word = trimmed(std::string_view(all).substr(begin, end - begin));
        word.remove_prefix(word.starts_with('+') ? 1 : 0);
        double value = 0;
        const auto [stop, problem] = fast_float::from_chars(word.data(), word.data() + word.size(), value);
        if (problem != std::errc() || stop != word.data() + word.size() || !std::isfinite(value)) {
            break;
        }
        numbers.push_back(value);
        begin = end + 1;
    }
    if (numbers.size() != count) {
        throw Refused{refused(std::string(keyword) + " is '" + one_line(all) + "', not " + std::to_string(count) +
                              (count == 1 ? " number" : " numbers"))};
    }
    return numbers;
}

Error DicomHeader::refused(const std::string& what) const {
    return {.code = ErrorCode::malformed_mesh, .message = file_ + ": " + what};
}

std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path) {
    Window window(path);
    if (window.bytes().size() < preamble_bytes || window.bytes().substr(128) != "DICM") {
        return std::nullopt;
    }
    for (std::size_t size = first_window_bytes; size <= largest_window_bytes; size *= 4) {
        window.grow(size);
        DicomHeader header(path.string());
        if (parse(window.bytes(), header)) {
            return header;
        }
        if (window.whole()) {
            throw Refused{header.refused("cut off within its DICOM header")};
        }
    }
    throw Refused{DicomHeader(path.string()).refused("its DICOM header is longer than 64 MiB")};
}

std::string one_line(const std::string& text) {
    constexpr std::size_t most = 64;
    std::string line = text.substr(0, most);
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
    return line;
}

}  // namespace lamella
