// Faces of any number of corners, which become triangles, for all readers.
#pragma once

#include <limits>
#include <vector>

#include "base/function_ref.hpp"
#include "io/read/chunk_list.hpp"
#include "io/read/polygon.hpp"
#include "io/read/reader.hpp"
#include "io/text/text.hpp"

namespace lamella {

/// No vertex: readers take fewer vertices than this.
inline constexpr std::uint32_t polygon_mark = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint32_t quad_mark = polygon_mark - 1;
inline constexpr std::size_t most_vertices = quad_mark;

/// The triangles of the faces of one piece of a file, in their order. Where vertices are not known yet, a face of n corners
/// takes the room of the 3 (n - 2) indices of its triangles, so that cut() can put these in its place:
///
///     a triangle   | a | b | c |
///     a quad       | quad mark | place | a | b | c | d |
///     n corners    | mark | place | n | a | b | c | d | e | ...
class FaceList {
public:
    /// `vertices` have their coordinates before the first face is added, or are none: not known yet. What the list holds is
    /// counted in `budget`.
    FaceList(MemoryBudget& budget, const VertexCoordinates& vertices, const Memory* memory)
        : budget_(&budget), vertices_(vertices), indices_(memory) {}

    /// Adds a face, which is left out if it has fewer than three corners. Throws Refused, and a TextError at `place` if the
    /// face cannot be cut into triangles.
    void add(std::span<const std::uint32_t> corners, const char* place, bool has_lines = true) {
        if (corners.size() == 3) {  // nearly all faces
            std::memcpy(room().data(), corners.data(), corners.size_bytes());
            indices_.add(3);
        } else if (corners.size() > 3) {
            add_polygon(corners, place, has_lines);
        } else {
            small_.add(place);
        }
    }
    /// Releases what only add() needs.
    void close();

    std::size_t triangles() const noexcept { return indices_.size() / 3; }
    /// Faces that were left out.
    const LeftOut& small() const noexcept { return small_; }

    /// Taken from the budget.
    std::uint64_t bytes() const noexcept { return bytes_; }
    /// Moves all to `to`.
    void move_to(std::uint32_t* to) { indices_.move_to(to); }
    /// Cuts what add() could not, of the list's `indices` after move_to(). Throws as add().
    void cut(std::span<std::uint32_t> indices, const VertexCoordinates& vertices);

private:
    static constexpr std::size_t smallest = 3 << 6;
    static constexpr std::size_t largest = 3 << 10;  // little is left unused of what the budget counts

    void add_polygon(std::span<const std::uint32_t> corners, const char* place, bool has_lines);
    void add_uncut(std::span<const std::uint32_t> corners, const char* place);
    void put(std::span<const std::uint32_t> values);
    void triangulate(std::span<const std::uint32_t> corners, const char* place, bool has_lines, std::uint32_t* out);
    void take_scratch(std::uint64_t bytes);
    std::span<std::uint32_t> room() {
        if (const std::size_t bytes = indices_.next_bytes(); bytes > 0) {
            budget_->take(bytes, 1);
            bytes_ += bytes;
        }
        return indices_.room();
    }

    MemoryBudget* budget_;
    VertexCoordinates vertices_;
    ChunkList<std::uint32_t, smallest, largest> indices_;  // chunks of whole triangles
    std::uint64_t bytes_ = 0;                              // taken from the budget
    PolygonTriangulator triangulator_;
    std::vector<std::uint32_t> scratch_;  // triangles of a polygon across chunks, or corners whose place they take
    std::uint64_t scratch_bytes_ = 0;     // for cutting, taken from the budget
    const char* first_uncut_ = nullptr;   // from which places count
    LeftOut small_;
};

/// Calls parse(piece, faces), which adds the faces of each of `pieces`, in parallel; throws as parse_pieces().
std::vector<FaceList> parse_faces(std::size_t pieces, const VertexCoordinates& vertices, MemoryBudget& budget,
                                  const Parallel& parallel, FunctionRef<void(std::size_t piece, FaceList& faces)> parse);

/// Gives `mesh`, which has its vertices, the triangles of all lists, in their order. Warns of faces that were left out,
/// whose lines are those of `text` if the mesh is one. Throws Refused.
void give_faces(std::span<FaceList> lists, MemoryBudget& budget, const FileSource& source, std::string_view text,
                MeshFile& mesh);

/// For formats that list vertices and faces as text. Calls parse(piece, coordinates, faces) for every piece, where
/// `coordinates` are those of vertex 0, three doubles each. Coordinates are doubles, as few decimals are exact floats; they
/// are read and sliced as fast. Throws errors.
void read_faces(const FileContents& file, std::size_t vertices, std::size_t pieces,
                FunctionRef<void(std::size_t piece, std::byte* coordinates, FaceList& faces)> parse, MeshFile& mesh);

/// Gives `mesh` room for vertices, whose coordinates are still to be written. Throws Refused.
void allocate_vertices(std::size_t count, Number type, MemoryBudget& budget, const Memory* memory, MeshFile& mesh);

/// The coordinates of a mesh that has its own bytes.
inline VertexCoordinates coordinates_of(const MeshFile& mesh) noexcept {
    return {mesh.bytes.data() + mesh.first_offset, mesh.stride, mesh.vertex_type};
}

}  // namespace lamella
