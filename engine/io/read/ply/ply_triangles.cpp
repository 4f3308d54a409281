#include "io/read/ply/ply_triangles.hpp"

#include <algorithm>
#include <cmath>

#include "io/read/ply/ply_rows.hpp"

namespace lamella {

bool PlyTriangles::add_face(std::span<const std::uint32_t> corners) {
    if (corners.size() < 3) {
        ++small_faces_;
        return true;
    }
    if (!fits(corners.size() - 2)) {
        return false;
    }
    if (corners.size() == 3) {
        std::copy(corners.begin(), corners.end(), room_.begin() + static_cast<std::ptrdiff_t>(used_));
        used_ += 3;
        return true;
    }
    if (!all_finite(corners)) {
        return false;
    }
    const std::size_t triangles = polygon_.triangulate(corners, vertices_, room_.data() + used_);
    used_ += 3 * triangles;
    if (triangles == 0) {
        why_ = "a polygon of " + std::to_string(corners.size()) + " corners that crosses itself too often";
    }
    return triangles > 0;
}

bool PlyTriangles::add_strips(std::span<const std::uint32_t> corners) {
    std::size_t begin = 0;  // of the strip
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (corners[i] == strip_end) {
            begin = i + 1;
        }
        if (i < begin + 2) {
            continue;
        }
        // Every other triangle of a strip is listed in reverse.
        const bool odd = (i - begin) % 2 != 0;
        const std::uint32_t a = corners[odd ? i - 1 : i - 2];
        const std::uint32_t b = corners[odd ? i - 2 : i - 1];
        const std::uint32_t c = corners[i];
        if (a == b || b == c || c == a) {
            continue;
        }
        if (!fits(1)) {
            return false;
        }
        for (const std::uint32_t corner : {a, b, c}) {
            room_[used_++] = corner;
        }
    }
    return true;
}

bool PlyTriangles::fits(std::size_t triangles) {
    if (3 * triangles <= room_.size() - used_) {
        return true;
    }
    why_ = "more triangles than there is room for";
    return false;
}

/// Polygons are cut by their coordinates, which must be finite. (Triangles are checked by slicing.)
bool PlyTriangles::all_finite(std::span<const std::uint32_t> corners) {
    for (const std::uint32_t corner : corners) {
        const std::array<double, 3> xyz = vertices_[corner];
        if (!std::isfinite(xyz[0]) || !std::isfinite(xyz[1]) || !std::isfinite(xyz[2])) {
            why_ = "vertex " + std::to_string(corner) + " has a coordinate that is not finite";
            return false;
        }
    }
    return true;
}

}  // namespace lamella
