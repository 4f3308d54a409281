#include "slicing/measures/feret.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/sort.hpp"
#include "base/vector.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/measures/angle.hpp"

namespace lamella {

namespace {

struct Way {
    std::int64_t x = 0;
    std::int64_t y = 0;
};

Way way_between(Point from, Point to) noexcept {
    return {std::int64_t{to.x} - from.x, std::int64_t{to.y} - from.y};
}

std::uint64_t square_of(const Way& way) noexcept {
    return static_cast<std::uint64_t>(way.x * way.x) + static_cast<std::uint64_t>(way.y * way.y);
}

/// What lies strictly within the octagon of the points that reach farthest in eight directions is not on the hull.
class Octagon {
public:
    explicit Octagon(std::span<const std::span<const Point>> rings) noexcept {
        corners_.fill(rings.front().front());
        for (const std::span<const Point> ring : rings) {
            for (const Point& point : ring) {
                for (std::size_t i = 0; i < ways.size(); ++i) {
                    corners_[i] = reach(i, point) > reach(i, corners_[i]) ? point : corners_[i];
                }
            }
        }
    }

    bool encloses(Point point) const noexcept {
        for (std::size_t i = 0; i < ways.size(); ++i) {
            const Point from = corners_[i];
            const Point to = corners_[(i + 1) % ways.size()];
            if (from != to && side_of(from, to, point) <= 0) {
                return false;
            }
        }
        return corners_[0] != corners_[4] || corners_[2] != corners_[6];
    }

private:
    /// Counter-clockwise, so that corners are in order.
    static constexpr std::array<Way, 8> ways = {{{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

    static std::int64_t reach(std::size_t i, Point p) noexcept { return ways[i].x * p.x + ways[i].y * p.y; }

    std::array<Point, 8> corners_{};
};

/// Counter-clockwise from the smallest point, without points on its edges.
Vector<Point> hull_of(std::span<const std::span<const Point>> rings, Worker& worker) {
    const Octagon octagon(rings);
    Vector<Point> points(worker.memory());
    for (const std::span<const Point> ring : rings) {
        std::copy_if(ring.begin(), ring.end(), std::back_inserter(points), [&](Point p) { return !octagon.encloses(p); });
        worker.spend(ring.size());
    }
    sort_briefly(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    Vector<Point> hull(worker.memory());
    const auto extend = [&](std::size_t first, Point point) {
        while (hull.size() > first + 1 && side_of(hull[hull.size() - 2], hull.back(), point) <= 0) {
            hull.pop_back();
        }
        hull.push_back(point);
    };
    for (const Point& point : points) {  // along the lower side
        extend(0, point);
    }
    const std::size_t upper = hull.size() - 1;
    for (std::size_t i = points.size() - 1; i-- > 0;) {  // and back along the upper one
        extend(upper, points[i]);
    }
    if (hull.size() > 1) {
        hull.pop_back();  // the first again
    }
    return hull;
}

/// The longest way between two points, by its square; of several the one with the smallest angle.
class Longest {
public:
    void offer(Point from, Point to) noexcept {
        Way way = way_between(from, to);
        way = way.x < 0 || (way.x == 0 && way.y < 0) ? Way{-way.x, -way.y} : way;
        const std::uint64_t square = square_of(way);
        if (square > square_ || (square == square_ && way.x * way_.y > way.y * way_.x)) {
            square_ = square;
            way_ = way;
        }
    }
    double length() const noexcept { return std::sqrt(static_cast<double>(square_)); }
    double angle() const noexcept {
        return square_ == 0 ? std::numeric_limits<double>::quiet_NaN()
                            : angle_of_line(static_cast<double>(way_.x), static_cast<double>(way_.y));
    }

private:
    std::uint64_t square_ = 0;
    Way way_;
};

}  // namespace

Feret find_feret(std::span<const std::span<const Point>> rings, Worker& worker) {
    const Vector<Point> hull = hull_of(rings, worker);
    const auto at = [&](std::size_t i) { return hull[i % hull.size()]; };
    Longest longest;
    double least = hull.size() < 3 ? 0 : std::numeric_limits<double>::infinity();
    std::size_t jaw = 1;
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Point from = at(i);
        const Point to = at(i + 1);
        const auto reach = [&](std::size_t j) { return side_of_line(from, to, at(j)); };
        longest.offer(from, at(jaw));
        while (reach(jaw + 1) > reach(jaw)) {
            longest.offer(from, at(++jaw));
        }
        if (hull.size() > 2) {
            const double length = std::sqrt(static_cast<double>(square_of(way_between(from, to))));
            least = std::min(least, static_cast<double>(reach(jaw)) / length);
        }
    }
    return {longest.length(), least, longest.angle()};
}

}  // namespace lamella
