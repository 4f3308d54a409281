// What the header of a DICOM file says.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/words.hpp"
#include "io/text/text.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

/// Text of a file as part of a message: one line of limited length.
inline std::string one_line(const std::string& text) {
    return printable(std::string_view(text).substr(0, 64));
}

/// Of a file of several frames a frame is asked for by its number, from 1 on: what the functional groups say of it. 0 is the
/// file itself, outside of them.
struct DicomHeader {
    using Values = std::map<dicom::Tag, std::string>;  ///< as in the file, but numbers as text

    std::string file;
    Values values{};
    Values shared{};  ///< of all frames
    std::vector<Values> frames{};

    /// Throws Refused: malformed_mesh, "FILE: WHAT".
    [[noreturn]] void refuse(const std::string& what, std::size_t frame = 0) const {
        refuse_image(file, (frame == 0 ? "" : "frame " + std::to_string(frame) + ": ") + what);
    }

    bool has_several_frames() const {
        const std::string count = text(dicom::number_of_frames);
        return !count.empty() && (count != "1" || text(dicom::image_position_patient).empty());
    }

    /// Without the spaces around; empty where the attribute is absent or empty.
    std::string text(dicom::Tag tag, std::size_t frame = 0) const {
        const Values* from = frame == 0 ? &values : &frames[frame - 1];
        auto found = from->find(tag);
        if (found == from->end() && frame != 0) {
            from = &shared;
            found = from->find(tag);
        }
        return found == from->end() ? std::string() : std::string(trimmed(found->second, std::string_view("\0 ", 2)));
    }

    /// The same, or throws Refused, which names the attribute by `keyword`.
    std::string required_text(dicom::Tag tag, const char* keyword, std::size_t frame = 0) const {
        std::string found = text(tag, frame);
        if (found.empty()) {
            refuse(std::string("its header states no ") + keyword + " (" + hex_text(tag >> 16, 4) + "," + hex_text(tag, 4) +
                       ")",
                   frame);
        }
        return found;
    }

    /// Throws Refused unless the attribute has as many finite numbers.
    template <std::size_t count>
    std::array<double, count> numbers(dicom::Tag tag, const char* keyword, std::size_t frame = 0) const {
        const std::string all = required_text(tag, keyword, frame);
        const std::optional<std::vector<double>> found = parse_numbers(all, '\\');
        if (!found || found->size() != count) {
            refuse(std::string(keyword) + " is '" + one_line(all) + "', not " + counted(count, "number"), frame);
        }
        std::array<double, count> numbers{};
        std::copy(found->begin(), found->end(), numbers.begin());
        return numbers;
    }

    std::uint64_t side(dicom::Tag tag, const char* keyword) const {
        const double count = numbers<1>(tag, keyword)[0];
        if (!(count >= 1 && count <= 65535)) {
            refuse(std::string(keyword) + " is " + exact_text(count));
        }
        return static_cast<std::uint64_t>(count);
    }
};

/// Nothing where the file is no DICOM file: without "DICM" at byte 128. The transfer syntaxes of PS3.5: implicit and
/// explicit, of either byte order, deflated, and all that compress pixels only. Throws Refused (unreadable_file,
/// malformed_mesh) and std::bad_alloc.
std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path);

}  // namespace lamella
