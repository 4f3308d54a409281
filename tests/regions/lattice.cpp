#include "regions/lattice.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

namespace regions {

using lamella::FillRule;

namespace {

enum Quarter : std::size_t { south, east, north, west };

constexpr std::array<Point, 8> directions{{{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

/// The other end of the side that leaves a point in this direction: sides along the lattice are two half cells long.
Point end_of_side(Point from, std::size_t direction) {
    const std::int32_t length = direction % 2 == 0 ? 2 : 1;
    return {from.x + length * directions[direction].x, from.y + length * directions[direction].y};
}

/// Sides of triangles with a solid on their left and none on their right.
class Sides {
public:
    void add(Point from, std::size_t direction, std::size_t solid) { from_[from][direction] = {true, false, solid}; }

    /// Follows every side once, and calls take(corners, solid) for each closed walk.
    template <class Take>
    void follow(const Take& take) {
        for (auto& [point, sides] : from_) {
            for (std::size_t direction = 0; direction < directions.size(); ++direction) {
                if (sides[direction].exists && !sides[direction].used) {
                    take(walk(point, direction), sides[direction].solid);
                }
            }
        }
    }

private:
    struct Side {
        bool exists = false;
        bool used = false;
        std::size_t solid = 0;
    };

    Polygon walk(Point at, std::size_t direction) {
        Polygon points;
        const std::size_t solid = from_[at][direction].solid;
        while (!from_[at][direction].used) {
            from_[at][direction].used = true;
            points.push_back(at);
            at = end_of_side(at, direction);
            const std::array<Side, 8>& leaving = from_.at(at);
            std::size_t next = (direction + 3) % 8;  // clockwise from where it came
            while (!leaving[next].exists) {
                next = (next + 7) % 8;
            }
            if (leaving[next].solid != solid) {
                throw std::logic_error("a walk goes from one solid to another");
            }
            direction = next;
        }
        return points;
    }

    std::map<Point, std::array<Side, 8>> from_;
};

/// A point within a triangle, in quarters of a cell.
Point within(std::int32_t x, std::int32_t y, std::size_t quarter) {
    constexpr std::array<Point, 4> at{{{2, 1}, {3, 2}, {2, 3}, {1, 2}}};
    return {4 * x + at[quarter].x, 4 * y + at[quarter].y};
}

/// Winding number of a polygon on the lattice around a point in quarters of a cell that lies on no edge.
int winding_of(const Polygon& polygon, Point q) {
    int number = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point& a = polygon[i];
        const Point& b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        if ((4 * a.y > q.y) != (4 * b.y > q.y)) {
            // At 45 degrees or upright: x changes by as much as y, or not at all.
            const std::int32_t slope = a.x == b.x ? 0 : ((a.x < b.x) == (a.y < b.y) ? 1 : -1);
            if (4 * a.x + slope * (q.y - 4 * a.y) > q.x) {
                number += b.y > a.y ? 1 : -1;
            }
        }
    }
    return number;
}

std::int32_t draw(std::mt19937& random, std::int32_t low, std::int32_t high) {
    return low + static_cast<std::int32_t>(random() % static_cast<unsigned>(high - low + 1));
}

bool one_in(std::mt19937& random, unsigned times) {
    return random() % times == 0;
}

Polygon random_walk(std::mt19937& random, std::int32_t size) {
    Polygon points{{draw(random, 0, size), draw(random, 0, size)}};
    for (std::int32_t steps = draw(random, 2, 10); steps > 0; --steps) {
        const Point way = directions[random() % directions.size()];
        const std::int32_t length = draw(random, 1, size);
        Point to = points.back();
        for (std::int32_t i = 0; i < length; ++i) {
            const Point next{to.x + way.x, to.y + way.y};
            if (next.x < 0 || next.y < 0 || next.x > size || next.y > size) {
                break;
            }
            to = next;
            if (one_in(random, 8)) {
                points.push_back(to);
            }
        }
        points.push_back(to);
    }
    const Point last = points.back();
    const std::int32_t dx = points.front().x - last.x;
    const std::int32_t dy = points.front().y - last.y;
    const std::int32_t across = std::min(std::abs(dx), std::abs(dy));
    points.push_back({last.x + (dx < 0 ? -across : across), last.y + (dy < 0 ? -across : across)});
    return points;
}

Polygon random_rectangle(std::mt19937& random, std::int32_t size) {
    const std::int32_t x0 = draw(random, 0, size - 1);
    const std::int32_t y0 = draw(random, 0, size - 1);
    const std::int32_t x1 = draw(random, x0 + 1, size);
    const std::int32_t y1 = draw(random, y0 + 1, size);
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

/// Two of its sides leave a corner in neighbouring directions, at 45 degrees to each other.
Polygon random_triangle(std::mt19937& random, std::int32_t size) {
    const Point corner{draw(random, 0, size), draw(random, 0, size)};
    const std::size_t direction = random() % directions.size();
    const std::int32_t length = draw(random, 1, (size + 1) / 2);
    Polygon points{corner};
    for (const std::size_t side : {direction, (direction + 1) % directions.size()}) {
        const auto within = [&](std::int32_t value) { return value >= 0 && value <= size; };
        points.push_back({corner.x + length * directions[side].x, corner.y + length * directions[side].y});
        if (!within(points.back().x) || !within(points.back().y)) {
            return random_rectangle(random, size);
        }
    }
    return points;
}

Polygon random_shape(std::mt19937& random, std::int32_t size) {
    switch (random() % 5) {
        case 0:
            return random_rectangle(random, size);
        case 1:
            return random_triangle(random, size);
        default:
            return random_walk(random, size);
    }
}

}  // namespace

Lattice::Lattice(const Polygons& polygons, std::int32_t size) : size_(size) {
    for (std::int32_t y = -1; y <= size; ++y) {
        for (std::int32_t x = -1; x <= size; ++x) {
            for (std::size_t quarter = 0; quarter < 4; ++quarter) {
                std::int64_t winding = 0;
                for (const Polygon& polygon : polygons) {
                    winding += winding_of(polygon, within(x, y, quarter));
                }
                winding_.push_back(winding);
            }
        }
    }
}

std::size_t Lattice::triangle(std::int32_t x, std::int32_t y, std::size_t quarter) const {
    return (static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(size_ + 2) + static_cast<std::size_t>(x + 1)) * 4 +
           quarter;
}

std::vector<char> Lattice::filled(FillRule rule) const {
    std::vector<char> filled;
    for (const std::int64_t winding : winding_) {
        filled.push_back(fills(rule, winding) ? 1 : 0);
    }
    return filled;
}

std::vector<std::size_t> Lattice::beside(std::size_t triangle) const {
    const std::size_t row = 4 * static_cast<std::size_t>(size_ + 2);
    const std::size_t quarter = triangle % 4;
    const std::size_t cell = triangle - quarter;
    std::vector<std::size_t> found{cell + (quarter + 1) % 4, cell + (quarter + 3) % 4};
    const std::size_t column = cell % row / 4;
    const std::size_t last = static_cast<std::size_t>(size_) + 1;
    if (quarter == south && cell >= row) {
        found.push_back(cell - row + north);
    } else if (quarter == north && cell + row < winding_.size()) {
        found.push_back(cell + row + south);
    } else if (quarter == east && column < last) {
        found.push_back(cell + 4 + west);
    } else if (quarter == west && column > 0) {
        found.push_back(cell - 4 + east);
    }
    return found;
}

std::vector<std::size_t> Lattice::solids(const std::vector<char>& filled) const {
    std::vector<std::size_t> solid_of(filled.size(), 0);
    std::size_t solids = 0;
    for (std::size_t seed = 0; seed < filled.size(); ++seed) {
        if (filled[seed] == 0 || solid_of[seed] != 0) {
            continue;
        }
        std::vector<std::size_t> open{seed};
        solid_of[seed] = ++solids;
        while (!open.empty()) {
            const std::size_t at = open.back();
            open.pop_back();
            for (const std::size_t next : beside(at)) {
                if (filled[next] != 0 && solid_of[next] == 0) {
                    solid_of[next] = solids;
                    open.push_back(next);
                }
            }
        }
    }
    return solid_of;
}

Region Lattice::region(FillRule rule) const {
    const std::vector<std::size_t> solid_of = solids(filled(rule));
    Sides sides;
    // `left` and `right` of the side from `from` in `direction`.
    const auto add = [&](Point from, std::size_t direction, std::size_t left, std::size_t right) {
        if (solid_of[left] != 0 && solid_of[right] == 0) {
            sides.add(from, direction, solid_of[left]);
        } else if (solid_of[left] == 0 && solid_of[right] != 0) {
            sides.add(end_of_side(from, direction), (direction + 4) % 8, solid_of[right]);
        }
    };
    for (std::int32_t y = 0; y <= size_; ++y) {
        for (std::int32_t x = 0; x <= size_; ++x) {
            const std::array<std::size_t, 4> t{triangle(x, y, south), triangle(x, y, east), triangle(x, y, north),
                                               triangle(x, y, west)};
            add({2 * x, 2 * y}, 0, t[south], triangle(x, y - 1, north));
            add({2 * x, 2 * y}, 2, triangle(x - 1, y, east), t[west]);
            add({2 * x, 2 * y}, 1, t[west], t[south]);
            add({2 * x + 2, 2 * y}, 3, t[south], t[east]);
            add({2 * x + 2, 2 * y + 2}, 5, t[east], t[north]);
            add({2 * x, 2 * y + 2}, 7, t[north], t[west]);
        }
    }
    Region region;
    std::vector<std::size_t> solid_of_ring;
    sides.follow([&](Polygon points, std::size_t solid) {
        region.push_back({std::move(points), false, -1});
        solid_of_ring.push_back(solid);
    });
    find_parents(region, solid_of_ring);
    return canonical(rule == FillRule::outermost ? without_holes(region) : region);
}

Polygons random_octilinear(std::mt19937& random, std::int32_t size) {
    Polygons polygons;
    for (std::int32_t count = draw(random, 1, 6); count > 0; --count) {
        if (!polygons.empty() && one_in(random, 6)) {
            polygons.push_back(polygons[random() % polygons.size()]);
        } else {
            polygons.push_back(random_shape(random, size));
        }
        if (one_in(random, 3)) {
            std::reverse(polygons.back().begin(), polygons.back().end());
        }
    }
    return polygons;
}

Polygons Placement::placed(const Polygons& on_lattice) const {
    Polygons polygons = on_lattice;
    for (Polygon& polygon : polygons) {
        for (Point& point : polygon) {
            point = half({2 * point.x, 2 * point.y});
        }
    }
    return polygons;
}

Region Placement::placed(Region in_half_cells) const {
    for (Ring& ring : in_half_cells) {
        for (Point& corner : ring.corners) {
            corner = half(corner);
        }
    }
    return in_half_cells;
}

Placement random_placement(std::mt19937& random, std::int32_t size) {
    constexpr std::array<std::int32_t, 4> largest{2, 3, 1'000, 1 << 24};
    const std::int32_t half_cell = draw(random, 2, largest[random() % largest.size()]);
    const std::int32_t room = lamella::grid_limit - 2 * size * half_cell;
    const auto place = [&] { return one_in(random, 4) ? room : draw(random, -1'000'000, 1'000'000); };
    return {half_cell, {place(), place()}};
}

std::string judge_octilinear(const Polygons& on_lattice, std::int32_t size, const Placement& placement,
                             std::mt19937& random) {
    const Lattice lattice(on_lattice, size);
    const Polygons polygons = placement.placed(on_lattice);
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive, FillRule::outermost}) {
        lamella::RegionRules rules;
        rules.fill_rule = rule;
        rules.drop_collinear = one_in(random, 2);
        const lamella::LayerContours found = region_of(polygons, rules);
        std::string fault = fault_in(found);
        if (fault.empty()) {
            fault = difference(placement.placed(lattice.region(rule)), region_in(found));
        }
        if (fault.empty()) {
            fault = dependence_on_order(polygons, rules, found, random);
        }
        if (!fault.empty()) {
            return std::string(lamella::name_of(rule)) + ": " + fault + "\nof " + text_of(polygons);
        }
    }
    return "";
}

}  // namespace regions
