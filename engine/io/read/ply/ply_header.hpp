// The header of a PLY file: which elements follow it, how they are encoded, and which of them make up the mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/number_type.hpp"
#include "io/read/stated_frame.hpp"
#include "io/text/lines.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };

/// What of a property goes into the mesh.
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
    /// Whether all rows are of the same size in a binary file.
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

/// In quotes, for messages.
std::string short_name(std::string_view name);

bool begins_as_ply(std::string_view text) noexcept;

/// Reads the header at the beginning of `text`, which names refer into. Throws TextError.
PlyHeader parse_ply_header(std::string_view text);

/// `contents` begin with the header.
void warn_of_skipped_lines(const FileSource& file, std::string_view contents, const PlyHeader& header,
                           std::vector<std::string>& warnings);

/// `bytes` after the last element, or none.
void warn_of_rest(const FileSource& file, std::uint64_t bytes, std::vector<std::string>& warnings);

}  // namespace lamella
