// The header of a DICOM file, as far as the place of its image: up to PixelSpacing.
//
// Not by DCMTK, which overflows the stack on sequences nested deeply enough, logs by a logger of the whole process, and
// needs a dictionary that an environment variable finds. A header takes a file's first 64 KiB as a rule, and no recursion.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lamella/error.hpp"
#include "medical/dicom/tags.hpp"

namespace lamella {

class DicomHeader {
public:
    explicit DicomHeader(std::string file) : file_(std::move(file)) {}

    const std::string& file() const noexcept { return file_; }
    void set(dicom::Tag tag, std::string value) { values_[tag] = std::move(value); }

    bool has(dicom::Tag tag) const { return !text(tag).empty(); }
    /// Without the spaces around; empty where the attribute is absent or empty.
    std::string text(dicom::Tag tag) const;
    /// The same, or throws Refused, which names the attribute by `keyword`.
    std::string required_text(dicom::Tag tag, const char* keyword) const;
    /// Throws Refused unless the attribute has `count` finite numbers.
    std::vector<double> required_numbers(dicom::Tag tag, const char* keyword, std::size_t count) const;

    /// malformed_mesh: "FILE: WHAT".
    Error refused(const std::string& what) const;

private:
    std::string file_;
    std::map<dicom::Tag, std::string> values_;  ///< as in the file, but numbers as text
};

/// Nothing where the file is no DICOM file: without "DICM" at byte 128. The transfer syntaxes of PS3.5: implicit and
/// explicit, of either byte order, deflated, and all that compress pixels only. Throws Refused (unreadable_file,
/// malformed_mesh) and std::bad_alloc.
std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path);

/// Text of a file as part of a message: one line of limited length.
std::string one_line(const std::string& text);

}  // namespace lamella
