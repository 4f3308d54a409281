#include "mesh/check/edge_table.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "base/distribute.hpp"

namespace lamella {

namespace {

constexpr std::size_t sides_a_part = std::size_t{1} << 14;

/// A side of a face, by the edge on which it lies.
struct EdgeSide {
    std::uint32_t lower;
    std::uint32_t upper;
    std::uint32_t side;
};

/// Sorts the sides of a part by lower vertex, then upper, then side. Returns the number of edges.
std::size_t sort_sides(std::span<EdgeSide> sides, PartSort<EdgeSide>& sort) {
    sort.run(
        sides, [](const EdgeSide& side) { return side.lower; },
        [](const EdgeSide& a, const EdgeSide& b) { return a.upper != b.upper ? a.upper < b.upper : a.side < b.side; });
    std::size_t edges = sides.empty() ? 0 : 1;
    for (std::size_t i = 1; i < sides.size(); ++i) {
        edges += sides[i].lower != sides[i - 1].lower || sides[i].upper != sides[i - 1].upper ? 1 : 0;
    }
    return edges;
}

Distributed<EdgeSide> distribute_sides(const GridMesh& mesh, const Parallel& parallel) {
    const std::size_t parts = parts_for(3 * mesh.faces.size(), sides_a_part);
    const std::size_t vertices = mesh.vertices.size();
    return distribute<EdgeSide>(
        mesh.faces.size(), parts, parallel, [&, parts, vertices](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t f = begin; f != end; ++f) {
                const auto& corners = mesh.faces[f].corners;
                for (std::size_t i = 0; i < 3; ++i) {
                    const auto [low, high] = std::minmax(corners[i], corners[i == 2 ? 0 : i + 1]);
                    emit(part_of_number(low, vertices, parts), EdgeSide{low, high, static_cast<std::uint32_t>(3 * f + i)});
                }
            }
        },
        mesh.memory);
}

}  // namespace

EdgeTable::EdgeTable(const GridMesh& mesh, const Parallel& parallel)
    : mesh_(mesh), edges_(mesh.memory), sides_(mesh.memory), irregular_(mesh.memory) {
    Distributed<EdgeSide> sides = distribute_sides(mesh, parallel);
    std::vector<PartSort<EdgeSide>> workers(static_cast<std::size_t>(parallel.threads()));
    std::vector<std::size_t> firsts(sides.size() + 1, 0);  // edges of a part, then the first of it
    parallel.run(sides.size(), [&](std::size_t part, int worker) {
        firsts[part + 1] = sort_sides(sides.of(part), workers[static_cast<std::size_t>(worker)]);
    });
    for (std::size_t part = 0; part < sides.size(); ++part) {
        firsts[part + 1] += firsts[part];
    }
    sides_.resize_discarding(sides.items.size());
    edges_.resize_discarding(firsts.back() + 1);
    parallel.run(sides.size(), [&](std::size_t part, int) {
        std::size_t edge = firsts[part];
        const EdgeSide* last = nullptr;
        for (const EdgeSide& side : sides.of(part)) {
            const auto at = static_cast<std::uint32_t>(&side - sides.items.data());
            if (last == nullptr || last->lower != side.lower || last->upper != side.upper) {
                edges_[edge++] = {side.lower, side.upper, at};
            }
            sides_[at] = side.side;
            last = &side;
        }
    });
    edges_[firsts.back()] = {0, 0, static_cast<std::uint32_t>(sides.items.size())};
    irregular_ = indices_where(size(), parallel, mesh.memory,
                               [&](std::size_t edge) { return this->sides(edge).size() != 2 || !is_balanced(edge); });
    std::copy_if(irregular_.begin(), irregular_.end(), std::back_inserter(boundary_),
                 [&](std::uint32_t edge) { return this->sides(edge).size() == 1; });
}

std::size_t EdgeTable::forward_count(std::size_t edge) const noexcept {
    const std::span<const std::uint32_t> own = sides(edge);
    return static_cast<std::size_t>(
        std::count_if(own.begin(), own.end(), [&](std::uint32_t side) { return is_forward(side); }));
}

bool EdgeTable::joins(std::uint32_t a, std::uint32_t b) const noexcept {
    const std::pair<std::uint32_t, std::uint32_t> wanted = std::minmax(a, b);
    const Edge* const end = edges_.end() - 1;
    const Edge* const found = std::lower_bound(edges_.begin(), end, wanted, [](const Edge& edge, const auto& key) {
        return std::pair(edge.lower, edge.upper) < key;
    });
    return found != end && std::pair(found->lower, found->upper) == wanted;
}

}  // namespace lamella
