#include "mesh/check/vertex_numbers.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <functional>
#include <vector>

#include "base/distribute.hpp"
#include "base/mixed.hpp"
#include "base/parallel_sort.hpp"
#include "mesh/check/morton.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/grid/vertex_hash.hpp"

namespace lamella {

namespace {

constexpr std::size_t corners_a_part = std::size_t{1} << 15;

struct Corner {
    GridVertex vertex;
    std::uint32_t exact;   ///< a hash of its coordinates as they are; then its number among the part's vertices
    std::uint32_t number;  ///< 3 * triangle + corner
};

std::uint32_t hash_of_exact(const double* xyz) {
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double positive = xyz[axis] + 0.0;  // makes a positive zero of a negative one
        hash = (std::rotl(hash, 23) ^ std::bit_cast<std::uint64_t>(positive)) * 0x9E3779B97F4A7C15U;
    }
    return static_cast<std::uint32_t>(hash >> 32);
}

Distributed<Corner> distribute_corners(const MeshView& mesh, const Transform& transform, double unit_mm,
                                       const MortonOrder& order, const Parallel& parallel, const Memory* memory) {
    return with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        const std::size_t corners = 3 * mesh.triangle_count;
        const Splitters<std::uint64_t, std::less<>> splitters(corners, parts_for(corners, corners_a_part), std::less<>{},
                                                              [&](std::size_t i) { return order.key(read(i / 3)[i % 3]); });
        const RawReader exact(mesh);
        return distribute<Corner>(
            mesh.triangle_count, splitters.parts(), parallel, [&](std::size_t begin, std::size_t end, const auto& emit) {
                for (std::size_t t = begin; t != end; ++t) {
                    const GridTriangle triangle = read(t);
                    const RawTriangle raw = exact(t);
                    for (std::size_t i = 0; i < 3; ++i) {
                        emit(splitters.part_of(order.key(triangle[i])),
                             Corner{triangle[i], hash_of_exact(raw.v + 3 * i), static_cast<std::uint32_t>(3 * t + i)});
                    }
                }
            },
            memory);
    });
}

/// Numbers the vertices of one part after another; its memory is kept.
class PartNumbers {
public:
    explicit PartNumbers(const MortonOrder& order) : order_(order) {}

    /// Leaves each corner its vertex's rank in `exact`, and the vertices in `vertices`; true if some corners were joined.
    bool run(std::span<Corner> corners, std::vector<GridVertex>& vertices) {
        bool joined = false;
        found_.clear();
        slots_.assign(std::bit_ceil(2 * corners.size() + 1), 0);
        for (Corner& corner : corners) {
            std::uint32_t& slot = find(corner.vertex);
            if (slot == 0) {
                found_.push_back(
                    {order_.key(corner.vertex), corner.vertex, corner.exact, static_cast<std::uint32_t>(found_.size())});
                slot = static_cast<std::uint32_t>(found_.size());
            }
            joined = joined || found_[slot - 1].exact != corner.exact;
            corner.exact = slot - 1;
        }
        std::sort(found_.begin(), found_.end(),
                  [](const Found& a, const Found& b) { return a.key != b.key ? a.key < b.key : a.vertex < b.vertex; });
        ranks_.resize(found_.size());
        vertices.resize(found_.size());
        for (std::uint32_t rank = 0; rank < found_.size(); ++rank) {
            ranks_[found_[rank].first] = rank;
            vertices[rank] = found_[rank].vertex;
        }
        for (Corner& corner : corners) {
            corner.exact = ranks_[corner.exact];
        }
        return joined;
    }

private:
    struct Found {
        std::uint64_t key;
        GridVertex vertex;
        std::uint32_t exact;
        std::uint32_t first;  ///< the order in which they came
    };

    /// The slot of the vertex, or the free one where it belongs. Before sorting.
    std::uint32_t& find(const GridVertex& vertex) {
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t slot = hash_of(vertex) & mask;; slot = (slot + 1) & mask) {
            if (slots_[slot] == 0 || found_[slots_[slot] - 1].vertex == vertex) {
                return slots_[slot];
            }
        }
    }

    MortonOrder order_;
    std::vector<Found> found_;
    std::vector<std::uint32_t> slots_;  ///< open addressing: 1 + index into found_, or 0
    std::vector<std::uint32_t> ranks_;
};

}  // namespace

VertexNumbers number_vertices(const MeshView& mesh, const Transform& transform, const MeshInfo& info,
                              const Parallel& parallel, const Memory* memory) {
    const MortonOrder order(info);
    Distributed<Corner> corners = distribute_corners(mesh, transform, info.unit_mm, order, parallel, memory);
    std::vector<std::vector<GridVertex>> vertices(corners.size());
    std::vector<PartNumbers> workers(static_cast<std::size_t>(parallel.threads()), PartNumbers(order));
    std::atomic<bool> joined = false;
    parallel.run(corners.size(), [&](std::size_t part, int worker) {
        if (workers[static_cast<std::size_t>(worker)].run(corners.of(part), vertices[part])) {
            joined.store(true, std::memory_order_relaxed);
        }
    });
    std::vector<std::uint32_t> firsts(corners.size() + 1, 0);
    for (std::size_t part = 0; part < corners.size(); ++part) {
        firsts[part + 1] = firsts[part] + static_cast<std::uint32_t>(vertices[part].size());
    }
    VertexNumbers numbers{Array<GridVertex>(memory), Array<std::uint32_t>(memory), joined};
    numbers.vertices.resize_discarding(firsts.back());
    numbers.of_corners.resize_discarding(corners.items.size());
    parallel.run(corners.size(), [&](std::size_t part, int) {
        std::copy(vertices[part].begin(), vertices[part].end(), numbers.vertices.begin() + firsts[part]);
        for (const Corner& corner : corners.of(part)) {
            numbers.of_corners[corner.number] = firsts[part] + corner.exact;
        }
    });
    return numbers;
}

}  // namespace lamella
