// Faults of faces by themselves, and in how they are joined: edges, vertices and orientations.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/parallel_sort.hpp"
#include "base/sort.hpp"
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
    // Longest side over the height on it. The components are exact, the rest is in double. Most faces are far from slivers,
    // which is seen without roots.
    const double a = square(ab), b = square(ac), c = square(bc);
    const double longest = std::max(a, std::max(b, c));
    const auto x = static_cast<double>(normal.x), y = static_cast<double>(normal.y), z = static_cast<double>(normal.z);
    constexpr double margin = 1 - 1e-9;
    if (longest * longest < margin * sliver_ratio * sliver_ratio * (x * x + y * y + z * z)) {
        return;
    }
    const double over_height = longest / std::hypot(x, y, z);
    if (over_height >= sliver_ratio) {
        const double shortest = std::min(a, std::min(b, c));
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

/// With its first faces.
FaultPlace place_of_edge(const GridMesh& mesh, const EdgeTable& edges, std::size_t edge, const FaultCollector& faults) {
    FaultPlace place = faults.at({edges[edge].lower, edges[edge].upper});
    const std::span<const std::uint32_t> sides = edges.sides(edge);
    for (std::size_t i = 0; i < std::min(sides.size(), place.triangles.size()); ++i) {
        place.triangles[i] = mesh.faces[EdgeTable::face_of(sides[i])].source;
    }
    place.parts = sides.size();
    return place;
}

/// The patches of a mesh: each face takes part twice, as it is (2 * face) and reversed (2 * face + 1), so that faces which
/// agree in orientation are in one set. Where the reversed first face is in the set of the first face, the patch has one
/// side. Two calls of run().
SharedSets<std::uint32_t> join_patches(const GridMesh& mesh, const EdgeTable& edges, const Parallel& parallel) {
    constexpr std::size_t grain = 8192;
    SharedSets<std::uint32_t> sets(2 * mesh.faces.size(), parallel, parallel.memory());
    parallel.run_ranges(edges.size(), grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t edge = begin; edge != end; ++edge) {
            if (const auto sides = edges.sides(edge); sides.size() == 2) {
                const std::uint32_t face = 2 * EdgeTable::face_of(sides[0]);
                const std::uint32_t next = 2 * EdgeTable::face_of(sides[1]) + (edges.is_balanced(edge) ? 0 : 1);
                sets.unite(face, next);
                sets.unite(face + 1, next ^ 1);
            }
        }
    });
    return sets;
}

/// `corner`: 3 * face + index.
std::uint32_t vertex_of(const GridMesh& mesh, std::size_t corner) {
    return mesh.faces[corner / 3].corners[corner % 3];
}

/// The corners at vertices without embedded stars, by vertex. At the others the faces form one fan.
Array<std::uint32_t> loose_corners(const GridMesh& mesh, const EmbeddedStars& stars, const Parallel& parallel) {
    Array<std::uint32_t> corners =
        indices_where(3 * mesh.faces.size(), parallel, parallel.memory(),
                      [&](std::size_t corner) { return !stars.contains(vertex_of(mesh, corner)); });
    sort_in_parallel(
        corners.span(),
        [&](std::uint32_t a, std::uint32_t b) {
            return std::pair(vertex_of(mesh, a), a) < std::pair(vertex_of(mesh, b), b);
        },
        parallel, parallel.memory());
    return corners;
}

/// How many fans the faces at these corners of one vertex form, joined over edges with two faces.
std::size_t count_fans(const GridMesh& mesh, std::span<const std::uint32_t> corners) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> spokes;  // the other end of an edge, and which corner has it
    std::vector<std::array<std::uint32_t, 2>> beside;             // of each corner: those joined to it, or itself
    beside.reserve(corners.size());
    spokes.reserve(2 * corners.size());
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
        beside.push_back({i, i});
        for (const std::uint32_t end : mesh.faces[corners[i] / 3].corners) {
            if (end != vertex_of(mesh, corners[i])) {
                spokes.push_back({end, i});
            }
        }
    }
    sort_briefly(spokes.begin(), spokes.end());
    for (std::size_t begin = 0, end = 0; begin < spokes.size(); begin = end) {
        while (end < spokes.size() && spokes[end].first == spokes[begin].first) {
            ++end;
        }
        if (end - begin == 2) {
            const std::array<std::uint32_t, 2> both = {spokes[begin].second, spokes[begin + 1].second};
            for (const std::size_t i : {0U, 1U}) {
                auto& [first, second] = beside[both[i]];
                (first == both[i] ? first : second) = both[1 - i];
            }
        }
    }
    std::size_t fans = 0;
    std::vector<bool> seen(corners.size(), false);
    std::vector<std::uint32_t> open;
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
        fans += seen[i] ? 0U : 1U;
        for (open.assign(1, i); !open.empty();) {
            const std::uint32_t at = open.back();
            open.pop_back();
            if (!seen[at]) {
                seen[at] = true;
                open.insert(open.end(), beside[at].begin(), beside[at].end());
            }
        }
    }
    return fans;
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

std::uint64_t find_edge_faults(const GridMesh& mesh, const EdgeTable& edges, FaultCollector& faults,
                               const Parallel& parallel) {
    std::atomic<std::uint64_t> unbalanced = 0;
    faults.in_ranges(edges.irregular().size(), parallel, [&](std::size_t begin, std::size_t end, FaultCollector& own) {
        std::uint64_t unbalanced_here = 0;
        for (std::size_t i = begin; i != end; ++i) {
            const std::uint32_t edge = edges.irregular()[i];
            const auto add = [&](Fault fault) { own.add(fault, [&] { return place_of_edge(mesh, edges, edge, own); }); };
            const std::size_t faces = edges.sides(edge).size();
            const bool balanced = edges.is_balanced(edge);
            unbalanced_here += balanced ? 0 : 1;
            if (faces == 1) {
                add(Fault::boundary_edge);
            } else if (faces > 2) {
                add(balanced ? Fault::overfull_balanced : Fault::overfull_unbalanced);
            } else {
                add(Fault::mismatched_edge);
            }
        }
        unbalanced += unbalanced_here;
    });
    return unbalanced;
}

void find_split_vertices(const GridMesh& mesh, const EmbeddedStars& stars, FaultCollector& faults,
                         const Parallel& parallel) {
    const Array<std::uint32_t> corners = loose_corners(mesh, stars, parallel);
    const auto same_vertex = [&](std::size_t a, std::size_t b) {
        return vertex_of(mesh, corners[a]) == vertex_of(mesh, corners[b]);
    };
    faults.in_groups(corners.size(), parallel, same_vertex, [&](std::size_t begin, std::size_t end, FaultCollector& own) {
        const std::size_t fans = count_fans(mesh, corners.span().subspan(begin, end - begin));
        if (fans > 1) {
            own.add(Fault::split_vertex, [&] {
                FaultPlace place = own.at({vertex_of(mesh, corners[begin])});
                place.triangles[0] = mesh.faces[corners[begin] / 3].source;
                place.parts = fans;
                return place;
            });
        }
    });
}

void find_flipped_faces(const GridMesh& mesh, const EdgeTable& edges, FaultCollector& faults, const Parallel& parallel) {
    if (faults.of(Fault::mismatched_edge).count == 0) {
        return;  // all faces of a patch agree
    }
    constexpr std::uint32_t faces_between_stops = 1 << 15;
    const auto count = static_cast<std::uint32_t>(mesh.faces.size());
    SharedSets<std::uint32_t> sets = join_patches(mesh, edges, parallel);
    // By the first face of a patch: its faces that agree with it, and those that do not.
    std::vector<std::array<std::uint32_t, 2>> sizes(count);
    for (std::uint32_t face = 0; face != count; ++face) {
        if (face % faces_between_stops == 0) {
            parallel.stop_if_asked();
        }
        const std::uint32_t root = sets.root(2 * face);
        ++sizes[root / 2][root % 2];
    }
    faults.in_ranges(count, parallel, [&](std::size_t begin, std::size_t end, FaultCollector& own) {
        for (auto face = static_cast<std::uint32_t>(begin); face != end; ++face) {
            const std::uint32_t root = sets.root(2 * face);
            const auto [alike, opposite] = sizes[root / 2];
            const bool flipped = (root % 2 != 0) == (opposite <= alike);
            if (root == sets.root(2 * face + 1)) {
                if (face == root / 2) {
                    own.add(Fault::one_sided_patch, [&] { return own.at(mesh.faces[face]); });
                }
            } else if (flipped) {
                own.add(Fault::flipped_face, [&] { return own.at(mesh.faces[face]); });
            }
        }
    });
}

}  // namespace lamella
