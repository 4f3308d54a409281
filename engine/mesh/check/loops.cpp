// Boundary edges joined end to end.
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
        std::sort(loops_.begin(), loops_.end());
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
