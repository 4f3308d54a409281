#include "mesh/check/edge_table.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

#include "base/distribute.hpp"

namespace lamella {

namespace {

constexpr std::size_t sides_a_part = std::size_t{1} << 14;

using Ends = std::array<std::uint32_t, 2>;

struct EdgeSide {
    Ends ends;
    std::uint32_t side;
};

/// The vertices of the edge on which a side lies, the lower first.
Ends ends_of(const GridMesh& mesh, std::uint32_t side) {
    const auto& corners = mesh.faces[side / 3].corners;
    const auto [lower, upper] = std::minmax(corners[side % 3], corners[(side % 3 + 1) % 3]);
    return {lower, upper};
}

/// By lower vertex, then upper, then side.
Array<EdgeSide> sorted_sides(const GridMesh& mesh, const Parallel& parallel) {
    const std::size_t vertices = mesh.vertices.size();
    const std::size_t count = parts_for(3 * mesh.faces.size(), sides_a_part);
    Distributed<EdgeSide> parts = distribute<EdgeSide>(
        mesh.faces.size(), count, parallel,
        [&](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t side = 3 * begin; side != 3 * end; ++side) {
                const auto number = static_cast<std::uint32_t>(side);
                const Ends ends = ends_of(mesh, number);
                emit(part_of_number(ends[0], vertices, count), EdgeSide{ends, number});
            }
        },
        parallel.memory());
    std::vector<PartSort<EdgeSide>> workers(static_cast<std::size_t>(parallel.threads()));
    parallel.run(parts.size(), [&](std::size_t part, int worker) {
        workers[static_cast<std::size_t>(worker)].run(
            parts.of(part), [](const EdgeSide& side) { return side.ends[0]; },
            [](const EdgeSide& a, const EdgeSide& b) {
                return a.ends[1] != b.ends[1] ? a.ends[1] < b.ends[1] : a.side < b.side;
            });
    });
    return std::move(parts.items);
}

}  // namespace

EdgeTable::EdgeTable(const GridMesh& mesh, const Parallel& parallel)
    : mesh_(mesh), first_sides_(parallel.memory()), sides_(parallel.memory()), irregular_(parallel.memory()) {
    const Array<EdgeSide> sorted = sorted_sides(mesh, parallel);
    sides_.resize_discarding(sorted.size());
    number_where(
        sorted.size(), parallel, [&](std::size_t i) { return i == 0 || sorted[i].ends != sorted[i - 1].ends; },
        [&](std::size_t count) { first_sides_.resize_discarding(count + 1); },
        [&](std::size_t i, std::uint32_t edge, bool is_first) {
            sides_[i] = sorted[i].side;
            if (is_first) {
                first_sides_[edge] = static_cast<std::uint32_t>(i);
            }
        });
    first_sides_[size()] = static_cast<std::uint32_t>(sorted.size());
    irregular_ = indices_where(size(), parallel, parallel.memory(),
                               [&](std::size_t edge) { return sides(edge).size() != 2 || !is_balanced(edge); });
    std::copy_if(irregular_.begin(), irregular_.end(), std::back_inserter(boundary_),
                 [&](std::uint32_t edge) { return sides(edge).size() == 1; });
}

EdgeTable::Edge EdgeTable::operator[](std::size_t edge) const noexcept {
    const auto [lower, upper] = ends_of(mesh_, sides_[first_sides_[edge]]);
    return {lower, upper};
}

bool EdgeTable::joins(std::uint32_t a, std::uint32_t b) const noexcept {
    const Ends wanted = {std::min(a, b), std::max(a, b)};
    const auto ends_at = [&](std::uint32_t first_side) { return ends_of(mesh_, sides_[first_side]); };
    const std::uint32_t* const end = first_sides_.begin() + size();
    const std::uint32_t* const found =
        std::partition_point(first_sides_.begin(), end, [&](std::uint32_t first) { return ends_at(first) < wanted; });
    return found != end && ends_at(*found) == wanted;
}

}  // namespace lamella
