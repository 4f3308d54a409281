// Shells: sets of triangles connected over edges; their orientations, and which lies within which.
#include <algorithm>
#include <cstddef>
#include <limits>
#include <mutex>
#include <numeric>
#include <span>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/distribute.hpp"
#include "base/numbers.hpp"
#include "base/parallel_sort.hpp"
#include "mesh/check/finders.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr std::size_t faces_a_range = std::size_t{1} << 15;

/// Three calls of run() after those that unite: numbers the shells by their first faces. The shell of each face.
Array<std::uint32_t> number_shells(SharedSets<std::uint32_t>& sets, std::uint32_t& count, const Parallel& parallel) {
    Array<std::uint32_t> shell_of(parallel.memory());
    shell_of.resize_discarding(sets.size());
    number_where(
        sets.size(), parallel, [&](std::size_t face) { return sets.is_root(face); },
        [&](std::uint32_t shells) { count = shells; },
        [&](std::size_t face, std::uint32_t shell, bool is_first) { shell_of[face] = is_first ? shell : 0; });
    parallel.run_ranges(sets.size(), faces_a_range, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t face = begin; face != end; ++face) {
            if (!sets.is_root(face)) {
                shell_of[face] = shell_of[sets.root(static_cast<std::uint32_t>(face))];
            }
        }
    });
    return shell_of;
}

using Corners = std::array<GridVertex, 3>;

/// Six times the volume between a face and zero, in halves of grid units: summed over a closed shell, exact.
Int128 six_volumes(const Corners& corners) {
    return dot(cross(half(corners[0]), half(corners[1])), half(corners[2]));
}

/// A vertex and one of its faces: the smallest is what a shell is known by.
struct FirstPlace {
    GridVertex vertex;
    std::uint32_t face;
    friend auto operator<=>(const FirstPlace&, const FirstPlace&) = default;
};

/// Sums over faces of a shell.
struct ShellSums {
    std::uint32_t shell;
    std::uint32_t triangles = 0;
    Int128 six_volumes = 0;
    FirstPlace first = {{grid_limit, grid_limit, grid_limit}, std::numeric_limits<std::uint32_t>::max()};

    void add(const ShellSums& other) {
        triangles += other.triangles;
        six_volumes += other.six_volumes;
        first = std::min(first, other.first);
    }
};

/// By shell. One call of run(); what a range of faces finds is added up when it ends, which may be in any order.
std::vector<ShellSums> sums_of(const GridMesh& mesh, const Array<std::uint32_t>& shell_of, std::uint32_t shells,
                               const Parallel& parallel) {
    std::vector<ShellSums> sums(shells);
    std::mutex adding;
    parallel.run_ranges(shell_of.size(), faces_a_range, [&](std::size_t begin, std::size_t end, int) {
        std::vector<ShellSums> stretches;  // faces that follow one another in one shell
        for (std::size_t i = begin; i != end; ++i) {
            if (stretches.empty() || stretches.back().shell != shell_of[i]) {
                stretches.push_back({shell_of[i]});
            }
            const Corners corners = mesh.corners(mesh.faces[i]);
            stretches.back().add({shell_of[i],
                                  1,
                                  six_volumes(corners),
                                  {std::min({corners[0], corners[1], corners[2]}), static_cast<std::uint32_t>(i)}});
        }
        const std::lock_guard lock(adding);
        for (const ShellSums& own : stretches) {
            sums[own.shell].add(own);
        }
    });
    return sums;
}

/// Fills in what each shell measures. Returns what it is known by.
std::vector<FirstPlace> measure_shells(const GridMesh& mesh, const EdgeTable& edges, const Array<std::uint32_t>& shell_of,
                                       const FaultCollector& faults, std::vector<MeshShell>& shells,
                                       const Parallel& parallel) {
    const auto count = static_cast<std::uint32_t>(shells.size());
    for (MeshShell& shell : shells) {
        shell.closed = true;
    }
    for (const std::uint32_t edge : edges.irregular()) {
        if (!edges.is_balanced(edge)) {
            shells[shell_of[EdgeTable::face_of(edges.sides(edge)[0])]].closed = false;
        }
    }
    const double cube_mm3 = 8 * mesh.grid_mm * mesh.grid_mm * mesh.grid_mm;
    std::vector<FirstPlace> firsts;
    firsts.reserve(count);
    const std::vector<ShellSums> sums = sums_of(mesh, shell_of, count, parallel);
    for (std::size_t i = 0; i < shells.size(); ++i) {
        const ShellSums& own = sums[i];
        firsts.push_back(own.first);
        shells[i].triangles = own.triangles;
        shells[i].first_mm = faults.mm(own.first.vertex);
        shells[i].triangle = mesh.faces[own.first.face].source;
        if (shells[i].closed) {
            shells[i].orientation = sign_of(own.six_volumes);
            shells[i].volume_mm3 = static_cast<double>(own.six_volumes) / 6 * cube_mm3;
        }
    }
    return firsts;
}

/// Numbers the shells anew, by what they are known by: where they are not in that order yet, in five calls of run().
void sort_shells(const std::vector<FirstPlace>& firsts, std::vector<MeshShell>& shells, Array<std::uint32_t>& shell_of,
                 const Parallel& parallel) {
    if (std::is_sorted(firsts.begin(), firsts.end())) {
        return;
    }
    std::vector<std::uint32_t> order(shells.size());
    std::iota(order.begin(), order.end(), 0U);
    sort_in_parallel(
        std::span<std::uint32_t>(order), [&](std::uint32_t a, std::uint32_t b) { return firsts[a] < firsts[b]; }, parallel);
    std::vector<MeshShell> sorted(shells.size());
    std::vector<std::uint32_t> ranks(shells.size());
    for (std::uint32_t rank = 0; rank < order.size(); ++rank) {
        sorted[rank] = shells[order[rank]];
        ranks[order[rank]] = rank;
    }
    shells = std::move(sorted);
    parallel.run_ranges(shell_of.size(), faces_a_range, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t face = begin; face != end; ++face) {
            shell_of[face] = ranks[shell_of[face]];
        }
    });
}

/// True if neither the shell nor any shell around it meets another one. Where one does, solids overlap or touch, and the
/// depth does not tell which orientation is right.
bool lies_apart(const std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& meets_other, std::size_t shell) {
    while (meets_other[shell] == 0 && shells[shell].parent >= 0) {
        shell = static_cast<std::size_t>(shells[shell].parent);
    }
    return meets_other[shell] == 0;
}

}  // namespace

Array<std::uint32_t> join_shells(const GridMesh& mesh, const EdgeTable& edges, std::uint32_t& count,
                                 const Parallel& parallel) {
    SharedSets<std::uint32_t> sets(mesh.faces.size(), parallel, parallel.memory());
    parallel.run_ranges(edges.size(), faces_a_range, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t edge = begin; edge != end; ++edge) {
            const std::span<const std::uint32_t> sides = edges.sides(edge);
            for (const std::uint32_t side : sides.subspan(1)) {
                sets.unite(EdgeTable::face_of(sides[0]), EdgeTable::face_of(side));
            }
        }
    });
    return number_shells(sets, count, parallel);
}

Array<std::uint32_t> find_shells(const GridMesh& mesh, const EdgeTable& edges, const FaceTree& tree,
                                 const FaultCollector& faults, MeshCheck& check, const Parallel& parallel, bool whole) {
    std::uint32_t count = 0;
    Array<std::uint32_t> shell_of = join_shells(mesh, edges, count, parallel);
    check.shells.resize(count);
    const std::vector<FirstPlace> firsts = measure_shells(mesh, edges, shell_of, faults, check.shells, parallel);
    sort_shells(firsts, check.shells, shell_of, parallel);
    check.nesting_complete = nest_shells(mesh, tree, shell_of, check.shells, whole, parallel);
    return shell_of;
}

void find_misoriented_shells(const std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& meets_other,
                             bool all_known, FaultCollector& faults) {
    faults.of(Fault::misoriented_shell).at_least = !all_known;
    for (std::size_t i = 0; all_known && i < shells.size(); ++i) {
        const MeshShell& shell = shells[i];
        if (is_misoriented(shell) && (shell.depth == 0 || lies_apart(shells, meets_other, i))) {
            faults.add(Fault::misoriented_shell, [&] {
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
