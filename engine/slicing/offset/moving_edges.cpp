#include "slicing/offset/moving_edges.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

#include "base/system/processor.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella {

namespace {

constexpr std::size_t edge_work = 8;           ///< as StopPace counts it
constexpr double fastest_growth = 1e12;        ///< longer than any edge, for each unit
constexpr double fastest_of_miter = 999;       ///< beyond, the miter is not computed: see sharpest_cosine1
constexpr double fastest_after_meeting = 1e6;  ///< what meets at so sharp a corner counts as parallel
constexpr double never = std::numeric_limits<double>::infinity();

double cross(Direction a, Direction b) noexcept {
    return a.x * b.y - a.y * b.x;
}

double dot(Direction a, Direction b) noexcept {
    return a.x * b.x + a.y * b.y;
}

/// Ties go to even numbers.
std::int32_t moved_on_grid(std::int32_t from, double by) noexcept {
    constexpr double just_outside = grid_limit + 1.0;
    constexpr double without_fractions = 0x1.8p52;
    const std::int32_t odd = from & 1;
    const double move = odd + by + tie_room - tie_room;
    const double to = from - odd + (move + without_fractions - without_fractions);
    return round_to_int(std::max(-just_outside, std::min(just_outside, to)));
}

}  // namespace

Point moved_on_grid(Point from, double x, double y) noexcept {
    return {moved_on_grid(from.x, x), moved_on_grid(from.y, y)};
}

void MovingEdges::clear(bool outwards) noexcept {
    edges_.clear();
    events_.clear();
    side_ = outwards ? 1 : -1;
}

void MovingEdges::add(Point from, std::uint32_t point, Direction along, double length, Point miter, bool shrinks) {
    edges_.push_back({.from = from, .miter = miter, .along = along, .end = length, .point = point, .shrinks = shrinks});
}

void MovingEdges::add_at(Point corner, Direction along, bool stands) {
    edges_.push_back({.from = corner, .miter = corner, .along = along, .stands = stands});
}

bool MovingEdges::move(double distance, Vector<Point>& points) {
    distance_ = distance;
    left_ = edges_.size();
    for (std::uint32_t e = 0; e < left_; ++e) {
        edges_[e].before = e > 0 ? e - 1 : static_cast<std::uint32_t>(left_ - 1);
        edges_[e].after = e + 1 < left_ ? e + 1 : 0;
    }
    for (Edge& edge : edges_) {
        Edge& before = edges_[edge.before];
        set_rates(before, edge, (edge.shrinks ? -1 : 1) * growth(before, edge), 0);
    }
    for (std::uint32_t e = 0; e < left_; ++e) {
        schedule(e, 0);
    }
    worker_.spend(edge_work * left_);
    const bool all_stay = events_.empty();
    while (!events_.empty() && left_ > 2) {
        std::pop_heap(events_.begin(), events_.end(), std::greater<>());
        const Event event = events_.back();
        events_.pop_back();
        if (event.distance == edges_[event.edge].vanishes) {
            take_off(event.edge, event.distance);
            worker_.spend(edge_work);
        }
    }
    each_left([&](const Edge& edge) { append_corner(edge, points); });
    return all_stay;
}

/// In their order.
template <class Take>
void MovingEdges::each_left(Take take) const {
    if (left_ > 2) {
        for (const Edge& edge : edges_) {
            if (edge.vanishes >= 0) {
                take(edge);
            }
        }
    }
}

bool MovingEdges::fold(Vector<Point>& points, Vector<std::uint32_t>& numbers) const {
    const std::size_t begin = points.size();
    bool folds = left_ > 2;
    each_left([&](const Edge& edge) {
        const Edge& before = edges_[edge.before];
        if (edge.corner == Corner::given) {
            if (edge.point != no_point) {
                points.push_back(edge.from);
                numbers.push_back(edge.point);
            }
            return;
        }
        const Point corner = place_on(before, before.end, 0);
        folds = folds && edge.corner == Corner::met && is_steady(before) && is_steady(edge) &&
                std::max(std::abs(corner.x), std::abs(corner.y)) <= grid_limit;
        points.push_back(corner);
        numbers.push_back(no_point);
    });
    const std::span<const Point> made = std::span(points).subspan(begin);
    return folds && !made.empty() && made.front() != made.back() &&
           std::adjacent_find(made.begin(), made.end()) == made.end();
}

/// True if the edge, an end of which is rounded, still has its direction before it moves: its ends may slip along it by a
/// few units on the way.
bool MovingEdges::is_steady(const Edge& edge) const noexcept {
    constexpr double slip = 8;
    return edge.point != no_point && (edge.end - edge.begin) * slip >= distance_;
}

Direction MovingEdges::normal_of(const Edge& edge) const noexcept {
    return {side_ * edge.along.y, -side_ * edge.along.x};
}

/// By how much both moved edges become longer at an outer corner, or shorter at an inner one: the tangent of half the turn.
double MovingEdges::growth(const Edge& before, const Edge& after) const noexcept {
    const double sine = std::abs(cross(before.along, after.along));
    const double cosine = dot(before.along, after.along);
    return std::min(cosine > 0 ? sine / (1 + cosine) : (1 - cosine) / sine, fastest_growth);
}

/// From the distance `at` on.
void MovingEdges::set_rates(Edge& before, Edge& after, double rate, double at) const noexcept {
    const double of_before = before.stands ? 1 : (after.stands ? 0 : rate);
    const double of_after = after.stands ? 1 : (before.stands ? 0 : rate);
    before.end += (before.end_rate - of_before) * at;
    after.begin += (after.begin_rate + of_after) * at;
    before.end_rate = of_before;
    after.begin_rate = -of_after;
}

void MovingEdges::schedule(std::uint32_t number, double now) {
    Edge& edge = edges_[number];
    const double rate = edge.end_rate - edge.begin_rate;
    edge.vanishes = rate < 0 ? std::max(now, (edge.begin - edge.end) / rate) : never;
    if (edge.vanishes <= distance_) {
        events_.push_back({edge.vanishes, number});
        std::push_heap(events_.begin(), events_.end(), std::greater<>());
    }
}

/// In an inner corner, as two moved edges do that are followed by one which shrinks between them, unless they have turned by
/// half a turn or more.
bool MovingEdges::neighbours_meet(const Edge& edge) const noexcept {
    const Edge& before = edges_[edge.before];
    const Edge& after = edges_[edge.after];
    return edge.corner != Corner::joint && after.corner != Corner::joint && !before.stands && !after.stands &&
           side_ * cross(before.along, after.along) < 0 && growth(before, after) < fastest_after_meeting;
}

void MovingEdges::take_off(std::uint32_t number, double at) {
    Edge& edge = edges_[number];
    Edge& before = edges_[edge.before];
    Edge& after = edges_[edge.after];
    if (neighbours_meet(edge)) {
        before.after = edge.after;
        after.before = edge.before;
        after.corner = Corner::met;
        set_rates(before, after, -growth(before, after), at);
        schedule(edge.before, at);
        schedule(edge.after, at);
        edge.vanishes = -1;
        --left_;
        return;
    }
    if (edge.begin_rate > 0) {
        make_joint(number, at);
    }
    if (edge.end_rate < 0) {
        make_joint(edge.after, at);
    }
}

/// Of the corner where the edge begins.
void MovingEdges::make_joint(std::uint32_t number, double at) {
    Edge& edge = edges_[number];
    set_rates(edges_[edge.before], edge, 0, at);
    edge.corner = Corner::joint;
    edge.joint_since = at;
    schedule(edge.before, at);
    schedule(number, at);
}

/// The point of the edge, moved by the distance, so far along it.
Point MovingEdges::place_on(const Edge& edge, double along, double distance) const noexcept {
    const Direction normal = normal_of(edge);
    return moved_on_grid(edge.from, along * edge.along.x + distance * normal.x, along * edge.along.y + distance * normal.y);
}

void MovingEdges::append_corner(const Edge& edge, Vector<Point>& points) const {
    const Edge& before = edges_[edge.before];
    const double end = before.end + before.end_rate * distance_;
    if (edge.corner == Corner::given && before.point != no_point && edge.point != no_point &&
        before.end_rate > -fastest_of_miter) {
        points.push_back(edge.miter);
    } else if (before.stands) {
        points.push_back(place_on(edge, edge.begin, distance_));
    } else {
        points.push_back(place_on(before, end, distance_));
    }
    if (edge.corner == Corner::joint) {
        points.push_back(place_on(edge, edge.begin, edge.joint_since));
        points.push_back(place_on(edge, edge.begin, distance_));
    }
}

}  // namespace lamella
