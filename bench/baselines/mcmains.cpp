// The coherent sweep plane slicer: S. McMains and C. Séquin, "A coherent sweep plane slicer for layered manufacturing",
// 1999; the paper's section 2.1. It slices meshes with topology. Here the topology is first recovered from the soup by
// a binary tree of the vertices, as in E. Béchet, J.-C. Cuillière and F. Trochu (2002).
//
// A plane sweeps the mesh upwards and keeps its contours as rings of edges. Rings change only at vertices: edges that
// end there are replaced by those that begin there. At a vertex with one run of edges below and one above, the ring
// continues. The lowest vertex of a part begins a ring, and the highest ends it. At any other vertex rings merge or
// split, so the rings through it are walked to find which they are. At a slicing plane each ring is a contour; only its
// points have to be computed.
//
// O(n log n + m). As the paper says, up to O(n^2) where rings merge and split often, because each such vertex costs the
// length of its rings.
//
// Kept from the source: only closed meshes are sliced; others give no contours. Vertices of equal height are swept in
// the order of their numbers, as if the mesh were tilted slightly. Level edges and facets therefore need no special
// cases. Planes never meet a vertex. Left out: the nesting of the rings, which no measurement here needs.
#include "methods.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "geometry.hpp"
#include "topology.hpp"

namespace lamella::baselines {

namespace {

constexpr std::uint32_t none = 0xFFFFFFFF;

/// The contours in which the sweep plane cuts the mesh, as rings of edges. An edge is named by its half-edge that runs
/// down, where the contour enters a facet.
class Rings {
public:
    explicit Rings(std::size_t half_edges) : next(half_edges, none), ring_of(half_edges, none) {}

    /// Adds the edges from `first` to `last`, already linked, to the ring.
    void put(std::uint32_t first, std::uint32_t last, std::uint32_t ring) {
        for (std::uint32_t edge = first;; edge = next[edge]) {
            ring_of[edge] = ring;
            if (edge == last) {
                break;
            }
        }
        edge_in[ring] = first;  // the ring's former representative may have ended
    }

    /// Makes a ring of the edges linked to this one.
    void begin(std::uint32_t edge) {
        std::uint32_t last = edge;
        while (next[last] != edge) {
            last = next[last];
        }
        put(edge, last, begun_++);
    }

    std::vector<std::uint32_t> next;                           ///< by edge: the next edge that the contour crosses
    std::vector<std::uint32_t> ring_of;                        ///< by edge
    std::unordered_map<std::uint32_t, std::uint32_t> edge_in;  ///< by ring: one of its edges

private:
    std::uint32_t begun_ = 0;
};

class Sweep {
public:
    Sweep(const Problem& problem, SharedVertices mesh, std::vector<std::uint32_t> twins)
        : planes_(problem.planes),
          mesh_(std::move(mesh)),
          twins_(std::move(twins)),
          fans_(grouped(static_cast<std::uint32_t>(twins_.size()), mesh_.vertices.size(),
                        [&](std::uint32_t h) { return mesh_.from(h); })),
          rings_(twins_.size()),
          order_(mesh_.vertices.size()) {
        std::iota(order_.begin(), order_.end(), 0U);
        std::ranges::sort(order_, [&](std::uint32_t a, std::uint32_t b) { return is_below(a, b); });
    }

    WholeOutcome run() {
        WholeOutcome outcome;
        outcome.contours.resize(planes_.size());
        std::size_t at = 0;
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            for (; at < order_.size() && mesh_.vertices[order_[at]].z < planes_[i]; ++at) {
                pass(order_[at]);
            }
            for (const auto& [ring, edge] : rings_.edge_in) {
                outcome.contours[i].push_back(contour_of(edge, planes_[i]));
                outcome.segments += outcome.contours[i].back().points.size();
            }
        }
        return outcome;
    }

private:
    bool is_below(std::uint32_t a, std::uint32_t b) const noexcept {
        return std::pair(mesh_.vertices[a].z, a) < std::pair(mesh_.vertices[b].z, b);
    }

    /// Passes one vertex. In each facet at the vertex, `out` runs from the vertex to corner a, and `in` from corner b
    /// to the vertex:
    ///
    ///      b ----- a          a                b
    ///       \     /           |\              /|
    ///     in \   / out   long | \ out      in/ | long
    ///         \ /             |  v          v  |
    ///          v              | /in       out\ |
    ///                         |/              \|
    ///                         b                a
    ///     it begins       begins a run     ends a run       contours run from left to right, seen from outside
    void pass(std::uint32_t vertex) {
        ended_.clear();
        begun_.clear();
        run_ = {};
        for (const std::uint32_t out : fans_.of(vertex)) {
            const std::uint32_t in = previous_in_facet(out);
            const std::uint32_t opposite = next_in_facet(out);
            const bool a_is_above = is_below(vertex, mesh_.to(out));
            const bool b_is_above = is_below(vertex, mesh_.from(in));
            // Every edge at the vertex is `out` of one facet and `in` of its neighbour.
            if (a_is_above) {
                begun_.push_back(twins_[out]);
                rings_.next[b_is_above ? in : opposite] = twins_[out];
            } else {
                ended_.push_back(rings_.ring_of[out]);
                if (b_is_above) {
                    rings_.next[in] = twins_[opposite];
                }
            }
            if (a_is_above && !b_is_above) {
                run_.first = twins_[out];
                ++run_.count;
            } else if (!a_is_above && b_is_above) {
                run_.last = in;
            }
        }
        update_rings();
    }

    void update_rings() {
        if (is_one_run_for_one()) {
            rings_.put(run_.first, run_.last, ended_.front());
            return;
        }
        for (const std::uint32_t ring : ended_) {
            rings_.edge_in.erase(ring);
        }
        for (const std::uint32_t edge : begun_) {
            if (rings_.ring_of[edge] == none) {
                rings_.begin(edge);
            }
        }
    }

    /// True where the same ring continues through the vertex. Other rings may still begin or end there if the mesh touches
    /// itself.
    bool is_one_run_for_one() const {
        if (run_.count != 1 || std::ranges::adjacent_find(ended_, std::not_equal_to()) != ended_.end()) {
            return false;
        }
        std::size_t length = 1;
        for (std::uint32_t edge = run_.first; edge != run_.last; edge = rings_.next[edge]) {
            ++length;
        }
        return length == begun_.size();
    }

    Polyline contour_of(std::uint32_t start, std::int32_t plane) const {
        Polyline contour{.points = {}, .closed = true};
        std::uint32_t edge = start;
        do {
            contour.points.push_back(crossing(mesh_.vertices[mesh_.from(edge)], mesh_.vertices[mesh_.to(edge)], plane));
            edge = rings_.next[edge];
        } while (edge != start);
        return contour;
    }

    const std::vector<std::int32_t>& planes_;
    SharedVertices mesh_;
    std::vector<std::uint32_t> twins_;
    Groups fans_;  // half-edges by their first vertex
    Rings rings_;
    std::vector<std::uint32_t> order_;  // vertices, lowest first
    // At the current vertex:
    std::vector<std::uint32_t> ended_;  // rings of the edges that end there
    std::vector<std::uint32_t> begun_;  // edges that begin there
    struct {
        std::uint32_t first = none;
        std::uint32_t last = none;
        int count = 0;
    } run_;  // successive edges that begin at the vertex, between two facets that extend both above and below it
};

WholeOutcome run(const Problem& problem) {
    return run_on_topology<Sweep>(problem, share_vertices_by_tree);
}

}  // namespace

const WholeMethod mcmains{
    .name = "McMains",
    .run = run,
};

}  // namespace lamella::baselines
