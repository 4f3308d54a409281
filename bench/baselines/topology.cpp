#include "topology.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <span>

#include "geometry.hpp"
#include "slicing/contours/slot_table.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella::baselines {

namespace {

/// Open addressing, at most half full.
class VertexTable {
public:
    VertexTable(std::vector<GridVertex>& vertices, std::size_t at_most)
        : vertices_(vertices), slots_(std::bit_ceil(2 * at_most + 1), no_vertex) {}

    std::uint32_t find_or_add(const GridVertex& vertex) {
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t i = hash_of(vertex) & mask;; i = (i + 1) & mask) {
            if (slots_[i] == no_vertex) {
                slots_[i] = static_cast<std::uint32_t>(vertices_.size());
                vertices_.push_back(vertex);
                return slots_[i];
            }
            if (vertices_[slots_[i]] == vertex) {
                return slots_[i];
            }
        }
    }

    bool is_half_full() const noexcept { return 2 * vertices_.size() >= slots_.size(); }

    void double_size() {
        slots_.assign(2 * slots_.size(), no_vertex);
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t v = 0; v < vertices_.size(); ++v) {
            std::size_t i = hash_of(vertices_[v]) & mask;
            while (slots_[i] != no_vertex) {
                i = (i + 1) & mask;
            }
            slots_[i] = static_cast<std::uint32_t>(v);
        }
    }

private:
    static constexpr std::uint32_t no_vertex = 0xFFFFFFFF;
    std::vector<GridVertex>& vertices_;
    std::vector<std::uint32_t> slots_;
};

/// Returns false if a half-edge of this edge has no partner of opposite direction.
bool pair_one_edge(const SharedVertices& mesh, std::span<const std::uint32_t> edge, std::vector<std::uint32_t>& twins) {
    const auto pair = [&](std::uint32_t a, std::uint32_t b) {
        twins[a] = b;
        twins[b] = a;
        return mesh.from(a) == mesh.to(b);
    };
    if (edge.size() == 2) {
        return pair(edge[0], edge[1]);
    }
    return edge.size() % 2 == 0 &&
           std::ranges::all_of(pair_round_edge(mesh, edge), [&](const auto& two) { return pair(two.first, two.second); });
}

}  // namespace

SharedVertices share_vertices_by_tree(const std::vector<Facet>& facets) {
    SharedVertices mesh;
    mesh.facets.reserve(facets.size());
    std::map<GridVertex, std::uint32_t> tree;
    for (const Facet& facet : facets) {
        Corners& corners = mesh.facets.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [found, is_new] = tree.try_emplace(facet[i], static_cast<std::uint32_t>(mesh.vertices.size()));
            if (is_new) {
                mesh.vertices.push_back(facet[i]);
            }
            corners[i] = found->second;
        }
    }
    return mesh;
}

SharedVertices share_vertices_by_hash(const std::vector<Facet>& facets) {
    SharedVertices mesh;
    mesh.facets.reserve(facets.size());
    mesh.vertices.reserve(facets.size() / 2 + 2);  // the number of vertices of a closed mesh without handles
    VertexTable table(mesh.vertices, mesh.vertices.capacity());
    for (const Facet& facet : facets) {
        Corners& corners = mesh.facets.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) {
            corners[i] = table.find_or_add(facet[i]);
        }
        if (table.is_half_full()) {
            table.double_size();
        }
    }
    return mesh;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> pair_round_edge(const SharedVertices& mesh,
                                                                     std::span<const std::uint32_t> edge) {
    const GridVertex& a = mesh.vertices[mesh.from(edge[0])];
    const GridVertex& b = mesh.vertices[mesh.to(edge[0])];
    // No plane cuts a level edge, so its order does not matter.
    const auto [lower, upper] = a.z < b.z ? std::pair(a, b) : std::pair(b, a);
    std::vector<FaceAtEdge> faces;
    for (const std::uint32_t h : edge) {
        const bool runs_down = mesh.vertices[mesh.from(h)] == upper;  // the facet's segment begins on this edge
        faces.push_back({mesh.vertices[mesh.to(next_in_facet(h))], h, {h, runs_down}});
    }
    sort_round_edge(lower, upper, faces);
    std::vector<MeetingEnd> ends;
    ends.reserve(faces.size());
    for (const FaceAtEdge& face : faces) {
        ends.push_back(face.end);
    }
    Pairing pairing(nullptr);
    pairing.match(ends);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const auto& [in, out] : pairing.pairs()) {
        pairs.emplace_back(ends[in].link, ends[out].link);
    }
    return pairs;
}

std::vector<std::uint32_t> find_twins(const SharedVertices& mesh) {
    const auto half_edges = static_cast<std::uint32_t>(3 * mesh.facets.size());
    Groups by_lesser =
        grouped(half_edges, mesh.vertices.size(), [&](std::uint32_t h) { return std::min(mesh.from(h), mesh.to(h)); });
    std::vector<std::uint32_t> twins(half_edges, no_half_edge);
    const auto greater = [&](std::uint32_t h) { return std::max(mesh.from(h), mesh.to(h)); };
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const std::span<std::uint32_t> bucket = by_lesser.of(v);  // usually about six half-edges, two for each edge
        std::ranges::sort(bucket, {}, greater);
        for (std::size_t begin = 0; begin < bucket.size();) {
            std::size_t end = begin + 1;
            while (end < bucket.size() && greater(bucket[end]) == greater(bucket[begin])) {
                ++end;
            }
            if (!pair_one_edge(mesh, bucket.subspan(begin, end - begin), twins)) {
                return {};
            }
            begin = end;
        }
    }
    return twins;
}

}  // namespace lamella::baselines
