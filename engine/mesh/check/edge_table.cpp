#include "mesh/check/edge_table.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace lamella {

namespace {

constexpr std::size_t vertex_grain = 8192;

/// The upper vertex in the high half, the side in the low: sorting brings the sides of an edge together, ascending.
using Entry = std::uint64_t;

std::uint32_t upper_of(Entry entry) {
    return static_cast<std::uint32_t>(entry >> 32);
}

struct FaceSide {
    std::uint32_t lower;
    Entry entry;

    FaceSide(const Face& face, std::size_t number) {
        const auto [low, high] = std::minmax({face.corners[number % 3], face.corners[(number % 3 + 1) % 3]});
        lower = low;
        entry = Entry{high} << 32 | static_cast<std::uint32_t>(number);
    }
};

}  // namespace

EdgeTable::EdgeTable(const GridMesh& mesh, const Parallel& parallel) : mesh_(mesh) {
    const std::size_t count = 3 * mesh.faces.size();
    std::vector<std::uint32_t> firsts(mesh.vertices.size() + 2, 0);  // of the entries of a vertex, shifted by one to scatter
    for (std::size_t side = 0; side < count; ++side) {
        ++firsts[FaceSide(mesh.faces[side / 3], side).lower + 2];
    }
    for (std::size_t vertex = 2; vertex < firsts.size(); ++vertex) {
        firsts[vertex] += firsts[vertex - 1];
    }
    Array<Entry> entries;
    entries.resize_discarding(count);
    for (std::size_t side = 0; side < count; ++side) {
        const FaceSide at(mesh.faces[side / 3], side);
        entries[firsts[at.lower + 1]++] = at.entry;
    }
    parallel.run_ranges(mesh.vertices.size(), vertex_grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t vertex = begin; vertex != end; ++vertex) {
            std::sort(entries.begin() + firsts[vertex], entries.begin() + firsts[vertex + 1]);
        }
    });
    sides_.resize_discarding(count);
    edges_.resize_discarding(count + 1);
    std::size_t edges = 0;
    for (std::uint32_t vertex = 0; vertex < mesh.vertices.size(); ++vertex) {
        for (std::uint32_t i = firsts[vertex]; i < firsts[vertex + 1]; ++i) {
            if (i == firsts[vertex] || upper_of(entries[i]) != upper_of(entries[i - 1])) {
                edges_[edges++] = {vertex, upper_of(entries[i]), i};
            }
            sides_[i] = static_cast<std::uint32_t>(entries[i]);
        }
    }
    edges_[edges++] = {0, 0, static_cast<std::uint32_t>(count)};
    edges_.set_size(edges);
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
