// A PLY file: its header says which elements follow it, how they are encoded, and which of them make up the mesh.
#pragma once

#include "io/read/faces.hpp"
#include "io/read/number_type.hpp"
#include "io/read/stated.hpp"

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

// --- The body

struct PlyInput {
    const FileSource& source;
    std::string_view file;  ///< with the header
    const PlyHeader& header;

    const Parallel& parallel() const noexcept { return source.parallel(); }
    bool swapped() const noexcept { return header.encoding == PlyEncoding::big_endian; }
};

/// Facts of a body beside the mesh.
struct PlyBody {
    bool swapped = false;           ///< the file's byte order is not the machine's, and the coordinates are still the file's
    std::uint64_t small_faces = 0;  ///< left out: of fewer than three vertices
    LeftOut long_rows;              ///< lines with more words than their row takes, which are ignored
    std::size_t end = 0;            ///< of the last element in the file
};

/// Doubles and integers of 32 bits are kept as doubles.
Number number_for(const PlyElement& vertices) noexcept;

/// ASCII PLY as nearly everyone writes it, one row a line, parsed in parallel. Lines may have more words than the header
/// declares, which are ignored and counted. False: rows are no lines, or something is wrong, which a reader that goes from
/// number to number will find. Whether it succeeds, and what it makes, does not depend on threads.
bool read_ply_lines(const PlyInput& input, MeshFile& mesh, PlyBody& body);

// Binary rows of one size, which are copied without parsing: ply_binary.cpp.

/// Where the vertices begin in the file, if their coordinates can be used where they lie, swapped or not.
std::optional<std::size_t> vertices_in_place(const PlyElement& vertices, std::size_t offset);

/// Reverses the bytes of all coordinates in place.
void swap_vertices(MeshFile& mesh, const Parallel& parallel);

/// Copies the coordinates of vertices without lists, which begin at `rows`, into those of `mesh`.
void copy_vertices(const PlyInput& input, const PlyElement& vertices, const char* rows, MeshFile& mesh);

/// The same for `count` rows, to packed coordinates at `to`.
void copy_vertex_rows(const PlyElement& vertices, bool swapped, const char* rows, std::size_t count, Number number,
                      std::byte* to);

/// Bytes of a row that is a triangle; nothing if such rows may differ in size, or indices are no whole numbers.
std::optional<std::size_t> triangle_row_bytes(const PlyElement& faces);

/// Copies the indices of `count` such rows. False: a row has not three, or one that is not below `vertex_count`, which is
/// at most most_ply_vertices.
bool copy_triangle_rows(const PlyElement& faces, bool swapped, const char* rows, std::size_t count,
                        std::uint64_t vertex_count, std::uint32_t* to);

/// Beyond, what is negative could be a vertex.
inline constexpr std::uint64_t most_ply_vertices = std::uint64_t{1} << 31;

/// Where the row's property of this use begins, if all lists before it are empty.
std::size_t offset_in_row(const PlyElement& element, PlyUse use);

/// Copies the indices of the faces at `rows` to `indices`, if every one is a triangle: rows of one size, whose only list has
/// three whole numbers. False: there are other rows, an index that is no vertex, or memory does not suffice.
bool copy_triangle_rows(const PlyInput& input, const PlyElement& faces, const char* rows, MemoryBudget& budget,
                        Array<std::uint32_t>& indices);

}  // namespace lamella
