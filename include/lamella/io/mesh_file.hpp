// Mesh files: one call reads every format.
//
//     const lamella::Result<lamella::MeshFile> file = lamella::read_mesh("liver.stl");
//     if (!file) {
//         std::fprintf(stderr, "%s\n", file.error().message.c_str());
//         return;
//     }
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(*file);  // in mm, whatever the file's unit is
//
// The content of a file decides its format, then its name. Where the two disagree, the content decides and a warning says
// so.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/array.hpp"
#include "lamella/check.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/source.hpp"
#include "lamella/weld.hpp"

namespace lamella {

enum class MeshFormat : std::uint8_t { stl, obj, off, ply, vtk, vtp, three_mf, gltf, gifti, freesurfer };

/// "STL", ...
std::string_view name_of(MeshFormat format) noexcept;

/// Of all formats that can be read.
std::span<const std::string_view> format_names() noexcept;

/// Whether a file's name ends as those of one of these formats, as in "a.stl", "A.STL" and "a.stl.gz"; ".stl" alone is a
/// name without an end. read_mesh() reads files of any name.
bool is_named_as_mesh(const std::filesystem::path& path) noexcept;

/// The directions in which a medical mesh's axes run through the patient: towards left, posterior and superior (LPS), or
/// towards right, anterior and superior (RAS). Read where a file states it, and never guessed.
enum class PatientFrame : std::uint8_t { unstated, lps, ras };

/// "LPS", "RAS" or "".
std::string_view name_of(PatientFrame frame) noexcept;

// What a part of a file is for, by the file, is its role (source.hpp). Only solid parts are in the mesh; a warning names
// those left out, but for those that ReadOptions::all_roles keeps.

/// "solid", "negative volume", "modifier", "support blocker", "support enforcer" or "support".
std::string_view name_of(PartRole role) noexcept;

/// Part of a file: a 3MF object, or a volume that a slicer's settings make of its triangles; an OBJ object, or a group where
/// the file has at most one object; a solid of text STL; a node of glTF.
struct MeshPart {
    std::string name;  ///< the file's bytes, else "object 7" or "part 2"; names may repeat
    PartRole role = PartRole::solid;
    std::uint64_t first_triangle = 0;  ///< in the mesh, or after it where the part is not solid; 0 where it is left out
    std::uint64_t triangle_count = 0;  ///< those left out too
    std::uint32_t object = 0;          ///< that the part belongs to, where some part of the file takes away or labels
};

/// Names in the same order, of which none repeats: the second "rib" is "rib (2)". Each has at most `most_characters` of
/// UTF-8. O(bytes) expected. Throws std::bad_alloc.
std::vector<std::string> distinct_names(std::span<const std::string> names, std::size_t most_characters = SIZE_MAX);

/// Numbers that a file has at each vertex of a mesh: curvature, thickness, labels.
struct VertexScalars {
    std::string name;            ///< the file's bytes; none repeats
    std::size_t components = 1;  ///< numbers a vertex
    bool integers = false;       ///< the file has integers: labels, between which there is no mean
    Array<double> values{};      ///< of vertex 0, 1, ...; not finite where the file says so
};

/// A mesh read from a file, with its memory: triangle soup as it lies in the file, or vertices and indices.
struct MeshFile {
    Array<std::byte> bytes;        ///< what holds the coordinates; a binary STL file is kept as it is (no parse, no copy)
    std::size_t first_offset = 0;  ///< of the first triangle's (soup) or vertex's coordinates in `bytes`
    std::size_t stride = 0;        ///< bytes from one triangle (soup) or vertex to the next
    Number vertex_type = Number::f32;
    std::uint64_t vertex_count = 0;    ///< 0 for soup
    Array<std::uint32_t> indices;      ///< three a triangle; empty for soup
    std::uint64_t first_triangle = 0;  ///< of those that view() shows: with `triangle_count`, a part's for the part alone
    std::uint64_t triangle_count = 0;
    std::vector<MeshPart> parts;         ///< the solid ones come first and are the whole mesh; empty where none are stated
    std::vector<VertexScalars> scalars;  ///< by ReadOptions::scalars, in the file's order

    MeshFormat format = MeshFormat::stl;
    bool text = false;         ///< numbers were written out in decimals
    bool compressed = false;   ///< by gzip, as a whole
    double mm_per_unit = 1;    ///< of the coordinates: what the file states, else what the caller asked for
    bool states_unit = false;  ///< the file does, or its format, and the caller did not ask for another
    PatientFrame patient_frame = PatientFrame::unstated;
    std::vector<std::string> warnings;  ///< one line each, naming the file
    std::uint64_t file_bytes = 0;
    double read_ms = 0;   ///< getting the bytes
    double parse_ms = 0;  ///< making triangles of them, and decompression

    /// With the file's unit: what slice() and all other calls take.
    MeshView view() const noexcept {
        const std::byte* const first = bytes.data() + first_offset;
        const bool soup = indices.empty();
        return {.vertices = soup ? first + first_triangle * stride : first,
                .vertex_count = static_cast<std::size_t>(vertex_count),
                .triangle_count = static_cast<std::size_t>(triangle_count),
                .indices = soup ? nullptr : indices.data() + 3 * first_triangle,
                .vertex_stride = stride,
                .vertex_type = vertex_type,
                .mm_per_unit = mm_per_unit};
    }
};

/// All parts that have triangles in the file's memory, as a slicer takes them, by role and object; of a file that states
/// none the mesh. Negative ones and modifiers are there by ReadOptions::all_roles. Throws std::bad_alloc.
std::vector<Part> parts_of(const MeshFile& file);

struct ReadOptions {
    /// Map the file instead of reading it, which saves the copy. A file that shrinks while it is mapped ends the process:
    /// this is for programs that own their input.
    bool map_file = false;
    double mm_per_unit = 0;  ///< for files that state no unit, and glTF, whose unit is the metre; 0: mm, and metres of glTF
    /// What messages call a file whose path says nothing, as "/dev/fd/5" of a pipe's copy: its content alone then decides
    /// the format. Empty: its path.
    std::string_view name{};
    /// Triangles of negative volumes and modifiers of a 3MF file are kept too, after those of the mesh: see parts_of().
    bool all_roles = false;
    /// MeshFile::scalars are read: arrays of numbers at points of VTP and GIfTI, and properties of PLY vertices but lists.
    /// An array that has not a row for each vertex is left out, and a warning says where.
    bool scalars = false;
    /// What reading may take beside the file's own bytes; more is an error before it is allocated. 0: three times the file
    /// and 256 MiB, which only files that expand enormously exceed.
    std::uint64_t memory_limit_bytes = 0;
};

/// Reads `path`. O(bytes). It never allocates by a count that the file claims but does not hold. Errors: unreadable_file,
/// malformed_mesh (with the byte offset, and for text the line, in the message), empty_mesh, invalid_argument (negative
/// threads), out_of_memory, cancelled.
Result<MeshFile> read_mesh(const std::filesystem::path& path, const ReadOptions& options = {},
                           const Context& context = {}) noexcept;

}  // namespace lamella
