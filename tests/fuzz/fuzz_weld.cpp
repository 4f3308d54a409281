// Welds soups with corners near small integers. No two remaining vertices may lie within the tolerance, none may be new or
// moved farther than it, and the order of triangles must not matter.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "bytes.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"

using namespace lamella;
using fuzz::Corner;

namespace {

constexpr std::size_t most_triangles = 100;

struct Case {
    std::vector<fuzz::Triangle> triangles;
    double tolerance = 0;
};

/// Corners within a few sixteenths of integers, so that distances of exactly the tolerance are common.
Case drawn(fuzz::Bytes& bytes, unsigned form) {
    Case drawn;
    drawn.tolerance = bytes.below(40) / 16.0;
    while (drawn.triangles.empty() || (!bytes.empty() && drawn.triangles.size() < most_triangles)) {
        fuzz::add_shape(bytes, form / 2 % 2 != 0, 1, drawn.triangles);
        for (Corner& at : drawn.triangles.back()) {
            at[form / 4 % 3] += bytes.below(5) / 16.0;
        }
    }
    return drawn;
}

template <class Number>
WeldedMesh welded(const std::vector<Number>& soup, double tolerance) {
    return fuzz::value_of(weld(MeshView::soup(std::span<const Number>(soup)), tolerance));
}

template <class Number>
std::vector<Corner> vertices_of(const WeldedMesh& mesh) {
    fuzz::require(mesh.coordinates.size() == 3 * mesh.vertex_count * sizeof(Number), "three numbers a vertex");
    std::vector<Corner> vertices(mesh.vertex_count);
    for (std::size_t i = 0; i < 3 * vertices.size(); ++i) {
        Number number{};
        std::memcpy(&number, mesh.coordinates.data() + i * sizeof number, sizeof number);
        vertices[i / 3][i % 3] = static_cast<double>(number);
    }
    return vertices;
}

double squared_distance(const Corner& a, const Corner& b) {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        sum += (a[axis] - b[axis]) * (a[axis] - b[axis]);
    }
    return sum;
}

void check_vertices(const std::vector<Corner>& vertices, const std::vector<Corner>& corners, double tolerance) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        fuzz::require(std::find(corners.begin(), corners.end(), vertices[i]) != corners.end(), "no coordinate is invented");
        for (std::size_t j = 0; j < i; ++j) {
            fuzz::require(squared_distance(vertices[i], vertices[j]) > tolerance * tolerance,
                          "vertices within the tolerance are joined");
        }
    }
}

/// Compares sixteenths, which are exact in either type.
template <class Number>
void check_weld(Case drawn, std::uint32_t seed) {
    const std::vector<Number> soup = fuzz::soup_of<Number>(drawn.triangles);
    const WeldedMesh mesh = welded(soup, drawn.tolerance);
    std::vector<Corner> corners;
    for (const fuzz::Triangle& triangle : drawn.triangles) {
        corners.insert(corners.end(), triangle.begin(), triangle.end());
    }
    const std::vector<Corner> vertices = vertices_of<Number>(mesh);
    fuzz::require(mesh.indices.size() == corners.size(), "the same triangles");
    double largest_move = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        fuzz::require(mesh.indices[i] < vertices.size(), "indices are vertices");
        largest_move = std::max(largest_move, squared_distance(corners[i], vertices[mesh.indices[i]]));
    }
    fuzz::require(std::sqrt(largest_move) == mesh.largest_move_mm && mesh.largest_move_mm <= drawn.tolerance,
                  "the largest move is reported and within the tolerance");
    check_vertices(vertices, corners, drawn.tolerance);
    std::sort(corners.begin(), corners.end());
    const auto distinct = std::unique(corners.begin(), corners.end()) - corners.begin();
    fuzz::require(mesh.joined + mesh.vertex_count == static_cast<std::uint64_t>(distinct), "every vertex is kept or joined");
    fuzz::shuffle_soup(drawn.triangles, seed);
    const WeldedMesh again = welded(fuzz::soup_of<Number>(drawn.triangles), drawn.tolerance);
    fuzz::require(vertices_of<Number>(again) == vertices, "the order of triangles and corners does not change the result");
    fuzz::require(fuzz::value_of(weld(mesh.view(), drawn.tolerance)).joined == 0, "welding a welded mesh joins nothing");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const unsigned form = bytes.next();
    const Case weld_case = drawn(bytes, form);
    form % 2 == 0 ? check_weld<float>(weld_case, form) : check_weld<double>(weld_case, form);
    return 0;
}
