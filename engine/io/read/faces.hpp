// Faces of any number of corners, which become triangles, for all readers.
#pragma once

#include <limits>

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

/// The faces of one piece of a file, in their order. A face of n corners takes the room of the 3 (n - 2) indices of its
/// triangles, so that it can be cut in place once all vertices are known. Until then one of more than three corners is
/// whole:
///
///     a triangle   | a | b | c |
///     a quad       | quad mark | place | a | b | c | d |
///     n corners    | mark | place | n | a | b | c | d | e | ...
class FaceList {
public:
    /// What it holds is counted in `budget`.
    FaceList(MemoryBudget& budget, const Memory* memory) : budget_(&budget), indices_(memory) {}

    /// Adds a face, which is left out if it has fewer than three corners. `place`: a number by which the caller finds it
    /// again, not below those of the faces before. Throws Refused.
    void add(std::span<const std::uint32_t> corners, std::uint64_t place) {
        if (corners.size() == 3) {  // nearly all faces
            std::memcpy(room().data(), corners.data(), corners.size_bytes());
            indices_.add(3);
        } else if (corners.size() > 3) {
            add_polygon(corners, place);
        } else if (small_++ == 0) {
            first_small_ = place;
        }
    }

    std::size_t triangles() const noexcept { return indices_.size() / 3; }
    std::size_t most_corners() const noexcept { return most_corners_; }
    /// Faces left out, and the place of the first.
    std::size_t small() const noexcept { return small_; }
    std::uint64_t first_small() const noexcept { return first_small_; }
    /// From which places count: that of the first polygon.
    std::uint64_t begin() const noexcept { return begin_; }

    /// Taken from the budget.
    std::uint64_t bytes() const noexcept { return bytes_; }
    /// Moves all to `to`.
    void move_to(std::uint32_t* to) { indices_.move_to(to); }

private:
    static constexpr std::size_t smallest = 3 << 6;
    static constexpr std::size_t largest = 3 << 10;  // little is left unused of what the budget counts

    void add_polygon(std::span<const std::uint32_t> corners, std::uint64_t place);
    void put(std::span<const std::uint32_t> values);
    std::span<std::uint32_t> room() {
        if (const std::size_t bytes = indices_.next_bytes(); bytes > 0) {
            budget_->take(bytes, 1);
            bytes_ += bytes;
        }
        return indices_.room();
    }

    MemoryBudget* budget_;
    ChunkList<std::uint32_t, smallest, largest> indices_;  // chunks of whole triangles
    std::uint64_t bytes_ = 0;                              // taken from the budget
    std::size_t most_corners_ = 0;
    std::size_t small_ = 0;
    std::uint64_t first_small_ = 0;
    std::uint64_t begin_ = 0;
};

/// Calls parse(piece, faces), which adds the faces of each of `pieces`, in parallel; throws as parse_pieces().
std::vector<FaceList> parse_faces(std::size_t pieces, MemoryBudget& budget, const Parallel& parallel,
                                  FunctionRef<void(std::size_t piece, FaceList& faces)> parse);

/// Gives `mesh`, which has its vertices, the triangles of all lists, in their order: joined, and cut in parallel. For the
/// first face that cannot be cut it throws error(list, place, what), with the place as given to add(). Throws Refused.
using FaceError = FunctionRef<TextError(std::size_t list, std::uint64_t place, std::string what)>;
void give_faces(std::span<FaceList> lists, const VertexCoordinates& vertices, MemoryBudget& budget, const Parallel& parallel,
                FaceError error, MeshFile& mesh);

/// For formats that list vertices and faces as text. Calls parse(piece, coordinates, faces) for every piece, where
/// `coordinates` are those of vertex 0, three doubles each; and cuts the faces into triangles. Coordinates are doubles, as
/// few decimals are exact floats; they are read and sliced as fast. Places are bytes of the whole file. Throws errors.
void read_faces(const FileContents& file, std::size_t vertices, std::size_t pieces,
                FunctionRef<void(std::size_t piece, std::byte* coordinates, FaceList& faces)> parse, MeshFile& mesh);

/// Gives `mesh` room for vertices, whose coordinates are still to be written. Throws Refused.
void allocate_vertices(std::size_t count, Number type, MemoryBudget& budget, const Memory* memory, MeshFile& mesh);

/// The coordinates of a mesh that has its own bytes.
inline VertexCoordinates coordinates_of(const MeshFile& mesh) noexcept {
    return {mesh.bytes.data() + mesh.first_offset, mesh.stride, mesh.vertex_type};
}

}  // namespace lamella
