// Shells: sets of triangles connected over edges; their orientations, and which lies within which.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/sign.hpp"
#include "mesh/check/finders.hpp"
#include "mesh/check/shell_nesting.hpp"
#include "slicing/grid/grid_vector.hpp"

namespace lamella {

namespace {

/// Numbers the shells by their first faces; the shell of each face.
std::vector<std::uint32_t> number_shells(const GridMesh& mesh, const EdgeTable& edges, std::uint32_t& count) {
    DisjointSets sets(mesh.faces.size());
    for (std::size_t edge = 0; edge < edges.size(); ++edge) {
        const std::span<const std::uint32_t> sides = edges.sides(edge);
        for (const std::uint32_t side : sides.subspan(1)) {
            sets.unite(EdgeTable::face_of(sides[0]), EdgeTable::face_of(side));
        }
    }
    std::vector<std::uint32_t> shell_of(mesh.faces.size());
    for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
        const std::uint32_t root = sets.root(face);
        shell_of[face] = root == face ? count++ : shell_of[root];
    }
    return shell_of;
}

/// Six times the volume between a face and a point near it, in halves of grid units: summed over a closed shell, exact.
Int128 six_volumes(const GridMesh& mesh, const Face& face, const GridVector& origin) {
    const std::array<GridVertex, 3> corners = mesh.corners(face);
    return dot(cross(half(corners[0]) - origin, half(corners[1]) - origin), half(corners[2]) - origin);
}

void measure(const GridMesh& mesh, const EdgeTable& edges, const std::vector<std::uint32_t>& shell_of,
             std::vector<MeshShell>& shells, const Notes& notes) {
    std::vector<Int128> volumes(shells.size(), 0);
    std::vector<GridVector> origins(shells.size());
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
        const Face& face = mesh.faces[i];
        MeshShell& shell = shells[shell_of[i]];
        if (shell.triangles++ == 0) {
            origins[shell_of[i]] = half(mesh.vertices[face.corners[0]]);
            shell.first_mm = notes.mm(mesh.vertices[face.corners[0]]);
            shell.triangle = face.source;
            shell.closed = true;
        }
        volumes[shell_of[i]] += six_volumes(mesh, face, origins[shell_of[i]]);
    }
    for (std::size_t edge = 0; edge < edges.size(); ++edge) {
        if (!edges.is_balanced(edge)) {
            shells[shell_of[EdgeTable::face_of(edges.sides(edge)[0])]].closed = false;
        }
    }
    const double cube_mm3 = 8 * mesh.unit_mm * mesh.unit_mm * mesh.unit_mm;
    for (std::size_t i = 0; i < shells.size(); ++i) {
        if (shells[i].closed) {
            shells[i].orientation = sign_of(volumes[i]);
            shells[i].volume_mm3 = static_cast<double>(volumes[i]) / 6 * cube_mm3;
        }
    }
}

/// Whether neither the shell nor any shell around it meets another one. Where one does, solids overlap or touch, and the
/// depth does not tell which orientation is right.
bool lies_apart(const std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& meets_other, std::size_t shell) {
    while (meets_other[shell] == 0 && shells[shell].parent >= 0) {
        shell = static_cast<std::size_t>(shells[shell].parent);
    }
    return meets_other[shell] == 0;
}

}  // namespace

std::vector<std::uint32_t> find_shells(const GridMesh& mesh, const EdgeTable& edges, const Notes& notes, MeshCheck& check,
                                       const Parallel& parallel) {
    std::uint32_t count = 0;
    std::vector<std::uint32_t> shell_of = number_shells(mesh, edges, count);
    check.shells.resize(count);
    measure(mesh, edges, shell_of, check.shells, notes);
    check.nesting_complete = nest_shells(mesh, shell_of, check.shells, parallel);
    return shell_of;
}

void find_misoriented_shells(const std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& meets_other,
                             bool all_known, Notes& notes) {
    notes.of(Fault::misoriented_shell).at_least = !all_known;
    for (std::size_t i = 0; all_known && i < shells.size(); ++i) {
        const MeshShell& shell = shells[i];
        const bool fits = shell.orientation == 0 || shell.orientation == (shell.depth % 2 == 0 ? 1 : -1);
        if (!fits && (shell.depth == 0 || lies_apart(shells, meets_other, i))) {
            notes.add(Fault::misoriented_shell, [&] {
                FaultPlace place;
                place.points_mm[0] = shell.first_mm;
                place.triangles[0] = shell.triangle;
                place.measure = shell.volume_mm3;
                return place;
            });
        }
    }
}

}  // namespace lamella
