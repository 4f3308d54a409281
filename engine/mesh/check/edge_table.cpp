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

/// The vertices of the edge on which a side lies, the lower first.
Ends ends_of(const GridMesh& mesh, std::uint32_t side) {
    const auto& corners = mesh.faces[side / 3].corners;
    const auto [lower, upper] = std::minmax(corners[side % 3], corners[(side % 3 + 1) % 3]);
    return {lower, upper};
}

/// Sorts the sides of a part; its memory is kept.
class SideSort {
public:
    explicit SideSort(const GridMesh& mesh) : mesh_(mesh) {}

    /// By lower vertex, then upper, then side. Returns the number of edges.
    std::size_t run(std::span<std::uint32_t> sides) {
        sides_.clear();
        for (const std::uint32_t side : sides) {
            sides_.push_back({ends_of(mesh_, side), side});
        }
        sort_.run(
            std::span<EdgeSide>(sides_), [](const EdgeSide& side) { return side.ends[0]; },
            [](const EdgeSide& a, const EdgeSide& b) {
                return a.ends[1] != b.ends[1] ? a.ends[1] < b.ends[1] : a.side < b.side;
            });
        std::size_t edges = 0;
        for (std::size_t i = 0; i < sides.size(); ++i) {
            edges += i == 0 || sides_[i].ends != sides_[i - 1].ends ? 1 : 0;
            sides[i] = sides_[i].side;
        }
        return edges;
    }

private:
    struct EdgeSide {
        Ends ends;
        std::uint32_t side;
    };

    const GridMesh& mesh_;
    std::vector<EdgeSide> sides_;
    PartSort<EdgeSide> sort_;
};

/// In parts of the order of lower vertices.
Distributed<std::uint32_t> distribute_sides(const GridMesh& mesh, const Parallel& parallel) {
    const std::size_t parts = parts_for(3 * mesh.faces.size(), sides_a_part);
    const std::size_t vertices = mesh.vertices.size();
    return distribute<std::uint32_t>(
        mesh.faces.size(), parts, parallel,
        [&, parts, vertices](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t f = begin; f != end; ++f) {
                const auto& corners = mesh.faces[f].corners;
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::uint32_t lower = std::min(corners[i], corners[i == 2 ? 0 : i + 1]);
                    emit(part_of_number(lower, vertices, parts), static_cast<std::uint32_t>(3 * f + i));
                }
            }
        },
        parallel.memory());
}

}  // namespace

EdgeTable::EdgeTable(const GridMesh& mesh, const Parallel& parallel)
    : mesh_(mesh), first_sides_(parallel.memory()), sides_(parallel.memory()), irregular_(parallel.memory()) {
    Distributed<std::uint32_t> parts = distribute_sides(mesh, parallel);
    std::vector<SideSort> workers(static_cast<std::size_t>(parallel.threads()), SideSort(mesh));
    std::vector<std::size_t> firsts(parts.size() + 1, 0);  // edges of a part, then the first of it
    parallel.run(parts.size(), [&](std::size_t part, int worker) {
        firsts[part + 1] = workers[static_cast<std::size_t>(worker)].run(parts.of(part));
    });
    for (std::size_t part = 0; part < parts.size(); ++part) {
        firsts[part + 1] += firsts[part];
    }
    first_sides_.resize_discarding(firsts.back() + 1);
    parallel.run(parts.size(), [&](std::size_t part, int) {
        std::size_t edge = firsts[part];
        Ends last{};  // no edge's: its ends differ
        for (std::size_t at = parts.firsts[part]; at != parts.firsts[part + 1]; ++at) {
            if (const Ends ends = ends_of(mesh, parts.items[at]); ends != std::exchange(last, ends)) {
                first_sides_[edge++] = static_cast<std::uint32_t>(at);
            }
        }
    });
    first_sides_[firsts.back()] = static_cast<std::uint32_t>(parts.items.size());
    sides_ = std::move(parts.items);
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
