#include "topology.hpp"

#include <algorithm>
#include <bit>
#include <map>

#include "slicing/contours/slot_table.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella::baselines {

namespace {

/// Numbers vertices by a hash table: open addressing, at most half full. It begins with room for the vertices of a closed
/// mesh without handles.
class VertexTable {
public:
    explicit VertexTable(std::size_t facets) : slots_(std::bit_ceil(facets + 5), no_vertex) {}

    std::uint32_t operator()(const GridVertex& vertex) {
        if (2 * vertices.size() >= slots_.size()) {
            slots_.assign(2 * slots_.size(), no_vertex);
            for (std::uint32_t v = 0; v < vertices.size(); ++v) {
                slot_of(vertices[v]) = v;
            }
        }
        std::uint32_t& slot = slot_of(vertex);
        if (slot == no_vertex) {
            slot = static_cast<std::uint32_t>(vertices.size());
            vertices.push_back(vertex);
        }
        return slot;
    }

    std::vector<GridVertex> vertices;

private:
    /// Where the vertex is, or where it belongs.
    std::uint32_t& slot_of(const GridVertex& vertex) {
        const std::size_t mask = slots_.size() - 1;
        std::size_t i = hash_of(vertex) & mask;
        while (slots_[i] != no_vertex && vertices[slots_[i]] != vertex) {
            i = (i + 1) & mask;
        }
        return slots_[i];
    }

    static constexpr std::uint32_t no_vertex = 0xFFFFFFFF;
    std::vector<std::uint32_t> slots_;
};

/// Numbers vertices by a sorted binary tree.
class VertexTree {
public:
    std::uint32_t operator()(const GridVertex& vertex) {
        const auto [found, is_new] = tree_.try_emplace(vertex, static_cast<std::uint32_t>(vertices.size()));
        if (is_new) {
            vertices.push_back(vertex);
        }
        return found->second;
    }

    std::vector<GridVertex> vertices;

private:
    std::map<GridVertex, std::uint32_t> tree_;
};

template <class Numbers>
SharedVertices share_vertices(const std::vector<Facet>& facets, Numbers number_of) {
    SharedVertices mesh;
    mesh.facets.reserve(facets.size());
    for (const Facet& facet : facets) {
        const std::uint32_t a = number_of(facet[0]);
        const std::uint32_t b = number_of(facet[1]);
        mesh.facets.push_back({a, b, number_of(facet[2])});
    }
    mesh.vertices = std::move(number_of.vertices);
    return mesh;
}

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
    return share_vertices(facets, VertexTree());
}

SharedVertices share_vertices_by_hash(const std::vector<Facet>& facets) {
    return share_vertices(facets, VertexTable(facets.size()));
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
        faces.push_back({mesh.vertices[mesh.to(next_in_facet(h))], h, {no_slot, h, runs_down}});
    }
    sort_round_edge(lower, upper, faces);
    std::vector<MeetingEnd> ends;
    ends.reserve(faces.size());
    for (const FaceAtEdge& face : faces) {
        ends.push_back(face.end);
    }
    Pairing pairing(nullptr);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const auto& [in, out] : pairing.match(ends)) {
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
