// Faces that are bad by themselves, and faces on the same vertices.
#include <algorithm>
#include <cmath>

#include "mesh/check/finders.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

/// Of a side in halves of grid units: 2^30 along an axis at most, so that the sum fits.
double square(const GridVector& v) {
    return static_cast<double>(v.x * v.x + v.y * v.y + v.z * v.z);
}

/// A sliver is a needle when its shortest side is under a tenth of the longest; else two angles are acute and small: a cap.
constexpr double needle_ratio = 10;

void judge_shape(const GridMesh& mesh, const Face& face, double sliver_ratio, FaultCollector& faults) {
    const std::array<GridVertex, 3> corners = mesh.corners(face);
    const GridVector ab = half(corners[1]) - half(corners[0]);
    const GridVector ac = half(corners[2]) - half(corners[0]);
    const GridVector bc = half(corners[2]) - half(corners[1]);
    const GridVector normal = cross(ab, ac);
    if (normal == GridVector{}) {
        faults.add(Fault::zero_area_face, [&] { return faults.at(face); });
        return;
    }
    // Longest side over the height on it. The components are exact, the rest is in double.
    const auto [shortest, longest] = std::minmax({square(ab), square(ac), square(bc)});
    const double over_height =
        longest / std::hypot(static_cast<double>(normal.x), static_cast<double>(normal.y), static_cast<double>(normal.z));
    if (over_height >= sliver_ratio) {
        faults.add(std::sqrt(longest / shortest) > needle_ratio ? Fault::needle_face : Fault::cap_face, [&] {
            FaultPlace place = faults.at(face);
            place.measure = over_height;
            return place;
        });
    }
}

FaultPlace place_of_pair(const Face& face, const Face& other, const FaultCollector& faults) {
    FaultPlace place = faults.at(face);
    place.triangles[1] = other.source;
    return place;
}

/// Faces [begin, end) have the same vertices; they are sorted by orientation.
void judge_group(const GridMesh& mesh, std::size_t begin, std::size_t end, FaultCollector& faults) {
    const auto same_orientation = [&](std::size_t i) { return mesh.faces[i].corners == mesh.faces[begin].corners; };
    std::size_t middle = begin;
    while (middle != end && same_orientation(middle)) {
        ++middle;
    }
    for (std::size_t i = begin + 1; i < end; ++i) {
        if (i != middle) {
            const Face& first = mesh.faces[i < middle ? begin : middle];
            faults.add(Fault::duplicate_face, [&] { return place_of_pair(first, mesh.faces[i], faults); });
        }
    }
    for (std::size_t i = 0; i < std::min(middle - begin, end - middle); ++i) {
        faults.add(Fault::opposite_face,
                   [&] { return place_of_pair(mesh.faces[begin + i], mesh.faces[middle + i], faults); });
    }
}

}  // namespace

void find_face_faults(const GridMesh& mesh, double sliver_ratio, FaultCollector& faults, const Parallel& parallel) {
    for (const Face& face : mesh.collapsed) {
        faults.add(Fault::collapsed_face, [&] { return faults.at(face); });
    }
    const auto same_vertices = [&](std::size_t a, std::size_t b) {
        return vertex_set(mesh.faces[a]) == vertex_set(mesh.faces[b]);
    };
    faults.in_groups(mesh.faces.size(), parallel, same_vertices,
                     [&](std::size_t begin, std::size_t end, FaultCollector& own) {
                         for (std::size_t face = begin; face != end; ++face) {
                             judge_shape(mesh, mesh.faces[face], sliver_ratio, own);
                         }
                         judge_group(mesh, begin, end, own);
                     });
}

}  // namespace lamella
