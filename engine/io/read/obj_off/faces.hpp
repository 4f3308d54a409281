// A face of n corners becomes n - 2 triangles, so that the place of its indices is known before it is cut. Until all
// vertices are known, a face of more than three corners is stored there whole, with a mark before it.
//
//     a triangle   | a | b | c |
//     n corners    | mark | n | a | b | c | d | ...        n + 2 of the 3 (n - 2) indices, and n >= 4
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>

#include "io/read/reader.hpp"
#include "io/text/lines.hpp"

namespace lamella {

/// No vertex: readers take fewer vertices than this.
inline constexpr std::uint32_t polygon_mark = std::numeric_limits<std::uint32_t>::max();

constexpr std::size_t triangles_in(std::size_t corners) noexcept {
    return corners < 3 ? 0 : corners - 2;
}

class FaceWriter {
public:
    explicit FaceWriter(std::uint32_t* out) : face_(out) {}

    void add_corner(std::uint32_t vertex) {
        if (corners_ < 3) {
            first_[corners_] = vertex;
        } else {
            if (corners_ == 3) {
                std::memcpy(face_ + 2, first_, sizeof first_);
            }
            face_[2 + corners_] = vertex;
        }
        ++corners_;
    }

    /// Of the face that is being written.
    std::size_t corners() const { return corners_; }

    /// Drops the face that is being written. Precondition: corners() < 3.
    void drop_face() { corners_ = 0; }

    /// Precondition: 3 <= corners() < polygon_mark.
    void end_face() {
        if (corners_ == 3) {
            std::memcpy(face_, first_, sizeof first_);
        } else {
            face_[0] = polygon_mark;
            face_[1] = static_cast<std::uint32_t>(corners_);
        }
        face_ += 3 * triangles_in(corners_);
        corners_ = 0;
    }

private:
    std::uint32_t* face_;
    std::size_t corners_ = 0;
    std::uint32_t first_[3] = {};
};

/// The triangles of one piece of text.
struct FaceRange {
    std::size_t first_triangle = 0;  ///< filled in by read_faces()
    std::size_t triangles = 0;       ///< as counted
    std::size_t most_corners = 0;    ///< of a face
    LeftOut small;                   ///< faces of fewer than three corners, which have no area

    /// Counts the face at `at`.
    void add(std::size_t corners, const char* at) {
        triangles += triangles_in(corners);
        most_corners = std::max(most_corners, corners);
        if (corners < 3) {
            small.add(at);
        }
    }
};

/// For formats that list vertices and faces as text. Makes room for as many as were counted, within the limit on memory;
/// calls parse(piece, coordinates, faces) for every piece, where `coordinates` are those of vertex 0, three doubles each;
/// and cuts the faces into triangles. Coordinates are doubles, as few decimals are exact floats; they are read and sliced as
/// fast. Failures are reported with their place in `text`. place(piece, face) finds a face that cannot be cut; faces that
/// are left out do not count.
Result<MeshFile> read_faces(const FileSource& source, std::string_view text, std::size_t vertices,
                            std::span<FaceRange> pieces,
                            FunctionRef<TextFailure(std::size_t piece, std::byte* coordinates, FaceWriter& faces)> parse,
                            FunctionRef<const char*(std::size_t piece, std::size_t face)> place);

}  // namespace lamella
