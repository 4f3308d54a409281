// The header of a PLY file: which elements follow it, how they are encoded, and which of them make up the mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/stated_frame.hpp"
#include "io/text/lines.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr std::size_t size_of(PlyType type) noexcept {
    constexpr std::array<std::size_t, 8> sizes = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

/// What of a property goes into the mesh.
enum class PlyUse : std::uint8_t { x, y, z, indices, nothing };

struct PlyProperty {
    std::string_view name;
    PlyType type = PlyType::int8;
    bool is_list = false;
    PlyType count_type = PlyType::int8;  ///< of a list
    PlyUse use = PlyUse::nothing;
};

enum class PlyRole : std::uint8_t { vertices, faces, strips, nothing };

struct PlyElement {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
    PlyRole role = PlyRole::nothing;
    std::size_t offset = 0;  ///< of its line, for messages

    /// Bytes that each row takes at least: its fixed numbers and, of lists, the counts.
    std::uint64_t least_row_bytes(PlyEncoding encoding) const noexcept;
    /// Whether all rows are of the same size in a binary file.
    bool has_lists() const noexcept;
    const PlyProperty& used(PlyUse use) const noexcept;  ///< Precondition: there is one.
};

/// What is wrong with the file, and at which byte of it.
struct PlyProblem {
    std::size_t offset = 0;
    std::string what;
    ErrorCode code = ErrorCode::malformed_mesh;
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

/// Reads the header at the beginning of `text`, which names refer into. False: `problem` tells why.
bool parse_ply_header(std::string_view text, PlyHeader& header, PlyProblem& problem);

}  // namespace lamella
