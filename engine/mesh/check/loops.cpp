// Boundary edges joined end to end.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "base/parallel_sort.hpp"
#include "mesh/check/finders.hpp"
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
            ends_.push_back({edges[edge].lower, edges[edge].upper, boundary_count_});
            ends_.push_back({edges[edge].upper, edges[edge].lower, boundary_count_++});
            sides_.push_back(edges.sides(edge)[0]);
        }
        sort_in_parallel(std::span<End>(ends_), std::less<>{}, parallel);
        used_.assign(boundary_count_, false);
        for (std::uint32_t i = 0; i < ends_.size(); ++i) {
            if (i == 0 || ends_[i].from != ends_[i - 1].from) {
                stops_.push_back({i, i, not_on_path});
            }
        }
    }

    std::vector<Loop> run() {
        for (std::uint32_t stop = 0; stop < stops_.size(); ++stop) {  // first those at which a chain must end
            const std::uint32_t end =
                stop + 1 < stops_.size() ? stops_[stop + 1].first : static_cast<std::uint32_t>(ends_.size());
            if ((end - stops_[stop].first) % 2 == 1) {
                walk(stop);
            }
        }
        for (std::uint32_t stop = 0; stop < stops_.size(); ++stop) {
            walk(stop);
        }
        std::sort(loops_.begin(), loops_.end());
        return std::move(loops_);
    }

private:
    static constexpr std::uint32_t steps_between_stops = 1024;
    static constexpr std::uint32_t not_on_path = std::numeric_limits<std::uint32_t>::max();

    /// A boundary edge as seen from one of its ends.
    struct End {
        std::uint32_t from;
        std::uint32_t to;
        std::uint32_t edge;  ///< among boundary edges
        friend auto operator<=>(const End&, const End&) = default;
    };

    struct Stop {
        std::uint32_t first;     ///< among its ends
        std::uint32_t next;      ///< end to be tried
        std::uint32_t position;  ///< on the path, or not_on_path
    };

    std::uint32_t stop_of(std::uint32_t vertex) const {
        const auto at = std::lower_bound(stops_.begin(), stops_.end(), vertex,
                                         [&](const Stop& stop, std::uint32_t v) { return ends_[stop.first].from < v; });
        return static_cast<std::uint32_t>(at - stops_.begin());
    }

    /// The next unused end at the stop, or null.
    const End* leave(std::uint32_t stop) {
        const std::uint32_t vertex = ends_[stops_[stop].first].from;
        for (std::uint32_t& i = stops_[stop].next; i < ends_.size() && ends_[i].from == vertex; ++i) {
            if (!used_[ends_[i].edge]) {
                used_[ends_[i].edge] = true;
                return &ends_[i];
            }
        }
        return nullptr;
    }

    void walk(std::uint32_t stop) {
        const std::uint32_t start = stop;
        stops_[start].position = 0;
        while (const End* const end = leave(stop)) {
            if (++steps_ % steps_between_stops == 0) {
                parallel_.stop_if_asked();
            }
            path_.push_back(end);
            stop = stop_of(end->to);
            if (stops_[stop].position == not_on_path) {
                stops_[stop].position = static_cast<std::uint32_t>(path_.size());
            } else {
                take_off(stops_[stop].position, true);
            }
        }
        take_off(0, false);
        stops_[start].position = not_on_path;
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
            loop.side = std::min(loop.side, sides_[end.edge]);
            ++loop.edges;
            loop.length += length(end);
            if (i + 1 < path_.size() || !closed) {
                stops_[stop_of(end.to)].position = not_on_path;
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
    std::uint32_t boundary_count_ = 0;
    std::vector<End> ends_;             ///< two an edge, by vertex
    std::vector<std::uint32_t> sides_;  ///< by boundary edge
    std::vector<bool> used_;
    std::vector<Stop> stops_;  ///< one a vertex of the boundary, ascending
    std::vector<const End*> path_;
    std::vector<Loop> loops_;
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

}  // namespace lamella
