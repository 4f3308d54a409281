// The method of Slic3r's TriangleMeshSlicer (A. Ranellucci and others), which the paper times as "Slic3r".
//
// 1. Topology: facets get shared vertices, and edges get numbers by sorting the edges of all facets.
// 2. Facet by facet: binary search finds the planes between the facet's lowest and highest vertex. Each such plane's
// list gets a line, with the numbers of the two edges on which the line ends.
// 3. Plane by plane: lines are sorted by the edge on which they begin. Binary search finds the line that begins on the
// edge where the chain ends.
//
// O(n log n + n log k + m log m). Any planes, any mesh.
//
// Nothing is corrected. Lines are sorted in each layer, as in later versions. The version that the paper timed built a
// table of all 3 n edge numbers in every layer, O(n k). Left out: vertex numbers and marks of level facets, by which
// Slic3r chains lines that end exactly on a vertex (planes never meet a vertex here); locks; gap closing; and joining chains
// that did not close with one another, so that a polyline of an open mesh may come in pieces. Where more than two facets
// share an edge, Slic3r pairs them in order of appearance; here they are paired as in the engine.
#include "methods.hpp"

#include <algorithm>
#include <utility>

#include "geometry.hpp"
#include "topology.hpp"

namespace lamella::baselines {

namespace {

struct Line {
    Point a;
    Point b;
    std::uint32_t edge_a;
    std::uint32_t edge_b;
};
using Lines = std::vector<Line>;

/// By half-edge: the number of its edge.
std::vector<std::uint32_t> number_edges(const SharedVertices& mesh) {
    struct Edge {
        std::uint32_t low;
        std::uint32_t high;
        std::uint32_t half_edge;
        auto operator<=>(const Edge&) const = default;
        bool is_same(const Edge& other) const noexcept { return low == other.low && high == other.high; }
    };
    std::vector<Edge> edges(3 * mesh.facets.size());
    for (std::uint32_t h = 0; h < edges.size(); ++h) {
        const auto [low, high] = std::minmax({mesh.from(h), mesh.to(h)});
        edges[h] = {low, high, h};
    }
    std::ranges::sort(edges);
    std::vector<std::uint32_t> numbers(edges.size());
    std::uint32_t number = 0;
    std::vector<std::uint32_t> crowd;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        for (end = begin; end < edges.size() && edges[end].is_same(edges[begin]); ++end) {
            numbers[edges[end].half_edge] = number;
        }
        if (end - begin > 2) {
            crowd.clear();
            for (std::size_t i = begin; i < end; ++i) {
                crowd.push_back(edges[i].half_edge);
            }
            for (const auto& [one, other] : pair_round_edge(mesh, crowd)) {
                numbers[one] = numbers[other] = ++number;
            }
        }
        ++number;
    }
    return numbers;
}

Line cut_facet(const SharedVertices& mesh, const std::vector<std::uint32_t>& edge_numbers, std::uint32_t f,
               std::int32_t plane) {
    Line line{};
    for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
        const GridVertex& from = mesh.vertices[mesh.from(h)];
        const GridVertex& to = mesh.vertices[mesh.to(h)];
        if (is_cut(from, to, plane)) {
            const bool runs_down = to.z < plane;
            (runs_down ? line.a : line.b) = crossing(from, to, plane);
            (runs_down ? line.edge_a : line.edge_b) = edge_numbers[h];
        }
    }
    return line;
}

std::vector<Lines> slice(const std::vector<Facet>& facets, const std::vector<std::int32_t>& planes) {
    const SharedVertices mesh = share_vertices_by_hash(facets);
    const std::vector<std::uint32_t> edge_numbers = number_edges(mesh);
    std::vector<Lines> lines(planes.size());
    for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
        const auto [a, b, c] = mesh.facets[f];
        const auto [low, high] = std::minmax({mesh.vertices[a].z, mesh.vertices[b].z, mesh.vertices[c].z});
        const auto first = std::lower_bound(planes.begin(), planes.end(), low);
        const auto end = std::upper_bound(first, planes.end(), high);
        for (auto plane = first; plane != end; ++plane) {
            lines[static_cast<std::size_t>(plane - planes.begin())].push_back(cut_facet(mesh, edge_numbers, f, *plane));
        }
    }
    return lines;
}

std::vector<Polyline> chain(const Lines& lines) {
    constexpr std::uint32_t no_line = 0xFFFFFFFF;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> by_edge_a(lines.size());
    for (std::uint32_t i = 0; i < lines.size(); ++i) {
        by_edge_a[i] = {lines[i].edge_a, i};
    }
    std::ranges::sort(by_edge_a);
    std::vector<bool> is_used(lines.size());
    const auto unused_line_on = [&](std::uint32_t edge) {
        auto next = std::lower_bound(by_edge_a.begin(), by_edge_a.end(), std::pair(edge, 0U));
        while (next != by_edge_a.end() && next->first == edge && is_used[next->second]) {
            ++next;
        }
        return next != by_edge_a.end() && next->first == edge ? next->second : no_line;
    };
    std::vector<Polyline> contours;
    for (std::uint32_t first = 0; first < lines.size(); ++first) {
        if (is_used[first]) {
            continue;
        }
        std::vector<Point> points;
        std::uint32_t last = first;
        for (std::uint32_t line = first; line != no_line; line = unused_line_on(lines[line].edge_b)) {
            is_used[line] = true;
            points.push_back(lines[line].a);
            last = line;
        }
        const bool closed = lines[last].edge_b == lines[first].edge_a;
        if (!closed) {
            points.push_back(lines[last].b);
        }
        contours.push_back({std::move(points), closed});
    }
    return contours;
}

WholeOutcome run(const Problem& problem) {
    return in_two_steps([&] { return slice(quantised(problem), problem.planes); }, chain);
}

}  // namespace

const WholeMethod slic3r_way{
    .name = "Slic3r",
    .run = run,
};

}  // namespace lamella::baselines
