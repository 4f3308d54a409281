// Faces of any number of corners, which become triangles, for all readers. A face of n corners becomes n - 2 triangles, so
// that the place of its indices is known before it is cut. Until all vertices are known, a face of more than three corners
// is stored there whole, with a mark before it.
//
//     a triangle   | a | b | c |
//     n corners    | mark | n | a | b | c | d | ...        n + 2 of the 3 (n - 2) indices, and n >= 4
#pragma once

#include <limits>

#include "base/function_ref.hpp"
#include "io/read/polygon.hpp"
#include "io/read/reader.hpp"
#include "io/text/lines.hpp"

namespace lamella {

/// No vertex: readers take fewer vertices than this.
inline constexpr std::uint32_t polygon_mark = std::numeric_limits<std::uint32_t>::max();

constexpr std::size_t triangles_in(std::size_t corners) noexcept {
    return corners < 3 ? 0 : corners - 2;
}

/// The triangles of one piece of a file.
struct FaceRange {
    std::size_t first_triangle = 0;
    std::size_t triangles = 0;     ///< as counted
    std::size_t most_corners = 0;  ///< of a face
    LeftOut small{};               ///< faces of fewer than three corners, which have no area

    /// Counts the face at `at`.
    void add(std::size_t corners, const char* at) {
        triangles += triangles_in(corners);
        most_corners = std::max(most_corners, corners);
        if (corners < 3) {
            small.add(at);
        }
    }
};

/// Stores the faces of a piece one after the other.
class FaceWriter {
public:
    FaceWriter(std::span<std::uint32_t> indices, const FaceRange& own)
        : begin_(indices.data() + 3 * own.first_triangle), face_(begin_), end_(begin_ + 3 * own.triangles) {}

    /// Stores a face, which is left out if it has fewer than three corners. False: there is no room for it, or its corners
    /// are too many to be numbered.
    bool add(std::span<const std::uint32_t> corners) {
        if (3 * triangles_in(corners.size()) > static_cast<std::size_t>(end_ - face_) || corners.size() >= polygon_mark) {
            return false;
        }
        if (corners.size() == 3) {  // nearly all faces are triangles or quads, whose sizes compilers then know
            std::memcpy(face_, corners.data(), 3 * sizeof(std::uint32_t));
        } else if (corners.size() > 3) {
            face_[0] = polygon_mark;
            face_[1] = static_cast<std::uint32_t>(corners.size());
            if (corners.size() == 4) {
                std::memcpy(face_ + 2, corners.data(), 4 * sizeof(std::uint32_t));
            } else {
                std::copy(corners.begin(), corners.end(), face_ + 2);
            }
        }
        face_ += 3 * triangles_in(corners.size());
        return true;
    }

    /// Written so far.
    std::size_t triangles() const { return static_cast<std::size_t>(face_ - begin_) / 3; }

private:
    std::uint32_t* begin_;
    std::uint32_t* face_;
    std::uint32_t* end_;
};

/// A face of more than three corners that cannot be cut.
struct RefusedFace {
    std::size_t number = 0;  ///< among those that its piece has stored
    std::optional<std::uint32_t>
        vertex;  ///< has a coordinate that is not finite; none: its outline crosses itself too often
};

/// Cuts what FaceWriter stored into triangles, in parallel. Calls refuse(piece, face), which throws a TextError, for the
/// first face that cannot be cut.
void cut_faces(std::span<const FaceRange> pieces, std::span<std::uint32_t> indices, const VertexCoordinates& vertices,
               const Parallel& parallel, FunctionRef<void(std::size_t piece, const RefusedFace& face)> refuse);

/// Scratch memory of one thread that cuts faces of so many corners.
constexpr std::size_t cutting_bytes(std::size_t most_corners) noexcept {
    return PolygonTriangulator::scratch_bytes(most_corners) + 2 * most_corners * sizeof(std::uint32_t);
}

/// For formats that list vertices and faces as text. Makes room in `mesh` for as many as were counted, within the limit on
/// memory; calls parse(piece, coordinates, faces) for every piece, where `coordinates` are those of vertex 0, three doubles
/// each; and cuts the faces into triangles. Coordinates are doubles, as few decimals are exact floats; they are read and
/// sliced as fast. Throws errors. place(piece, face) finds a face that cannot be cut.
void read_faces(const FileContents& file, std::size_t vertices, std::span<FaceRange> pieces,
                FunctionRef<void(std::size_t piece, std::byte* coordinates, FaceWriter& faces)> parse,
                FunctionRef<const char*(std::size_t piece, std::size_t face)> place, MeshFile& mesh);

/// Gives `mesh` room for vertices, whose coordinates are still to be written.
void allocate_vertices(std::size_t count, Number type, const Memory* memory, MeshFile& mesh);

}  // namespace lamella
