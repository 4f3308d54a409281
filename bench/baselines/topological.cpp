// TSlicer traces contours through the half-edge structure of the mesh. R. D. da Silva, H. R. Ramalho, R. Minetto, N.
// Volpato and J. Stolfi, "TSlicer: An optimal topology-based slicing algorithm for Z-monotone 3D meshes", 2024: the
// successor of the paper's own algorithm, by its authors.
//
// Edges are put into lists by the first plane that cuts them (the paper's Algorithm 2, with edges instead of
// triangles). Planes are visited from the lowest up, with the set of edges that they cut. A contour is traced from any
// edge that this plane has not visited yet, from half-edge to half-edge: the next crossing is on the same face, and
// then on its twin. Each edge remembers the next half-edge of the last plane (the short cut). While the plane still
// cuts that one, the face need not be examined, however many edges it has.
//
// O(n + k + m) for uniform planes, O(n log k + k + m) for others, plus the topology: O(n) here, by hashing.
//
// Kept from the source: only closed meshes are sliced; others give no contours. Faces are triangles here, as the soup's
// are. Written from the published abstract and descriptions of the algorithm, not from its source code.
#include "methods.hpp"

#include <utility>

#include "geometry.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "topology.hpp"

namespace lamella::baselines {

namespace {

/// An edge while planes cut it, from the first such plane to the last. It is named by its half-edge that runs down,
/// where contours enter its facet.
struct CutEdge {
    std::int32_t x;  ///< x of the lower vertex
    std::int32_t y;
    std::int32_t z;
    std::int32_t top;  ///< z of the upper vertex
    double slope_x;
    double slope_y;
    std::uint32_t half_edge;
    std::uint32_t next;    ///< the next edge along the contour at the last plane
    std::uint32_t met_at;  ///< one plus the index of the last plane whose contour was traced through this edge

    Point at(std::int32_t plane) const noexcept {
        const auto rise = static_cast<double>(std::int64_t{plane} - z);
        return {x + round_move(slope_x * rise), y + round_move(slope_y * rise)};
    }
};

class Tracer {
public:
    Tracer(const Problem& problem, SharedVertices mesh, std::vector<std::uint32_t> twins)
        : planes_(problem.planes), mesh_(std::move(mesh)), twins_(std::move(twins)) {
        list_edges(problem);
    }

    WholeOutcome run() {
        WholeOutcome outcome;
        outcome.contours.resize(planes_.size());
        std::vector<std::uint32_t> active;
        for (std::uint32_t i = 0; i < planes_.size(); ++i) {
            std::erase_if(active, [&](std::uint32_t e) { return edges_[e].top < planes_[i]; });
            for (std::uint32_t e = by_plane_.first[i]; e < by_plane_.first[i + 1]; ++e) {
                active.push_back(e);
            }
            for (const std::uint32_t e : active) {
                if (edges_[e].met_at != i + 1) {
                    outcome.contours[i].push_back(trace(e, i));
                }
            }
            outcome.segments += active.size();
        }
        return outcome;
    }

private:
    /// Lists the edges that planes cut, by the first plane that cuts them.
    void list_edges(const Problem& problem) {
        const FirstPlaneAbove first_plane(problem);
        by_plane_ = grouped(static_cast<std::uint32_t>(twins_.size()), planes_.size(), [&](std::uint32_t h) {
            const std::int32_t upper = mesh_.vertices[mesh_.from(h)].z;
            const std::int32_t lower = mesh_.vertices[mesh_.to(h)].z;
            const std::uint32_t plane = lower < upper ? first_plane(lower) : no_key;
            return plane < planes_.size() && planes_[plane] < upper ? plane : no_key;
        });
        edge_of_.assign(twins_.size(), no_edge);
        for (const std::uint32_t h : by_plane_.items) {
            edge_of_[h] = static_cast<std::uint32_t>(edges_.size());
            edges_.push_back(cut_edge(h));
        }
    }

    CutEdge cut_edge(std::uint32_t half_edge) const {
        const GridVertex& upper = mesh_.vertices[mesh_.from(half_edge)];
        const GridVertex& lower = mesh_.vertices[mesh_.to(half_edge)];
        const double height = static_cast<double>(std::int64_t{upper.z} - lower.z);
        return {.x = lower.x,
                .y = lower.y,
                .z = lower.z,
                .top = upper.z,
                .slope_x = static_cast<double>(std::int64_t{upper.x} - lower.x) / height,
                .slope_y = static_cast<double>(std::int64_t{upper.y} - lower.y) / height,
                .half_edge = half_edge,
                .next = no_edge,
                .met_at = 0};
    }

    Polyline trace(std::uint32_t start, std::uint32_t plane_index) {
        const std::int32_t plane = planes_[plane_index];
        Polyline contour{.points = {}, .closed = true};
        for (std::uint32_t e = start; edges_[e].met_at != plane_index + 1;) {
            CutEdge& edge = edges_[e];
            edge.met_at = plane_index + 1;
            contour.points.push_back(edge.at(plane));
            // Of a facet's two other edges, only the one that ends first can cease to be next, so testing whether it is
            // still cut suffices.
            if (edge.next == no_edge || edges_[edge.next].top < plane) {
                edge.next = find_next(edge.half_edge, plane);
            }
            e = edge.next;
        }
        return contour;
    }

    /// The twin of the facet's half-edge that runs up through the plane. The twin runs down on the next facet.
    std::uint32_t find_next(std::uint32_t half_edge, std::int32_t plane) const {
        const std::uint32_t after = next_in_facet(half_edge);
        const std::int32_t apex = mesh_.vertices[mesh_.to(after)].z;
        return edge_of_[twins_[apex > plane ? after : next_in_facet(after)]];
    }

    static constexpr std::uint32_t no_edge = 0xFFFFFFFF;

    const std::vector<std::int32_t>& planes_;
    SharedVertices mesh_;
    std::vector<std::uint32_t> twins_;
    std::vector<CutEdge> edges_;
    Groups by_plane_;                     // half-edges by the first plane that cuts them; edges_ has the same order
    std::vector<std::uint32_t> edge_of_;  // by half-edge
};

WholeOutcome run(const Problem& problem) {
    return run_on_topology<Tracer>(problem, share_vertices_by_hash);
}

}  // namespace

const WholeMethod topological{
    .name = "topological",
    .run = run,
};

}  // namespace lamella::baselines
