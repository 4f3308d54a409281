// A PLY file: its header says which elements follow it, how they are encoded, and which of them make up the mesh.
#pragma once

#include "io/read/faces.hpp"
#include "io/read/number_type.hpp"
#include "io/read/stated.hpp"

namespace lamella {

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };

/// The part of the mesh that a property becomes.
enum class PlyUse : std::uint8_t { x, y, z, indices, scalar, nothing };

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

    /// Bytes of a binary row, or of what comes before the property of that use, if all lists are empty.
    std::size_t row_bytes(std::optional<PlyUse> before = std::nullopt) const noexcept;
    /// True if rows of a binary file may differ in size.
    bool has_lists() const noexcept;
    const PlyProperty& used(PlyUse use) const noexcept;  ///< Precondition: there is one.
};

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<PlyElement> elements;
    std::size_t body = 0;  ///< where the first element begins
    StatedFrame patient_frame;
    LeftOut skipped;  ///< lines that begin with no keyword

    bool swapped() const noexcept { return encoding == PlyEncoding::big_endian; }
    /// One with a count above 0; null where there is none.
    const PlyElement* element_of(PlyRole role) const noexcept;
    /// Says that `left` bytes cannot hold the element's rows, even at their smallest; empty if they can.
    std::string why_too_many(const PlyElement& element, std::uint64_t left) const;
    /// Warns of lines that were skipped, and gives the patient frame.
    void describe(const FileSource& file, std::string_view contents, MeshFile& mesh) const;
};

/// Warns of bytes after the last element.
void warn_of_rest(const FileSource& file, std::uint64_t bytes, MeshFile& mesh);

/// Reads the header at the beginning of `text`, which names refer into. Throws TextError, and Refused where it counts no
/// faces, or no vertices.
PlyHeader parse_ply_header(const FileSource& file, std::string_view text);

/// Doubles and integers of 32 bits are kept as doubles.
Number number_for(const PlyElement& vertices) noexcept;

// --- Binary rows of one size, which are copied without parsing: ply_binary.cpp.

/// Copies the coordinates of `count` vertices, `stride` bytes apart, to `to`, `to_stride` apart; may be where they are.
void copy_coordinates(Number number, bool swapped, const void* from, std::size_t stride, std::size_t count, std::byte* to,
                      std::size_t to_stride);

/// True if the coordinates of each row lie side by side, as numbers of the type that they are kept in.
bool has_packed_coordinates(const PlyElement& vertices);

/// Bytes of a row that is a triangle; 0 if such rows may differ in size, or indices are no whole numbers.
std::size_t triangle_row_bytes(const PlyElement& faces);

/// Beyond, what is negative could be a vertex.
inline constexpr std::uint64_t most_ply_vertices = std::uint64_t{1} << 31;

/// Copies the indices of `count` such rows. False: a row has not three, or one that is not below `vertex_count`, which is
/// at most most_ply_vertices.
bool copy_triangle_rows(const PlyElement& faces, bool swapped, const char* rows, std::size_t count,
                        std::uint64_t vertex_count, std::uint32_t* to);

}  // namespace lamella
