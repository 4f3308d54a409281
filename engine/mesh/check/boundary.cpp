// The boundary: its edges joined end to end, and T-junctions and cracks, where vertices of it nearly meet it elsewhere.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "base/parallel_sort.hpp"
#include "base/sort.hpp"
#include "mesh/check/finders.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

struct Loop {
    std::uint32_t vertex = std::numeric_limits<std::uint32_t>::max();  ///< the smallest
    std::uint32_t side = std::numeric_limits<std::uint32_t>::max();    ///< on the smallest edge
    std::uint64_t edges = 0;
    double length = 0;  ///< in grid units
    bool closed = true;

    bool operator<(const Loop& other) const {
        return std::tie(vertex, edges, length, side) < std::tie(other.vertex, other.edges, other.length, other.side);
    }
};

/// Walks along unused boundary edges, always the smallest first. Where the walk meets itself the loop is taken off it, so
/// that holes which touch at a vertex come out as separate loops. What is left when it can go no further is an open chain.
class LoopWalk {
public:
    LoopWalk(const GridMesh& mesh, const EdgeTable& edges, const Parallel& parallel) : mesh_(mesh), parallel_(parallel) {
        for (const std::uint32_t edge : edges.boundary()) {
            const auto [lower, upper] = edges[edge];
            ends_.push_back({lower, upper, edges.sides(edge)[0]});
            ends_.push_back({upper, lower, edges.sides(edge)[0]});
        }
        sort_in_parallel(std::span<End>(ends_), std::less<>{}, parallel);
        used_.assign(ends_.size(), false);
        positions_.assign(ends_.size(), not_on_path);
        next_.resize(ends_.size());
        std::iota(next_.begin(), next_.end(), std::size_t{0});
    }

    std::vector<Loop> run() {
        for (const bool all : {false, true}) {  // first the vertices at which a chain must end
            for (std::size_t first = 0; first < ends_.size();) {
                const std::size_t end = place_of({ends_[first].from + 1, 0, 0});
                if (all || (end - first) % 2 == 1) {
                    walk(first);
                }
                first = end;
            }
        }
        sort_briefly(loops_.begin(), loops_.end());
        return std::move(loops_);
    }

private:
    static constexpr std::uint32_t steps_between_stops = 1024;
    static constexpr std::size_t not_on_path = std::numeric_limits<std::size_t>::max();

    /// A boundary edge as seen from one of its ends.
    struct End {
        std::uint32_t from;
        std::uint32_t to;
        std::uint32_t side;
        friend auto operator<=>(const End&, const End&) = default;
    };

    std::size_t place_of(const End& end) const {
        return static_cast<std::size_t>(std::lower_bound(ends_.begin(), ends_.end(), end) - ends_.begin());
    }
    /// The first of a vertex's ends, by which the vertex is known.
    std::size_t first_of(std::uint32_t vertex) const { return place_of({vertex, 0, 0}); }

    /// The next unused end of the vertex, or null.
    const End* leave(std::size_t first) {
        for (std::size_t& i = next_[first]; i < ends_.size() && ends_[i].from == ends_[first].from; ++i) {
            if (!used_[i]) {
                used_[i] = used_[place_of({ends_[i].to, ends_[i].from, ends_[i].side})] = true;
                return &ends_[i];
            }
        }
        return nullptr;
    }

    void walk(const std::size_t start) {
        std::size_t at = start;
        positions_[start] = 0;
        while (const End* const end = leave(at)) {
            if (++steps_ % steps_between_stops == 0) {
                parallel_.stop_if_asked();
            }
            path_.push_back(end);
            at = first_of(end->to);
            if (positions_[at] == not_on_path) {
                positions_[at] = path_.size();
            } else {
                take_off(positions_[at], true);
            }
        }
        take_off(0, false);
        positions_[start] = not_on_path;
    }

    /// Ends the path at `position`; what followed is a loop or a chain.
    void take_off(std::size_t position, bool closed) {
        if (position == path_.size()) {
            return;
        }
        Loop loop;
        loop.closed = closed;
        for (std::size_t i = position; i < path_.size(); ++i) {
            const End& end = *path_[i];
            loop.vertex = std::min({loop.vertex, end.from, end.to});
            loop.side = std::min(loop.side, end.side);
            ++loop.edges;
            loop.length += length(end);
            if (i + 1 < path_.size() || !closed) {
                positions_[first_of(end.to)] = not_on_path;
            }
        }
        path_.resize(position);
        loops_.push_back(loop);
    }

    double length(const End& end) const {
        const GridVertex& a = mesh_.vertices[end.from];
        const GridVertex& b = mesh_.vertices[end.to];
        return 2 * std::sqrt(static_cast<double>(dot(half(a) - half(b), half(a) - half(b))));
    }

    const GridMesh& mesh_;
    const Parallel& parallel_;
    std::uint32_t steps_ = 0;
    std::vector<End> ends_;               ///< two an edge, ascending
    std::vector<bool> used_;              ///< by end
    std::vector<std::size_t> next_;       ///< by vertex: the end to be tried
    std::vector<std::size_t> positions_;  ///< by vertex: on the path, or not_on_path
    std::vector<const End*> path_;
    std::vector<Loop> loops_;
};

/// A vertex, and the vertex or edge that it is near.
using Near = std::pair<std::uint32_t, std::uint32_t>;
using Real = std::array<double, 3>;

Real to_real(const GridVector& v) {
    return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
double dot(const Real& a, const Real& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double length(const GridVector& v) {
    return std::sqrt(static_cast<double>(dot(v, v)));
}

SpaceBox widened(const GridVertex& p, double reach) {
    const auto by = static_cast<std::int64_t>(std::ceil(std::min(reach, 4.0 * grid_limit)));
    const auto below = [by](std::int32_t at) {
        return static_cast<std::int32_t>(std::max<std::int64_t>(at - by, -grid_limit));
    };
    const auto above = [by](std::int32_t at) {
        return static_cast<std::int32_t>(std::min<std::int64_t>(at + by, grid_limit));
    };
    return {{below(p.x), below(p.y), below(p.z)}, {above(p.x), above(p.y), above(p.z)}};
}

/// From p to the line through a and b, where the foot lies strictly between them; else -1. On the line exactly 0.
double distance_to_inside(const GridVector& p, const GridVector& a, const GridVector& b, double& share) {
    const Real along = to_real(b - a);
    const Real ap = to_real(p - a);
    share = dot(along, ap) / dot(along, along);
    if (!(share > 0 && share < 1)) {
        return -1;
    }
    if (cross(b - a, p - a) == GridVector{}) {
        return 0;
    }
    const Real off = {ap[0] - share * along[0], ap[1] - share * along[1], ap[2] - share * along[2]};
    return std::sqrt(dot(off, off));
}

class GapSearch {
public:
    GapSearch(const GridMesh& mesh, const EdgeTable& edges, double tolerance_mm, FaultCollector& faults,
              const Parallel& parallel)
        : mesh_(mesh),
          edges_(edges),
          faults_(faults),
          parallel_(parallel),
          reach_(tolerance_mm / mesh.grid_mm),
          half_reach_(reach_ / 2),
          boundary_(edges.boundary()) {
        for (const std::uint32_t edge : boundary_) {
            vertices_.push_back(edges[edge].lower);
            vertices_.push_back(edges[edge].upper);
        }
        sort_in_parallel(std::span<std::uint32_t>(vertices_), std::less<>{}, parallel);
        vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    }

    void find_t_junctions() {
        BoxTree<GridVertex> tree;
        tree.assign(
            boundary_.size(),
            [&](std::size_t item) {
                const EdgeTable::Edge edge = edges_[boundary_[item]];
                return SpaceBox::around(mesh_.vertices[edge.lower], mesh_.vertices[edge.upper]);
            },
            parallel_);
        search(
            Fault::t_junction, tree,
            [&](std::uint32_t vertex, std::size_t item, std::vector<Near>& found) {
                if (is_t_junction(vertex, boundary_[item])) {
                    found.push_back({vertex, boundary_[item]});
                }
            },
            [&](const Near& near) { return place_of_t_junction(near.first, near.second); });
    }

    void find_cracks() {
        BoxTree<GridVertex> tree;
        tree.assign(
            vertices_.size(),
            [&](std::size_t item) {
                return SpaceBox{at_grid(item), at_grid(item)};
            },
            parallel_);
        search(
            Fault::crack, tree,
            [&](std::uint32_t vertex, std::size_t item, std::vector<Near>& found) {
                const std::uint32_t other = vertices_[item];
                if (vertex < other && length(at(other) - at(vertex)) <= half_reach_ && !edges_.joins(vertex, other)) {
                    found.push_back({vertex, other});
                }
            },
            [&](const Near& near) {
                FaultPlace place = faults_.at({near.first, near.second});
                place.measure = length(at(near.second) - at(near.first)) * 2 * mesh_.grid_mm;
                return place;
            });
    }

private:
    GridVector at(std::uint32_t vertex) const { return half(mesh_.vertices[vertex]); }
    const GridVertex& at_grid(std::size_t item) const { return mesh_.vertices[vertices_[item]]; }

    /// Calls visit() for every vertex of the boundary and every item whose box is within reach; it adds to what is found.
    template <class Visit, class MakePlace>
    void search(Fault fault, const BoxTree<GridVertex>& tree, Visit visit, MakePlace make_place) {
        Tally<Near> tally(faults_.most());
        FaultFinding& finding = faults_.of(fault);
        finding.at_least = !search_within<Near>(
            search_budget(vertices_.size()), vertices_.size(), parallel_,
            [&](std::size_t query, std::size_t limit, std::vector<Near>& found) {
                const std::uint32_t vertex = vertices_[query];
                return tree.search(widened(mesh_.vertices[vertex], reach_), limit,
                                   [&](std::size_t item) { visit(vertex, item, found); });
            },
            [&](const Near& near) { tally.add(near); });
        tally.fill_in(finding, make_place);
    }

    /// Near the ends of the edge the vertex makes a crack with them instead. A face's own corner near its side makes it a
    /// cap, or leaves it without area.
    bool is_t_junction(std::uint32_t vertex, std::uint32_t edge) const {
        const auto [lower, upper] = edges_[edge];
        double share = 0;
        const double distance = distance_to_inside(at(vertex), at(lower), at(upper), share);
        const Face& face = mesh_.faces[EdgeTable::face_of(edges_.sides(edge)[0])];
        const bool own = std::find(face.corners.begin(), face.corners.end(), vertex) != face.corners.end();
        return !own && distance >= 0 && distance <= half_reach_ && length(at(vertex) - at(lower)) > half_reach_ &&
               length(at(vertex) - at(upper)) > half_reach_;
    }

    /// The vertex, and the point of the edge next to it.
    FaultPlace place_of_t_junction(std::uint32_t vertex, std::uint32_t edge) const {
        const auto [lower, upper] = edges_[edge];
        double share = 0;
        FaultPlace place = faults_.at({vertex});
        place.measure = distance_to_inside(at(vertex), at(lower), at(upper), share) * 2 * mesh_.grid_mm;
        place.triangles[0] = mesh_.faces[EdgeTable::face_of(edges_.sides(edge)[0])].source;
        const Real from = faults_.mm(mesh_.vertices[lower]);
        const Real to = faults_.mm(mesh_.vertices[upper]);
        place.point_count = 2;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            place.points_mm[1][axis] = from[axis] + share * (to[axis] - from[axis]);
        }
        return place;
    }

    const GridMesh& mesh_;
    const EdgeTable& edges_;
    FaultCollector& faults_;
    const Parallel& parallel_;
    double reach_;                                ///< the tolerance in grid units
    double half_reach_;                           ///< the tolerance in halves of vertices, which are twice the unit
    const std::vector<std::uint32_t>& boundary_;  ///< edges
    std::vector<std::uint32_t> vertices_;         ///< their ends, ascending
};

}  // namespace

void find_loops(const GridMesh& mesh, const EdgeTable& edges, FaultCollector& faults, const Parallel& parallel) {
    for (const Loop& loop : LoopWalk(mesh, edges, parallel).run()) {
        faults.add(Fault::boundary_loop, [&] {
            FaultPlace place = faults.at({loop.vertex});
            place.triangles[0] = mesh.faces[EdgeTable::face_of(loop.side)].source;
            place.parts = loop.edges;
            place.measure = loop.length * mesh.grid_mm;
            place.closed = loop.closed;
            return place;
        });
    }
}

void find_gaps(const GridMesh& mesh, const EdgeTable& edges, double tolerance_mm, FaultCollector& faults,
               const Parallel& parallel) {
    GapSearch search(mesh, edges, tolerance_mm, faults, parallel);
    search.find_t_junctions();
    search.find_cracks();
}

}  // namespace lamella
