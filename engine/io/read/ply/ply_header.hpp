// The header of a PLY file: which elements follow it, how they are encoded, and which of them make up the mesh.
#pragma once

#include "io/read/number_type.hpp"
#include "io/read/stated.hpp"
#include "io/text/lines.hpp"

namespace lamella {

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };

/// The part of the mesh that a property becomes.
enum class PlyUse : std::uint8_t { x, y, z, indices, nothing };

struct PlyProperty {
    std::string_view name;
    NumberType type = NumberType::int8;
    bool is_list = false;
    NumberType count_type = NumberType::int8;  ///< of a list
    PlyUse use = PlyUse::nothing;
};

enum class PlyRole : std::uint8_t { vertices, faces, strips, nothing };

struct PlyElement {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
    PlyRole role = PlyRole::nothing;
    const char* at = nullptr;  ///< its line, for errors

    /// Bytes that each row takes at least: its fixed numbers and, of lists, the counts.
    std::uint64_t least_row_bytes(PlyEncoding encoding) const noexcept;
    /// True if all rows are of the same size in a binary file.
    bool has_lists() const noexcept;
    const PlyProperty& used(PlyUse use) const noexcept;  ///< Precondition: there is one.
};

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<PlyElement> elements;
    std::size_t body = 0;  ///< where the first element begins
    StatedFrame patient_frame;
    LeftOut skipped;  ///< lines that begin with no keyword

    /// One with a count above 0; null where there is none.
    const PlyElement* element_of(PlyRole role) const noexcept;
};

/// Reads the header at the beginning of `text`, which names refer into. Throws TextError.
PlyHeader parse_ply_header(std::string_view text);
/// Throws Refused where the header counts no faces, or no vertices.
void check_ply_header(const FileSource& file, const PlyHeader& header);

/// `contents` begin with the header.
void warn_of_skipped_lines(const FileSource& file, std::string_view contents, const PlyHeader& header,
                           std::vector<std::string>& warnings);

/// `bytes` after the last element, or none.
void warn_of_rest(const FileSource& file, std::uint64_t bytes, std::vector<std::string>& warnings);

}  // namespace lamella
