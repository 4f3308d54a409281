// Shells: sets of triangles connected over edges; their orientations, and which lies within which.
#include <algorithm>
#include <cstddef>
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

/// Six times the volume between a face and a point near it, in halves of grid units: summed over a closed shell, exact.
Int128 six_volumes(const Corners& corners, const GridVector& origin) {
    return dot(cross(half(corners[0]) - origin, half(corners[1]) - origin), half(corners[2]) - origin);
}

/// A vertex and one of its faces: the smallest is what a shell is known by.
struct FirstPlace {
    GridVertex vertex;
    std::uint32_t face;
    friend auto operator<=>(const FirstPlace&, const FirstPlace&) = default;
};

FirstPlace first_place(const Corners& corners, std::uint32_t face) {
    return {std::min({corners[0], corners[1], corners[2]}), face};
}

/// The sums of faces that follow one another in one shell.
struct ShellPart {
    std::uint32_t shell;
    std::uint32_t triangles;
    Int128 six_volumes;
    FirstPlace first;
};

class ShellMeasure {
public:
    ShellMeasure(const GridMesh& mesh, const EdgeTable& edges, const Array<std::uint32_t>& shell_of,
                 std::vector<MeshShell>& shells, const Parallel& parallel)
        : mesh_(mesh),
          edges_(edges),
          shell_of_(shell_of),
          shells_(shells),
          parallel_(parallel),
          volumes_(shells.size(), 0),
          firsts_(shells.size()) {}

    /// Five calls of run() or more. Returns what each shell is known by.
    std::vector<FirstPlace> run(const FaultCollector& faults) {
        find_origins();
        add_faces();
        find_open();
        const double cube_mm3 = 8 * mesh_.grid_mm * mesh_.grid_mm * mesh_.grid_mm;
        for (std::size_t i = 0; i < shells_.size(); ++i) {
            shells_[i].first_mm = faults.mm(firsts_[i].vertex);
            shells_[i].triangle = mesh_.faces[firsts_[i].face].source;
            if (shells_[i].closed) {
                shells_[i].orientation = sign_of(volumes_[i]);
                shells_[i].volume_mm3 = static_cast<double>(volumes_[i]) / 6 * cube_mm3;
            }
        }
        return std::move(firsts_);
    }

private:
    /// A shell's number is first met at its first face.
    void find_origins() {
        for (std::uint32_t face = 0; origins_.size() < shells_.size(); ++face) {
            if (shell_of_[face] != origins_.size()) {
                continue;
            }
            if (origins_.size() % faces_a_range == 0) {
                parallel_.stop_if_asked();
            }
            const Corners corners = mesh_.corners(mesh_.faces[face]);
            firsts_[origins_.size()] = first_place(corners, face);
            origins_.push_back(half(corners[0]));
        }
    }

    /// Some ranges at a time, so that what they found stays small where every face is a shell.
    void add_faces() {
        const std::size_t ranges = shell_of_.size() / faces_a_range + 1;
        const std::size_t at_once = static_cast<std::size_t>(parallel_.threads()) * 8;
        std::vector<std::vector<ShellPart>> parts(at_once);
        for (std::size_t begin = 0; begin < ranges; begin += at_once) {
            parallel_.run(std::min(at_once, ranges - begin), [&](std::size_t i, int) {
                add_range(shell_of_.size() * (begin + i) / ranges, shell_of_.size() * (begin + i + 1) / ranges, parts[i]);
            });
            for (std::vector<ShellPart>& own : parts) {
                for (const ShellPart& part : own) {
                    shells_[part.shell].triangles += part.triangles;
                    volumes_[part.shell] += part.six_volumes;
                    firsts_[part.shell] = std::min(firsts_[part.shell], part.first);
                }
                own.clear();
            }
        }
    }

    void add_range(std::size_t begin, std::size_t end, std::vector<ShellPart>& parts) const {
        for (std::size_t i = begin; i != end; ++i) {
            const std::uint32_t shell = shell_of_[i];
            const Corners corners = mesh_.corners(mesh_.faces[i]);
            const FirstPlace first = first_place(corners, static_cast<std::uint32_t>(i));
            if (parts.empty() || parts.back().shell != shell) {
                parts.push_back({shell, 0, 0, first});
            }
            ShellPart& part = parts.back();
            ++part.triangles;
            part.six_volumes += six_volumes(corners, origins_[shell]);
            part.first = std::min(part.first, first);
        }
    }

    void find_open() {
        for (MeshShell& shell : shells_) {
            shell.closed = true;
        }
        for (const std::uint32_t edge : edges_.irregular()) {
            if (!edges_.is_balanced(edge)) {
                shells_[shell_of_[EdgeTable::face_of(edges_.sides(edge)[0])]].closed = false;
            }
        }
    }

    const GridMesh& mesh_;
    const EdgeTable& edges_;
    const Array<std::uint32_t>& shell_of_;
    std::vector<MeshShell>& shells_;
    const Parallel& parallel_;
    std::vector<Int128> volumes_;
    std::vector<GridVector> origins_;  ///< a vertex of each shell
    std::vector<FirstPlace> firsts_;
};

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
    const std::vector<FirstPlace> firsts = ShellMeasure(mesh, edges, shell_of, check.shells, parallel).run(faults);
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
