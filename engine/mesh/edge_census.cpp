#include "mesh/edge_census.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "lamella/array.hpp"
#include "mesh/exact_reader.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/grid/vertex_hash.hpp"

namespace lamella {

namespace {

// Every triangle side is noted by its number alone (3 * triangle + corner), in the partition that the hash of its edge
// gives: count, prefix sum, scatter. All sides of an edge then lie in one partition, which is small enough to be counted in
// a hash map that stays in cache; its keys are read from the mesh again, so that no rounded copy of it is stored.

constexpr std::size_t sides_per_partition = std::size_t{1} << 15;
constexpr std::size_t most_partitions = std::size_t{1} << 14;
constexpr std::size_t most_in_range = std::size_t{1} << 18;  ///< triangles

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
        : reader_(reader), exact_(exact), triangles_(triangles), parallel_(parallel), shells_(triangles) {
        // Two at least, as a hash cannot be shifted by all of its bits.
        const std::size_t wanted = std::bit_ceil(3 * triangles / sides_per_partition + 2);
        partitions_ = std::min(wanted, most_partitions);
        partition_bits_ = std::countr_zero(partitions_);
        ranges_ = std::max(static_cast<std::size_t>(parallel.threads()) * 4, triangles / most_in_range + 1);
    }

    EdgeCensus run() {
        count_sides();
        scatter_sides();
        EdgeCensus census = count_partitions();
        census.degenerate = degenerate_;
        census.shells = count_shells();
        return census;
    }

private:
    struct Edge {
        MeshEdge edge;
        Index forward = 0;
        Index backward = 0;
        Index triangle = 0;
        std::uint64_t exact = 0;  ///< of the first side
        bool joined = false;      ///< some other side has other ends, as the coordinates are
    };

    struct Scratch {
        Array<Edge> edges;
        Array<std::uint32_t> slots;  ///< open addressing: 1 + index into edges, or 0
        EdgeCensus census;
    };

    /// By the hash's highest bits; the slots within a partition are taken by those after them.
    std::size_t partition_of(const Side& side) const { return side.edge.hash() >> (64 - partition_bits_); }

    Side side_of(std::size_t side) const {
        const GridTriangle triangle = reader_(side / 3);
        return {triangle[side % 3], triangle[(side % 3 + 1) % 3]};
    }

    /// A hash of the side's ends as they are, in either order.
    std::uint64_t exact_ends(std::size_t side) const {
        const GridTriangle triangle = exact_(side / 3);
        return hash_of(triangle[side % 3]) + hash_of(triangle[(side % 3 + 1) % 3]);
    }

    /// Calls visit(triangle, three sides) for what is not degenerate, skip(triangle) for the rest.
    template <class Visit, class Skip>
    void each_triangle(std::size_t range, Visit visit, Skip skip) const {
        const std::size_t end = triangles_ * (range + 1) / ranges_;
        for (std::size_t t = triangles_ * range / ranges_; t != end; ++t) {
            const GridTriangle triangle = reader_(t);
            const auto& [a, b, c] = triangle;
            if (is_degenerate(triangle)) {
                skip(t);
            } else {
                visit(t, std::array<Side, 3>{Side{a, b}, Side{b, c}, Side{c, a}});
            }
        }
    }

    void count_sides() {
        cursors_.assign(ranges_ * partitions_, 0);
        std::vector<std::uint64_t> degenerate(ranges_, 0);
        parallel_.run(ranges_, [&](std::size_t range, int) {
            std::size_t* counts = cursors_.data() + range * partitions_;
            each_triangle(
                range,
                [&](std::size_t t, const std::array<Side, 3>& sides) {
                    shells_.set_alone(t);
                    for (const Side& side : sides) {
                        ++counts[partition_of(side)];
                    }
                },
                [&](std::size_t t) {
                    shells_.leave_out(t);
                    ++degenerate[range];
                });
        });
        for (const std::uint64_t count : degenerate) {
            degenerate_ += count;
        }
    }

    void scatter_sides() {
        firsts_.assign(partitions_ + 1, 0);
        std::size_t sum = 0;
        for (std::size_t partition = 0; partition < partitions_; ++partition) {
            firsts_[partition] = sum;
            for (std::size_t range = 0; range < ranges_; ++range) {
                sum += std::exchange(cursors_[range * partitions_ + partition], sum);
            }
        }
        firsts_[partitions_] = sum;
        assert(sum == 3 * (triangles_ - degenerate_));
        sides_.resize_discarding(sum);
        parallel_.run(ranges_, [&](std::size_t range, int) {
            std::size_t* cursors = cursors_.data() + range * partitions_;
            each_triangle(
                range,
                [&](std::size_t t, const std::array<Side, 3>& sides) {
                    for (std::size_t corner = 0; corner < 3; ++corner) {
                        sides_[cursors[partition_of(sides[corner])]++] = static_cast<Index>(3 * t + corner);
                    }
                },
                [](std::size_t) {});
        });
    }

    std::uint64_t count_shells() const {
        std::atomic<std::uint64_t> shells = 0;
        parallel_.run_ranges(triangles_, std::size_t{1} << 14, [&](std::size_t begin, std::size_t end, int) {
            std::uint64_t own = 0;
            for (std::size_t t = begin; t != end; ++t) {
                own += shells_.is_root(t) ? 1 : 0;
            }
            shells += own;
        });
        return shells;
    }

    EdgeCensus count_partitions() {
        std::vector<Scratch> scratch(static_cast<std::size_t>(parallel_.threads()));
        parallel_.run(partitions_, [&](std::size_t partition, int worker) {
            Scratch& own = scratch[static_cast<std::size_t>(worker)];
            const std::size_t distinct = link_partition(partition, own);
            for (std::size_t e = 0; e < distinct; ++e) {
                tally(own.edges[e], own.census);
            }
        });
        EdgeCensus total;
        for (const Scratch& own : scratch) {
            total.edges += own.census.edges;
            total.boundary += own.census.boundary;
            total.overfull += own.census.overfull;
            total.mismatched += own.census.mismatched;
            total.unbalanced += own.census.unbalanced;
            total.joined += own.census.joined;
        }
        return total;
    }

    /// Gathers the partition's sides into own.edges and unites the triangles that meet; the number of edges.
    std::size_t link_partition(std::size_t partition, Scratch& own) {
        const std::span<const Index> sides =
            std::span<const Index>(sides_.span()).subspan(firsts_[partition], firsts_[partition + 1] - firsts_[partition]);
        own.edges.resize_discarding(sides.size());
        own.slots.resize_discarding(std::bit_ceil(2 * sides.size() + 1));
        std::fill(own.slots.begin(), own.slots.end(), 0U);
        std::uint32_t distinct = 0;
        for (const Index number : sides) {
            const Side side = side_of(number);
            const Index triangle = static_cast<Index>(number / 3);
            std::uint32_t& slot = find(side.edge, own);
            const std::uint64_t exact = exact_ends(number);
            if (slot == 0) {
                own.edges[distinct] = {side.edge, 0, 0, triangle, exact, false};
                slot = ++distinct;
            }
            Edge& edge = own.edges[slot - 1];
            edge.joined = edge.joined || edge.exact != exact;
            ++(side.forward ? edge.forward : edge.backward);
            shells_.unite(edge.triangle, triangle);
        }
        return distinct;
    }

    /// The slot of the edge, or the free one where it belongs.
    std::uint32_t& find(const MeshEdge& edge, Scratch& own) const {
        const std::size_t mask = own.slots.size() - 1;
        const std::uint64_t within = edge.hash() << partition_bits_;
        for (std::size_t slot = within >> (64 - std::countr_zero(own.slots.size()));; slot = (slot + 1) & mask) {
            const std::uint32_t entry = own.slots[slot];
            if (entry == 0 || own.edges[entry - 1].edge == edge) {
                return own.slots[slot];
            }
        }
    }

    static void tally(const Edge& edge, EdgeCensus& census) {
        const std::uint64_t faces = std::uint64_t{edge.forward} + edge.backward;
        const bool balanced = edge.forward == edge.backward;
        ++census.edges;
        census.boundary += faces == 1 ? 1 : 0;
        census.overfull += faces > 2 ? 1 : 0;
        census.mismatched += faces == 2 && !balanced ? 1 : 0;
        census.unbalanced += balanced ? 0 : 1;
        census.joined += edge.joined ? 1 : 0;
    }

    Reader reader_;
    ExactReader exact_;
    std::size_t triangles_;
    const Parallel& parallel_;
    SharedSets<Index> shells_;  ///< triangles, united over edges
    std::size_t partitions_ = 2;
    int partition_bits_ = 1;
    std::size_t ranges_ = 1;
    std::uint64_t degenerate_ = 0;
    std::vector<std::size_t> cursors_;  ///< per range and partition: first a count, then where the next side goes
    std::vector<std::size_t> firsts_;   ///< per partition, into sides_
    Array<Index> sides_;
};

template <class Reader>
EdgeCensus census_of(const Reader& reader, const MeshView& mesh, const Parallel& parallel) {
    const ExactReader exact(mesh);
    if (mesh.triangle_count < std::numeric_limits<std::uint32_t>::max() / 3) {
        return Census<std::uint32_t, Reader>(reader, exact, mesh.triangle_count, parallel).run();
    }
    return Census<std::uint64_t, Reader>(reader, exact, mesh.triangle_count, parallel).run();
}

}  // namespace

EdgeCensus count_edges(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel) {
    EdgeCensus census =
        with_reader(mesh, transform, unit_mm, [&](const auto& reader) { return census_of(reader, mesh, parallel); });
    // Where the sides at every edge have the same ends, edges are the same with and without the grid.
    const bool same = census.joined == 0 && census.degenerate == 0;
    census.exact_boundary = same ? census.boundary : count_exact_boundary(mesh, parallel);
    return census;
}

std::uint64_t count_exact_boundary(const MeshView& mesh, const Parallel& parallel) {
    return census_of(ExactReader(mesh), mesh, parallel).boundary;
}

}  // namespace lamella
