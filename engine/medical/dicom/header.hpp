// The header of a DICOM file, as far as the place of its image: up to PixelSpacing.
//
// Not by DCMTK, which overflows the stack on sequences nested deeply enough, logs by a logger of the whole process, and
// needs a dictionary that an environment variable finds. A header takes a file's first 64 KiB as a rule, and no recursion.
#pragma once

#include <cstdio>
#include <map>

#include "base/words.hpp"
#include "medical/dicom/tags.hpp"
#include "medical/geometry/headers.hpp"

namespace lamella {

/// Text of a file as part of a message: one line of limited length.
inline std::string one_line(const std::string& text) {
    constexpr std::size_t most = 64;
    std::string line = text.substr(0, most);
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
    return line;
}

class DicomHeader {
public:
    explicit DicomHeader(std::string file) : file_(std::move(file)) {}

    const std::string& file() const noexcept { return file_; }
    void set(dicom::Tag tag, std::string value) { values_[tag] = std::move(value); }

    bool has(dicom::Tag tag) const { return !text(tag).empty(); }
    /// Without the spaces around; empty where the attribute is absent or empty.
    std::string text(dicom::Tag tag) const {
        const auto found = values_.find(tag);
        return found == values_.end() ? std::string() : std::string(trimmed(found->second, std::string_view("\0 ", 2)));
    }

    /// The same, or throws Refused, which names the attribute by `keyword`.
    std::string required_text(dicom::Tag tag, const char* keyword) const {
        std::string found = text(tag);
        if (found.empty()) {
            std::array<char, 16> number{};
            (void)std::snprintf(number.data(), number.size(), " (%04x,%04x)", tag >> 16, tag & 0xffffU);
            refuse(std::string("its header states no ") + keyword + number.data());
        }
        return found;
    }

    /// Throws Refused unless the attribute has `count` finite numbers.
    std::vector<double> required_numbers(dicom::Tag tag, const char* keyword, std::size_t count) const {
        const std::string all = required_text(tag, keyword);
        std::optional<std::vector<double>> numbers = numbers_in(all, '\\');
        if (!numbers || numbers->size() != count) {
            refuse(std::string(keyword) + " is '" + one_line(all) + "', not " + counted(count, "number"));
        }
        return *std::move(numbers);
    }

    /// Throws Refused: malformed_mesh, "FILE: WHAT".
    [[noreturn]] void refuse(const std::string& what) const { refuse_image(file_, what); }

private:
    std::string file_;
    std::map<dicom::Tag, std::string> values_;  ///< as in the file, but numbers as text
};

/// Nothing where the file is no DICOM file: without "DICM" at byte 128. The transfer syntaxes of PS3.5: implicit and
/// explicit, of either byte order, deflated, and all that compress pixels only. Throws Refused (unreadable_file,
/// malformed_mesh) and std::bad_alloc.
std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path);

}  // namespace lamella
