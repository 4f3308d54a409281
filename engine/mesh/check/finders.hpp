// The stages of check(), each of which finds some kinds of faults, and where they record what they find.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <mutex>
#include <set>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/check.hpp"
#include "lamella/weld.hpp"
#include "mesh/check/grid_mesh.hpp"
#include "slicing/grid/box_tree.hpp"

namespace lamella {

/// Fills in the mesh's box, grid, volume, area and number of triangles. Two calls of run(), which lead the progress on to
/// `progress`. O(n). The sums do not depend on threads. Throws Refused.
void measure_mesh(const MeshView& mesh, const Frame& frame, const Parallel& parallel, double progress, MeshCheck& check);

/// The mesh with equal vertices made one. Precondition: it has been measured.
WeldedMesh weld_equal(const MeshView& mesh, const Parallel& parallel);

using Findings = std::array<FaultFinding, fault_count>;

class FaultCollector {
public:
    FaultCollector(const GridMesh& mesh, std::size_t most, Findings& findings) noexcept
        : mesh_(mesh), most_(most), findings_(findings) {}

    std::size_t most() const noexcept { return most_; }

    /// Counts a fault; make() returns its FaultPlace, and is called for the first few only. Faults of a kind come in order.
    template <class Make>
    void add(Fault fault, Make make) {
        FaultFinding& finding = of(fault);
        ++finding.count;
        if (finding.places.size() < most_) {
            finding.places.push_back(make());
        }
    }

    /// One call of run(): search(begin, end, faults) for ranges of [0, count), each with a collector of its own, which are
    /// added to this one in the order of the ranges. So faults of a kind come in the order of the items.
    template <class Search>
    void in_ranges(std::size_t count, const Parallel& parallel, Search search) {
        constexpr std::size_t items_a_range = std::size_t{1} << 15;
        const std::size_t ranges = count / items_a_range + 1;
        std::vector<Findings> found(ranges);
        parallel.run(ranges, [&](std::size_t range, int) {
            FaultCollector own(mesh_, most_, found[range]);
            search(count * range / ranges, count * (range + 1) / ranges, own);
        });
        for (const Findings& own : found) {
            add(own);
        }
    }

    /// The same for groups of items that follow one another and are alike(i, i - 1): judge(begin, end, faults) for each.
    template <class Alike, class Judge>
    void in_groups(std::size_t count, const Parallel& parallel, Alike alike, Judge judge) {
        in_ranges(count, parallel, [&](std::size_t first, std::size_t last, FaultCollector& own) {
            while (first < last && first > 0 && alike(first, first - 1)) {
                ++first;  // belongs to the range before
            }
            for (std::size_t begin = first; begin < last;) {
                std::size_t end = begin + 1;
                while (end < count && alike(end, end - 1)) {
                    ++end;
                }
                judge(begin, end, own);
                begin = end;
            }
        });
    }

    FaultFinding& of(Fault fault) noexcept { return findings_[static_cast<std::size_t>(fault)]; }

    std::array<double, 3> mm(const GridVertex& vertex) const noexcept {
        return {vertex.x * mesh_.grid_mm, vertex.y * mesh_.grid_mm, vertex.z * mesh_.grid_mm};
    }

    /// At up to three vertices.
    FaultPlace at(std::initializer_list<std::uint32_t> vertices) const noexcept {
        FaultPlace place;
        place.point_count = 0;
        for (const std::uint32_t vertex : vertices) {
            place.points_mm[static_cast<std::size_t>(place.point_count++)] = mm(mesh_.vertices[vertex]);
        }
        return place;
    }

    FaultPlace at(const Face& face) const noexcept {
        FaultPlace place = at({face.corners[0], face.corners[1], face.corners[2]});
        place.triangles[0] = face.source;
        return place;
    }

private:
    void add(const Findings& other) {
        for (std::size_t fault = 0; fault < fault_count; ++fault) {
            std::vector<FaultPlace>& places = findings_[fault].places;
            const std::vector<FaultPlace>& more = other[fault].places;
            const std::size_t taken = std::min(more.size(), most_ - std::min(most_, places.size()));
            places.insert(places.end(), more.begin(), more.begin() + static_cast<std::ptrdiff_t>(taken));
            findings_[fault].count += other[fault].count;
        }
    }

    const GridMesh& mesh_;
    std::size_t most_;
    Findings& findings_;
};

// A search for pairs whose work is bounded, so that it never becomes quadratic. Its findings do not depend on threads.

/// Counts items, and keeps the `most` smallest.
template <class Item>
class Tally {
public:
    explicit Tally(std::size_t most) noexcept : most_(most) {}

    void add(const Item& item) {
        ++count_;
        if (kept_.size() < most_) {
            kept_.insert(item);
        } else if (most_ > 0 && item < *kept_.rbegin()) {
            kept_.erase(std::prev(kept_.end()));
            kept_.insert(item);
        }
    }

    /// The count, and make_place(item) for those kept, in their order.
    template <class MakePlace>
    void fill_in(FaultFinding& finding, MakePlace make_place) const {
        finding.count = count_;
        std::transform(kept_.begin(), kept_.end(), std::back_inserter(finding.places), make_place);
    }

private:
    std::size_t most_;
    std::uint64_t count_ = 0;
    std::multiset<Item> kept_;
};

/// The cost of a search at most, in boxes compared: about a second, which suffices for real meshes.
constexpr std::size_t search_budget(std::size_t items) {
    return (std::size_t{1} << 29) + 1024 * items;
}

/// How many queries search_within() makes in one call of run() at first.
constexpr std::size_t queries_a_run = std::size_t{1} << 14;

/// Calls search(query, limit, found) for all queries on all threads, which adds to `found`, stops at the limit and returns
/// what it cost; and keep(item) for all that is found, on one thread at a time, a query's items in the order in which it
/// found them. Most queries are done at the first attempt, at which each may cost a little. Those that take more are begun
/// anew when all others are done, so that a pile of faces takes nothing from the rest of the mesh: each may then cost an
/// equal share, within a run, of what is left of the budget. Where the search ends depends on the queries alone. Returns
/// whether every query was searched to its end.
template <class Item, class Search, class Keep>
bool search_within(std::size_t budget, std::size_t queries, const Parallel& parallel, Search search, Keep keep) {
    constexpr std::size_t most_at_first = std::size_t{1} << 16;
    constexpr std::size_t later_a_run = 256;
    constexpr std::size_t most_for_one = std::size_t{1} << 25;  // so that a query ends soon after a stop is asked for
    std::vector<std::vector<Item>> found(static_cast<std::size_t>(parallel.threads()));  // by worker, of one query
    std::vector<std::size_t> costs(queries_a_run);
    std::mutex keeping;
    // What is found of a query that reaches the limit is kept at its last attempt only.
    const auto attempt = [&](std::size_t count, std::size_t limit, bool last, auto query) {
        parallel.run_ranges(count, last ? 1 : 16, [&](std::size_t begin, std::size_t end, int worker) {
            std::vector<Item>& own = found[static_cast<std::size_t>(worker)];
            for (std::size_t i = begin; i != end; ++i) {
                own.clear();
                costs[i] = search(query(i), limit, own);
                if (!own.empty() && (last || costs[i] < limit)) {
                    const std::lock_guard lock(keeping);
                    std::for_each(own.begin(), own.end(), keep);
                }
            }
        });
        for (std::size_t i = 0; i < count; ++i) {
            budget -= std::min(budget, costs[i]);
        }
    };
    std::vector<std::size_t> later;
    std::size_t in_vain = budget / 2;  // what attempts without success may still cost
    std::size_t first = 0;
    for (; first < queries && in_vain > 0; first += queries_a_run) {
        const std::size_t count = std::min(queries_a_run, queries - first);
        const std::size_t limit = std::min(most_at_first, budget / queries_a_run);
        attempt(count, limit, false, [first](std::size_t i) { return first + i; });
        for (std::size_t i = 0; i < count; ++i) {
            if (costs[i] >= limit) {
                in_vain -= std::min(in_vain, costs[i]);
                later.push_back(first + i);
            }
        }
    }
    for (; first < queries; ++first) {
        later.push_back(first);
    }
    bool complete = true;
    for (std::size_t begin = 0; begin < later.size(); begin += later_a_run) {
        const std::size_t count = std::min(later_a_run, later.size() - begin);
        const std::size_t limit = std::min(most_for_one, budget / later_a_run);
        if (limit == 0) {
            return false;
        }
        attempt(count, limit, true, [&](std::size_t i) { return later[begin + i]; });
        complete = complete && std::all_of(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(count),
                                           [limit](std::size_t cost) { return cost < limit; });
    }
    return complete;
}

/// The faces of a mesh, found by where they lie: its items. Those that have no area meet nothing. Of several faces on the
/// same vertices, which follow one another in the mesh, the first stands for all: so a body that was exported a thousand
/// times costs little more than once. O(n), in at most 11 calls of run(). Throws std::bad_alloc.
using FaceTree = BoxTree<GridVertex>;
FaceTree make_face_tree(const GridMesh& mesh, const EmbeddedStars& stars, const Parallel& parallel);

/// Edges by the faces at each. Returns how many have more faces one way than the other. O(edges), one call of run().
std::uint64_t find_edge_faults(const GridMesh& mesh, const EdgeTable& edges, FaultCollector& faults,
                               const Parallel& parallel);

/// Loops of boundary edges. O(b log b) for b of them.
void find_loops(const GridMesh& mesh, const EdgeTable& edges, FaultCollector& faults, const Parallel& parallel);

/// Vertices whose triangles do not form one cone. O(n + s log s) for s faces around vertices without embedded stars.
void find_split_vertices(const GridMesh& mesh, const EmbeddedStars& stars, FaultCollector& faults, const Parallel& parallel);

/// Flipped faces and one-sided patches, once edge faults have been found. O(n), where any edge is mismatched.
void find_flipped_faces(const GridMesh& mesh, const EdgeTable& edges, FaultCollector& faults, const Parallel& parallel);

/// Faces that are bad by themselves, and faces on the same three vertices. O(n), one call of run().
void find_face_faults(const GridMesh& mesh, double sliver_ratio, FaultCollector& faults, const Parallel& parallel);

/// Fills in depth and parent of shells. Rays upwards from a few vertices of each count, exactly, how often each closed shell
/// winds around them; where a vertex lies on the other shell's surface, the next one is tried. Of `whole`, a shell is around
/// only if no face of the other crosses it and none of these vertices lies outside. Returns false where the work would have
/// exceeded search_budget().
bool nest_shells(const GridMesh& mesh, const FaceTree& tree, const Array<std::uint32_t>& shell_of,
                 std::vector<MeshShell>& shells, bool whole, const Parallel& parallel);

/// The shell of each face, and how many there are, numbered by their first faces. Five calls of run().
Array<std::uint32_t> join_shells(const GridMesh& mesh, const EdgeTable& edges, std::uint32_t& count,
                                 const Parallel& parallel);

/// Shells, their orientations and nesting, `whole` as for nest_shells(). Returns the shell of each face.
Array<std::uint32_t> find_shells(const GridMesh& mesh, const EdgeTable& edges, const FaceTree& tree,
                                 const FaultCollector& faults, MeshCheck& check, const Parallel& parallel,
                                 bool whole = false);

/// Pairs of faces that cross, overlap or touch. Returns for each shell 1 if it and another one are closed and meet, else 0.
/// The search itself leads the progress on to `progress`.
std::vector<std::uint8_t> find_meeting_faces(const GridMesh& mesh, const FaceTree& tree, const EmbeddedStars& stars,
                                             const Array<std::uint32_t>& shell_of, const std::vector<MeshShell>& shells,
                                             FaultCollector& faults, double progress, const Parallel& parallel);

/// True if the orientation contradicts the depth: outwards is right within an even number of others.
inline bool is_misoriented(const MeshShell& shell) noexcept {
    return shell.orientation != 0 && shell.orientation != (shell.depth % 2 == 0 ? 1 : -1);
}

/// Misoriented shells, where the depth is conclusive (shells.cpp).
void find_misoriented_shells(const std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& meets_other,
                             bool all_known, FaultCollector& faults);

/// T-junctions and cracks.
void find_gaps(const GridMesh& mesh, const EdgeTable& edges, double tolerance_mm, FaultCollector& faults,
               const Parallel& parallel);

}  // namespace lamella
