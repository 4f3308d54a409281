// Counts the edges of a mesh by the faces that meet there.
#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <span>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/distribute.hpp"
#include "base/number_table.hpp"
#include "mesh/measure.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/grid/vertex_hash.hpp"

namespace lamella {

namespace {

// Every triangle side is noted by its number alone (3 * triangle + corner), in the partition that the hash of its edge
// gives. All sides of an edge then lie in one partition, which is small enough to be counted in a hash map that stays in
// cache; its keys are read from the mesh again, so that no rounded copy of it is stored.

constexpr std::size_t sides_per_partition = std::size_t{1} << 15;
constexpr std::size_t most_partitions = std::size_t{1} << 14;

/// Edges, counted by the faces at each.
struct Counts {
    std::uint64_t edges = 0;
    std::uint64_t boundary = 0;
    std::uint64_t overfull = 0;
    std::uint64_t mismatched = 0;
    std::uint64_t unbalanced = 0;  ///< edges with more faces one way than the other
    std::uint64_t joined = 0;      ///< edges of the grid that stand for several ones

    void add(const Counts& other) noexcept {
        edges += other.edges;
        boundary += other.boundary;
        overfull += other.overfull;
        mismatched += other.mismatched;
        unbalanced += other.unbalanced;
        joined += other.joined;
    }
};

/// A side's edge, and whether the side runs from the edge's lower end to its upper.
struct Side {
    MeshEdge edge;
    bool forward;

    Side(const GridVertex& from, const GridVertex& to)
        : edge(MeshEdge::between(std::min(from, to), std::max(from, to))), forward(from < to) {}
};

template <class Index, class Reader>
class Census {
public:
    Census(const Reader& reader, const ExactReader& exact, std::size_t triangles, const Parallel& parallel)
        : reader_(reader), exact_(exact), triangles_(triangles), parallel_(parallel), shells_(triangles, parallel, nullptr) {
        // Two at least, as a hash cannot be shifted by all of its bits.
        const std::size_t wanted = std::bit_ceil(3 * triangles / sides_per_partition + 2);
        partition_bits_ = std::countr_zero(std::min(wanted, most_partitions));
    }

    Counts run() {
        Distributed<Index> sides = partition_sides();
        degenerate_ = triangles_ - sides.items.size() / 3;
        return count_partitions(sides);
    }

    std::uint64_t degenerate() const noexcept { return degenerate_; }

    std::uint64_t shells() const {
        std::atomic<std::uint64_t> roots = 0;
        parallel_.run_ranges(triangles_, std::size_t{1} << 14, [&](std::size_t begin, std::size_t end, int) {
            std::uint64_t own = 0;
            for (std::size_t t = begin; t != end; ++t) {
                own += shells_.is_root(t) ? 1 : 0;
            }
            roots += own;
        });
        return roots - degenerate_;  // each of which is alone
    }

private:
    struct Edge {
        MeshEdge edge;
        Index forward = 0;
        Index backward = 0;
        Index triangle = 0;
        std::uint64_t exact = 0;  ///< hash of the first side's ends
        bool joined = false;      ///< some other side has other ends, as the coordinates are
    };

    struct Scratch {
        std::vector<Edge> edges;  ///< in a partition
        NumberTable numbers;
        Counts counts;
    };

    static Side side_of(const GridTriangle& triangle, std::size_t corner) {
        return {triangle[corner], triangle[(corner + 1) % 3]};
    }

    /// Without the bits by which partitions are chosen.
    std::uint64_t hash_within(const MeshEdge& edge) const { return edge.hash() << partition_bits_; }

    /// By the highest bits of their edges' hashes.
    Distributed<Index> partition_sides() const {
        const auto emit_sides = [this](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t t = begin; t != end; ++t) {
                const GridTriangle triangle = reader_(t);
                if (is_degenerate(triangle)) {
                    continue;
                }
                for (std::size_t i = 0; i < 3; ++i) {
                    emit(side_of(triangle, i).edge.hash() >> (64 - partition_bits_), static_cast<Index>(3 * t + i));
                }
            }
        };
        return distribute<Index>(triangles_, std::size_t{1} << partition_bits_, parallel_, emit_sides);
    }

    /// A hash of the side's ends as they are, in either order.
    std::uint64_t exact_ends(std::size_t side) const {
        const GridTriangle triangle = exact_(side / 3);
        return hash_of(triangle[side % 3]) + hash_of(triangle[(side % 3 + 1) % 3]);
    }

    Counts count_partitions(Distributed<Index>& sides) {
        std::vector<Scratch> scratch(static_cast<std::size_t>(parallel_.threads()));
        parallel_.run(sides.size(), [&](std::size_t partition, int worker) {
            Scratch& own = scratch[static_cast<std::size_t>(worker)];
            link(sides.of(partition), own);
            for (const Edge& edge : own.edges) {
                tally(edge, own.counts);
            }
        });
        Counts total;
        for (const Scratch& own : scratch) {
            total.add(own.counts);
        }
        return total;
    }

    /// Gathers the sides of a partition into own.edges and unites the triangles that meet.
    void link(std::span<const Index> sides, Scratch& own) {
        own.edges.clear();
        own.numbers.clear(sides.size());
        for (const Index number : sides) {
            const Side side = side_of(reader_(number / 3), number % 3);
            const Index triangle = static_cast<Index>(number / 3);
            const std::uint64_t exact = exact_ends(number);
            const std::uint32_t found = own.numbers.number(
                hash_within(side.edge), [&](std::uint32_t i) { return own.edges[i].edge == side.edge; },
                [&](std::uint32_t i) { return hash_within(own.edges[i].edge); });
            if (found == own.edges.size()) {
                own.edges.push_back({side.edge, 0, 0, triangle, exact, false});
            }
            Edge& edge = own.edges[found];
            edge.joined = edge.joined || edge.exact != exact;
            ++(side.forward ? edge.forward : edge.backward);
            shells_.unite(edge.triangle, triangle);
        }
    }

    static void tally(const Edge& edge, Counts& counts) {
        const std::uint64_t faces = std::uint64_t{edge.forward} + edge.backward;
        const bool balanced = edge.forward == edge.backward;
        ++counts.edges;
        counts.boundary += faces == 1 ? 1 : 0;
        counts.overfull += faces > 2 ? 1 : 0;
        counts.mismatched += faces == 2 && !balanced ? 1 : 0;
        counts.unbalanced += balanced ? 0 : 1;
        counts.joined += edge.joined ? 1 : 0;
    }

    Reader reader_;
    ExactReader exact_;
    std::size_t triangles_;
    const Parallel& parallel_;
    SharedSets<Index> shells_;  ///< triangles, united over edges
    int partition_bits_ = 1;
    std::uint64_t degenerate_ = 0;
};

/// Calls use(census) with indices as wide as the mesh needs.
template <class Reader, class Use>
void with_census(const Reader& reader, const MeshView& mesh, const Parallel& parallel, const Use& use) {
    const ExactReader exact(mesh);
    if (mesh.triangle_count < std::numeric_limits<std::uint32_t>::max() / 3) {
        use(Census<std::uint32_t, Reader>(reader, exact, mesh.triangle_count, parallel));
    } else {
        use(Census<std::uint64_t, Reader>(reader, exact, mesh.triangle_count, parallel));
    }
}

}  // namespace

void count_edges(const MeshView& mesh, const Frame& frame, const Parallel& parallel, MeshCheck& check) {
    const auto fill_in = [&](auto&& census) {
        const Counts counts = census.run();
        check.degenerate = census.degenerate();
        check.edges = counts.edges;
        check.boundary_edges = counts.boundary;
        check.overfull_edges = counts.overfull;
        check.mismatched_edges = counts.mismatched;
        check.shell_count = census.shells();
        check.closed = counts.edges > 0 && counts.unbalanced == 0;
        // Where the sides at every edge have the same ends, edges are the same with and without the grid.
        const bool same = counts.joined == 0 && check.degenerate == 0;
        check.exact_boundary_edges = same ? counts.boundary : count_exact_boundary(mesh, parallel);
    };
    with_reader(mesh, placing_of(mesh, frame), check.grid_mm,
                [&](const auto& reader) { with_census(reader, mesh, parallel, fill_in); });
}

std::uint64_t count_exact_boundary(const MeshView& mesh, const Parallel& parallel) {
    std::uint64_t boundary = 0;
    with_census(ExactReader(mesh), mesh, parallel, [&](auto&& census) { boundary = census.run().boundary; });
    return boundary;
}

}  // namespace lamella
