// The method of Slic3r's TriangleMeshSlicer (A. Ranellucci and others), which the paper times as "Slic3r".
//
// 1. Topology: facets get shared vertices, and edges get numbers by sorting the edges of all facets.
// 2. Facet by facet: binary search finds the planes between the facet's lowest and highest vertex. Each such plane's
// list gets a line, with the numbers of the two edges on which the line ends.
// 3. Plane by plane: lines are sorted by the edge on which they begin. Binary search finds the line that begins on the
// edge where the chain ends. Finally, chains that did not close are joined with one another, reversed if needed.
//
// O(n log n + n log k + m log m). Any planes, any mesh.
//
// Nothing is corrected. Lines are sorted in each layer, as in later versions. The version that the paper timed built a
// table of all 3 n edge numbers in every layer, O(n k). Left out: vertex numbers and marks of level facets, by which
// Slic3r chains lines that end exactly on a vertex (planes never meet a vertex here); locks; and gap closing. Where
// more than two facets share an edge, Slic3r pairs them in order of appearance; here they are paired as in the engine.
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

class MeshSlicer {
public:
    explicit MeshSlicer(const std::vector<Facet>& facets)
        : mesh_(share_vertices_by_hash(facets)), edge_numbers_(number_edges(mesh_)) {}

    std::vector<Lines> slice(const std::vector<std::int32_t>& planes) const {
        std::vector<Lines> lines(planes.size());
        for (std::uint32_t f = 0; f < mesh_.facets.size(); ++f) {
            const auto [a, b, c] = mesh_.facets[f];
            const auto [low, high] = std::minmax({mesh_.vertices[a].z, mesh_.vertices[b].z, mesh_.vertices[c].z});
            const auto first = std::lower_bound(planes.begin(), planes.end(), low);
            const auto end = std::upper_bound(first, planes.end(), high);
            for (auto plane = first; plane != end; ++plane) {
                lines[static_cast<std::size_t>(plane - planes.begin())].push_back(cut_facet(f, *plane));
            }
        }
        return lines;
    }

private:
    Line cut_facet(std::uint32_t f, std::int32_t plane) const {
        Line line{};
        for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
            const GridVertex& from = mesh_.vertices[mesh_.from(h)];
            const GridVertex& to = mesh_.vertices[mesh_.to(h)];
            if (!is_cut(from, to, plane)) {
                continue;
            }
            if (to.z < plane) {
                line.a = crossing(from, to, plane);
                line.edge_a = edge_numbers_[h];
            } else {
                line.b = crossing(from, to, plane);
                line.edge_b = edge_numbers_[h];
            }
        }
        return line;
    }

    SharedVertices mesh_;
    std::vector<std::uint32_t> edge_numbers_;
};

/// A chain of lines that did not close.
struct OpenChain {
    std::vector<Point> points;
    std::uint32_t edges[2];  ///< the edges on which it begins and ends
};

/// Joins chains that end on the same edge.
class ChainJoiner {
public:
    explicit ChainJoiner(std::vector<OpenChain> chains)
        : chains_(std::move(chains)), partner_(2 * chains_.size(), no_end), is_used_(chains_.size()) {
        std::vector<std::uint32_t> ends(partner_.size());
        for (std::uint32_t end = 0; end < ends.size(); ++end) {
            ends[end] = end;
        }
        const auto edge_of = [&](std::uint32_t end) { return chains_[end / 2].edges[end % 2]; };
        std::ranges::sort(ends, {}, edge_of);
        for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
            if (edge_of(ends[i]) == edge_of(ends[i + 1])) {  // at most two chain ends share an edge
                partner_[ends[i]] = ends[i + 1];
                partner_[ends[i + 1]] = ends[i];
            }
        }
    }

    /// Starts from free chain ends first, and keeps the lines' orientation where possible.
    void append_to(std::vector<Polyline>& contours) {
        for (const std::uint32_t side : {0U, 1U}) {
            for (std::uint32_t chain = 0; chain < chains_.size(); ++chain) {
                if (!is_used_[chain] && partner_[2 * chain + side] == no_end) {
                    contours.push_back(walk(2 * chain + side));
                }
            }
        }
        for (std::uint32_t chain = 0; chain < chains_.size(); ++chain) {
            if (!is_used_[chain]) {
                contours.push_back(walk(2 * chain));
            }
        }
    }

private:
    Polyline walk(std::uint32_t end) {
        Polyline joined;
        for (; end != no_end && !is_used_[end / 2]; end = partner_[end ^ 1U]) {
            is_used_[end / 2] = true;
            std::vector<Point>& points = chains_[end / 2].points;
            if (end % 2 == 1) {
                std::ranges::reverse(points);
            }
            if (!joined.points.empty()) {
                joined.points.pop_back();  // the next chain repeats this point
            }
            joined.points.insert(joined.points.end(), points.begin(), points.end());
        }
        joined.closed = end != no_end;
        if (joined.closed) {
            joined.points.pop_back();
        }
        return joined;
    }

    static constexpr std::uint32_t no_end = 0xFFFFFFFF;
    std::vector<OpenChain> chains_;
    // By chain end, numbered 2 * chain for the first point and 2 * chain + 1 for the last.
    std::vector<std::uint32_t> partner_;
    std::vector<bool> is_used_;
};

class LineChainer {
public:
    explicit LineChainer(const Lines& lines) : lines_(lines), by_edge_a_(lines.size()), is_used_(lines.size()) {
        for (std::uint32_t i = 0; i < lines.size(); ++i) {
            by_edge_a_[i] = {lines[i].edge_a, i};
        }
        std::ranges::sort(by_edge_a_);
    }

    std::vector<Polyline> chains() {
        std::vector<Polyline> contours;
        std::vector<OpenChain> open;
        for (std::uint32_t first = 0; first < lines_.size(); ++first) {
            if (is_used_[first]) {
                continue;
            }
            std::vector<Point> points;
            std::uint32_t last = first;
            for (std::uint32_t line = first; line != no_line; line = line_after(line)) {
                is_used_[line] = true;
                points.push_back(lines_[line].a);
                last = line;
            }
            if (lines_[last].edge_b == lines_[first].edge_a) {
                contours.push_back({std::move(points), true});
            } else {
                points.push_back(lines_[last].b);
                open.push_back({std::move(points), {lines_[first].edge_a, lines_[last].edge_b}});
            }
        }
        ChainJoiner(std::move(open)).append_to(contours);
        return contours;
    }

private:
    struct Start {
        std::uint32_t edge_a;
        std::uint32_t line;
        auto operator<=>(const Start&) const = default;
    };

    std::uint32_t line_after(std::uint32_t line) const {
        const std::uint32_t edge = lines_[line].edge_b;
        auto next = std::lower_bound(by_edge_a_.begin(), by_edge_a_.end(), Start{edge, 0});
        for (; next != by_edge_a_.end() && next->edge_a == edge; ++next) {
            if (!is_used_[next->line]) {
                return next->line;
            }
        }
        return no_line;
    }

    static constexpr std::uint32_t no_line = 0xFFFFFFFF;
    const Lines& lines_;
    std::vector<Start> by_edge_a_;
    std::vector<bool> is_used_;
};

WholeOutcome run(const Problem& problem) {
    return in_two_steps([&] { return MeshSlicer(quantised(problem)).slice(problem.planes); },
                        [](const Lines& lines) { return LineChainer(lines).chains(); });
}

}  // namespace

const WholeMethod slic3r_way{
    .name = "Slic3r",
    .source = "TriangleMeshSlicer of Slic3r",
    .takes_open_meshes = true,
    .run = run,
};

}  // namespace lamella::baselines
