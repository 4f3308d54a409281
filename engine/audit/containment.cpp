#include "audit/containment.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

struct Edge {
    Point from;
    Point to;
    std::size_t contour = 0;

    std::int32_t low() const noexcept { return std::min(from.y, to.y); }
    std::int32_t high() const noexcept { return std::max(from.y, to.y); }
    bool passes_through(Point p) const noexcept {
        return low() <= p.y && p.y <= high() && std::min(from.x, to.x) <= p.x && p.x <= std::max(from.x, to.x) &&
               side_of_line(from, to, p) == 0;
    }
    /// What the edge adds to the winding number about p: the ray from p towards +x, each edge without its upper end.
    int winding_about(Point p) const noexcept {
        if (from.y <= p.y && p.y < to.y) {
            return side_of_line(from, to, p) > 0 ? 1 : 0;
        }
        if (to.y <= p.y && p.y < from.y) {
            return side_of_line(from, to, p) < 0 ? -1 : 0;
        }
        return 0;
    }
};

bool takes_part(const Contour& contour) {
    return contour.role == Role::outer || contour.role == Role::hole;
}

std::vector<Edge> edges_by_low_end(const SliceResult& result, std::span<const Contour> contours) {
    std::vector<Edge> edges;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (!takes_part(contours[c])) {
            continue;
        }
        const std::span<const Point> points = result.points_of(contours[c]);
        for (std::size_t i = 0; i < points.size(); ++i) {
            edges.push_back({points[i], points[i + 1 == points.size() ? 0 : i + 1], c});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.low() < b.low(); });
    return edges;
}

/// Starts of closed contours, lowest y first.
std::vector<std::size_t> queries_by_row(const SliceResult& result, std::span<const Contour> contours) {
    std::vector<std::size_t> queries;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (takes_part(contours[c])) {
            queries.push_back(c);
        }
    }
    const auto row = [&](std::size_t c) { return result.points[contours[c].first_point].y; };
    std::sort(queries.begin(), queries.end(), [&](std::size_t a, std::size_t b) { return row(a) < row(b); });
    return queries;
}

/// Winding numbers about one point after another; resets only what it touched.
class Windings {
public:
    explicit Windings(std::size_t contours) : winding_(contours, 0), through_(contours, 0) {}

    void add(const Edge& edge, Point p) {
        const int winding = edge.winding_about(p);
        const bool through = edge.passes_through(p);
        if (winding != 0 || through) {
            winding_[edge.contour] += winding;
            through_[edge.contour] |= static_cast<char>(through);
            touched_.push_back(edge.contour);
        }
    }

    /// The contours strictly around the point; ready for the next one.
    void take_around(std::vector<std::size_t>& around) {
        around.clear();
        for (const std::size_t c : touched_) {
            if (winding_[c] != 0 && through_[c] == 0) {
                around.push_back(c);
            }
            winding_[c] = 0;
            through_[c] = 1;  // once is enough, though it was touched by many edges
        }
        for (const std::size_t c : touched_) {
            through_[c] = 0;
        }
        touched_.clear();
    }

private:
    std::vector<int> winding_;
    std::vector<char> through_;
    std::vector<std::size_t> touched_;
};

}  // namespace

void for_each_enclosure(const SliceResult& result, const Layer& layer,
                        FunctionRef<void(std::size_t, std::span<const std::size_t>)> visit) {
    const std::span<const Contour> contours = result.contours_of(layer);
    const std::vector<Edge> edges = edges_by_low_end(result, contours);
    std::vector<Edge> row;  // the edges that reach the current query's y
    std::vector<std::size_t> around;
    Windings windings(contours.size());
    std::size_t next = 0;
    for (const std::size_t query : queries_by_row(result, contours)) {
        const Point start = result.points[contours[query].first_point];
        for (; next < edges.size() && edges[next].low() <= start.y; ++next) {
            row.push_back(edges[next]);
        }
        std::erase_if(row, [&](const Edge& edge) { return edge.high() < start.y; });
        for (const Edge& edge : row) {
            windings.add(edge, start);
        }
        windings.take_around(around);
        visit(query, around);
    }
}

}  // namespace lamella
