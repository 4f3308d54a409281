// Layers made for tests, and how the oracle nests them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "oracle/oracle.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella::test {

inline int below(std::mt19937& random, int bound) {
    return static_cast<int>(random() % static_cast<unsigned>(bound));
}

inline std::vector<Point> circle(double x, double y, double radius, int count) {
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count;
        const Point p{static_cast<std::int32_t>(std::lround(x + radius * std::cos(angle))),
                      static_cast<std::int32_t>(std::lround(y + radius * std::sin(angle)))};
        if (points.empty() || (p != points.back() && p != points.front())) {
            points.push_back(p);
        }
    }
    return points;
}

inline std::vector<Point> random_walk(std::mt19937& random, int size) {
    std::vector<Point> points;
    const int count = 2 + below(random, 40);
    while (static_cast<int>(points.size()) < count) {
        const Point p{below(random, size), below(random, size)};
        if (points.empty() || (p != points.back() && p != points.front())) {
            points.push_back(p);
        }
    }
    return points;
}

/// The contours of a layer with their points.
class LayerSample {
public:
    void add(std::vector<Point> points, bool closed, std::uint32_t rotate_by = 0) {
        std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(rotate_by % points.size()), points.end());
        contours_.push_back({std::move(points), closed});
    }

    /// Adds a rectangle, clockwise if asked.
    void add_box(Point low, Point high, bool clockwise) {
        std::vector<Point> points{low, {high.x, low.y}, high, {low.x, high.y}};
        if (clockwise) {
            std::reverse(points.begin(), points.end());
        }
        add(std::move(points), true);
    }

    /// Keeps only the first of contours whose points, counted from their starts, are all equal.
    void drop_repeated() {
        std::vector<Contour> kept;
        for (Contour& contour : contours_) {
            const bool repeated = std::any_of(kept.begin(), kept.end(), [&](const Contour& other) {
                return other.closed && contour.closed &&
                       rings::from_smallest(other.points) == rings::from_smallest(contour.points);
            });
            if (!repeated) {
                kept.push_back(std::move(contour));
            }
        }
        contours_ = std::move(kept);
    }

    std::size_t size() const { return contours_.size(); }

    /// The input of Nester::nest. It points into this sample.
    std::vector<NestItem> items() const {
        std::vector<NestItem> items;
        for (const Contour& contour : contours_) {
            const std::vector<Point>& points = contour.points;
            NestItem item;
            item.points = points.data();
            item.count = static_cast<std::uint32_t>(points.size());
            item.closed = contour.closed;
            if (contour.closed) {
                item.start = static_cast<std::uint32_t>(std::min_element(points.begin(), points.end()) - points.begin());
                const rings::Int128 area = rings::twice_area(points);
                item.twice_area = {static_cast<std::uint64_t>(area), static_cast<std::int64_t>(area >> 64)};
                item.box = FlatBox::around(points);
            }
            items.push_back(item);
        }
        return items;
    }

    /// The expected output.
    std::vector<NestItem> expected() const {
        oracle::Layer layer;
        for (const Contour& contour : contours_) {
            oracle::Contour& own = layer.emplace_back();
            own.points = contour.closed ? rings::from_smallest(contour.points) : contour.points;
            own.twice_area = contour.closed ? rings::twice_area(own.points) : 0;
            own.orientation = (own.twice_area > 0) - (own.twice_area < 0);
            own.role = contour.closed ? Role::flat : Role::open;
        }
        const oracle::Layer as_given = layer;
        oracle::find_parents(layer);
        oracle::decide_roles(layer);
        std::vector<NestItem> items = this->items();
        for (std::size_t i = 0; i < items.size(); ++i) {
            items[i].orientation = static_cast<std::int8_t>(layer[i].orientation);
            items[i].role = layer[i].role;
            items[i].flags = static_cast<std::uint16_t>(layer[i].flags);
            items[i].reverse = layer[i].twice_area != as_given[i].twice_area;
            items[i].parent = layer[i].parent;
        }
        return items;
    }

private:
    struct Contour {
        std::vector<Point> points;
        bool closed = false;
    };
    std::vector<Contour> contours_;
};

inline void add_random_contour(LayerSample& sample, std::mt19937& random, int size) {
    const int x = below(random, size);
    const int y = below(random, size);
    const auto turn = static_cast<std::uint32_t>(random());
    switch (below(random, 8)) {
        case 0:
            sample.add(random_walk(random, size), true, turn);
            break;
        case 1:
            sample.add(random_walk(random, size), false);
            break;
        case 2:
            sample.add({{x, y}, {x + 5, y}, {x + 9, y}}, true, turn);
            break;
        case 3:
        case 4:
            sample.add_box({x, y}, {x + 1 + below(random, size), y + 1 + below(random, size)}, below(random, 2) == 0);
            break;
        default: {
            std::vector<Point> points = circle(x, y, 2 + below(random, size), 3 + below(random, 60));
            if (below(random, 2) == 0) {
                std::reverse(points.begin(), points.end());
            }
            sample.add(std::move(points), true, turn);
        }
    }
}

/// A few contours of mixed kinds (nested, touching, equal, crossing, flat, open) on a small grid, so that coordinates
/// often coincide. Some layers hold many contours.
inline LayerSample random_layer(std::mt19937& random) {
    LayerSample sample;
    const int size = 1 + (1 << below(random, 8));
    const int count = below(random, 4) == 0 ? 20 + below(random, 60) : 1 + below(random, 8);
    for (int i = 0; i < count; ++i) {
        add_random_contour(sample, random, size);
    }
    return sample;
}

/// Fills `low` to `high` with contours that nest and touch but do not cross: boxes, and L shapes whose boxes overlap
/// others.
inline void add_nested(LayerSample& sample, std::mt19937& random, Point low, Point high, int depth) {
    if (depth == 0 || high.x - low.x < 4 || high.y - low.y < 4) {
        return;
    }
    const int gap = below(random, 2);  // 0: touches the contour around it
    const bool clockwise = below(random, 2) == 0;
    const Point in_low{low.x + gap, low.y + gap};
    const Point in_high{high.x - gap, high.y - gap};
    const Point mid{in_low.x + 1 + below(random, in_high.x - in_low.x - 1),
                    in_low.y + 1 + below(random, in_high.y - in_low.y - 1)};
    if (below(random, 3) == 0) {
        std::vector<Point> points{in_low, {in_high.x, in_low.y}, {in_high.x, mid.y},
                                  mid,    {mid.x, in_high.y},    {in_low.x, in_high.y}};
        if (clockwise) {
            std::reverse(points.begin(), points.end());
        }
        sample.add(std::move(points), true, static_cast<std::uint32_t>(random()));
    } else {
        sample.add_box(in_low, in_high, clockwise);
    }
    add_nested(sample, random, in_low, mid, depth - 1);
    add_nested(sample, random, mid, in_high, depth - 1);
    add_nested(sample, random, {in_low.x, mid.y}, {mid.x, in_high.y}, depth - 1);
    add_nested(sample, random, {mid.x, in_low.y}, {in_high.x, mid.y}, depth - 1);
}

/// `count` closed contours with `points_each` points, each around the one before it.
inline LayerSample concentric_rings(int count, int points_each) {
    LayerSample sample;
    for (int i = 0; i < count; ++i) {
        std::vector<Point> points = circle(0, 0, 1000.0 + 100.0 * i, points_each);
        if (i % 2 == 1) {
            std::reverse(points.begin(), points.end());
        }
        sample.add(std::move(points), true);
    }
    return sample;
}

/// `count` closed contours with `points_each` points, apart from one another in a square array.
inline LayerSample side_by_side(int count, int points_each) {
    LayerSample sample;
    const int side = static_cast<int>(std::ceil(std::sqrt(count)));
    for (int i = 0; i < count; ++i) {
        sample.add(circle(3000.0 * (i % side), 3000.0 * (i / side), 1000.0 + i % 7, points_each), true);
    }
    return sample;
}

/// Index of the first item whose outputs differ, or -1.
inline int first_difference(const std::vector<NestItem>& a, const std::vector<NestItem>& b) {
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        if (i >= std::min(a.size(), b.size()) || a[i].parent != b[i].parent || a[i].role != b[i].role ||
            a[i].orientation != b[i].orientation || a[i].flags != b[i].flags || a[i].reverse != b[i].reverse) {
            return static_cast<int>(i);
        }
    }
    return -1;
}

}  // namespace lamella::test
