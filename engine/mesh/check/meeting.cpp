// Two triangles in different planes can meet only on the line that the planes share. Where each has corners strictly on both
// sides of the other's plane, each meets the line in a segment, and the segments are compared by determinants (as Guigue and
// Devillers do). Else one of them touches the other's plane with a corner or a side only, and what meets there is decided
// within that plane. Two triangles in one plane are compared within it altogether.
#include "mesh/check/meeting.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "base/numbers.hpp"

namespace lamella {

namespace {

using Sides = std::array<int, 3>;

constexpr std::size_t next(std::size_t i) {
    return i == 2 ? 0 : i + 1;
}
constexpr std::size_t previous(std::size_t i) {
    return i == 0 ? 2 : i - 1;
}

/// The vertices that two triangles share: how many, and the last of them as a corner of each.
struct Shared {
    int count = 0;
    std::size_t of_a = 0;
    std::size_t of_b = 0;
    std::array<bool, 3> corners_of_a{};
    std::array<bool, 3> corners_of_b{};

    Shared(const ExactFace& a, const ExactFace& b) {
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                if (a.ids[i] == b.ids[j]) {
                    ++count;
                    of_a = i;
                    of_b = j;
                    corners_of_a[i] = true;
                    corners_of_b[j] = true;
                }
            }
        }
    }
};

/// On which side of a triangle's plane the other's corners lie, of which some are the triangle's own.
Sides sides_of_plane(const ExactFace& plane, const ExactFace& face, const std::array<bool, 3>& shared) {
    Sides sides{};
    for (std::size_t i = 0; i < 3; ++i) {
        sides[i] = shared[i] ? 0 : sign_of(plane.height(face.corners[i]));
    }
    return sides;
}

bool in_front_or_behind(const Sides& s) {
    return s[0] != 0 && s[0] == s[1] && s[1] == s[2];
}
bool straddles(const Sides& s) {
    return std::min({s[0], s[1], s[2]}) < 0 && std::max({s[0], s[1], s[2]}) > 0;
}

/// Points of a plane, seen along the axis that is least parallel to it.
class PlaneView {
public:
    explicit PlaneView(const GridVector& normal) : axis_(0) {
        const std::array<std::uint64_t, 3> size = {magnitude(normal.x), magnitude(normal.y), magnitude(normal.z)};
        axis_ = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
    }

    /// Orientation of a, b, c.
    int turn(const GridVector& a, const GridVector& b, const GridVector& c) const {
        const GridVector ab = b - a;
        const GridVector ac = c - a;
        return sign_of(u(ab) * v(ac) - v(ab) * u(ac));
    }

    /// Closed segments, not both of them points.
    bool segments_meet(const GridVector& a, const GridVector& b, const GridVector& c, const GridVector& d) const {
        const int cd_a = turn(c, d, a);
        const int cd_b = turn(c, d, b);
        const int ab_c = turn(a, b, c);
        const int ab_d = turn(a, b, d);
        if (cd_a == 0 && cd_b == 0 && ab_c == 0 && ab_d == 0) {
            return ranges_meet(u(a), u(b), u(c), u(d)) && ranges_meet(v(a), v(b), v(c), v(d));
        }
        return cd_a * cd_b <= 0 && ab_c * ab_d <= 0;
    }

    bool is_in(const GridVector& p, const ExactFace& face) const {
        const auto& [a, b, c] = face.corners;
        const Sides turns = {turn(a, b, p), turn(b, c, p), turn(c, a, p)};
        return !straddles(turns);
    }

    bool meets_side(const GridVector& p, const GridVector& q, const ExactFace& face) const {
        const auto& [a, b, c] = face.corners;
        return segments_meet(p, q, a, b) || segments_meet(p, q, b, c) || segments_meet(p, q, c, a);
    }

    /// True if a side of `face` separates it from `other`: then their insides are apart.
    bool side_parts(const ExactFace& face, const ExactFace& other) const {
        const int orientation = turn(face.corners[0], face.corners[1], face.corners[2]);
        for (std::size_t i = 0; i < 3; ++i) {
            const auto outside = [&](const GridVector& p) {
                return turn(face.corners[i], face.corners[next(i)], p) * orientation <= 0;
            };
            if (std::all_of(other.corners.begin(), other.corners.end(), outside)) {
                return true;
            }
        }
        return false;
    }

private:
    static std::uint64_t magnitude(std::int64_t value) { return static_cast<std::uint64_t>(value < 0 ? -value : value); }
    static bool ranges_meet(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
        return std::max(std::min(a, b), std::min(c, d)) <= std::min(std::max(a, b), std::max(c, d));
    }
    std::int64_t u(const GridVector& p) const { return axis_ == 0 ? p.y : p.x; }
    std::int64_t v(const GridVector& p) const { return axis_ == 2 ? p.y : p.z; }

    int axis_;
};

Meeting meet_in_plane(const ExactFace& a, const ExactFace& b, const Shared& shared) {
    const PlaneView view(a.normal);
    if (!view.side_parts(a, b) && !view.side_parts(b, a)) {
        return Meeting::overlap;
    }
    if (shared.count == 2) {
        return Meeting::none;
    }
    // Convex sets that share a vertex and more meet in a segment from it, which ends on a side opposite to it.
    const auto meets_sides_of = [&](const ExactFace& from, std::size_t i, const ExactFace& to) {
        return view.meets_side(from.corners[next(i)], from.corners[previous(i)], to);
    };
    bool touch = meets_sides_of(a, shared.of_a, b) || meets_sides_of(b, shared.of_b, a);
    if (shared.count == 0) {
        touch = touch || meets_sides_of(a, 1, b) || meets_sides_of(a, 2, b);
    }
    return touch ? Meeting::touch : Meeting::none;
}

/// The corner that the plane separates from the other two, of which one may lie on the plane.
std::size_t lone_corner(const Sides& s) {
    for (std::size_t i = 0; i < 3; ++i) {
        if (s[i] != 0 && s[next(i)] != s[i] && s[previous(i)] != s[i]) {
            return i;
        }
    }
    assert(false);
    return 0;
}

/// Where the line leaves `a` (in two points, P and Q, on the sides at its lone corner), they are either within the angle at
/// b's lone corner or not: for each side of that angle, whether P or Q lies inside of it (1), else on it (0).
///
///     b0 ----- b1        The line of the planes crosses both sides of the angle;
///       \   P . . Q      what lies between them is b's segment.
///        b2
Meeting meet_on_line(const ExactFace& a, const Sides& a_sides, const ExactFace& b, const Sides& b_sides,
                     const Shared& shared) {
    const std::size_t i = lone_corner(a_sides);
    const std::size_t j = lone_corner(b_sides);
    const GridVector& apex = a.corners[i];
    const auto innermost = [&](std::size_t to, int hand) {
        const auto place = [&](std::size_t corner) {
            return side_of(b.corners[j], b.corners[to], a.corners[corner], apex) * a_sides[i] * hand;
        };
        return std::max(place(next(i)), place(previous(i)));
    };
    const int inner = std::min(innermost(next(j), 1), innermost(previous(j), -1));
    if (inner > 0) {
        return Meeting::cross;
    }
    return inner == 0 && shared.count == 0 ? Meeting::touch : Meeting::none;
}

/// `a` reaches b's plane with corners or a side only.
Meeting meet_at_plane(const ExactFace& a, const Sides& a_sides, const ExactFace& b, const Shared& shared, std::size_t of_a,
                      std::size_t of_b) {
    const PlaneView view(b.normal);
    std::array<GridVector, 2> reached;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        if (a_sides[i] == 0 && (shared.count == 0 || i != of_a)) {
            reached[count++] = a.corners[i];
        }
    }
    if (count == 0) {
        return Meeting::none;
    }
    bool touch = view.is_in(reached[0], b);
    if (count == 2) {
        touch = touch || view.meets_side(reached[0], reached[1], b);
    } else if (shared.count == 1) {
        touch = touch || view.segments_meet(reached[0], a.corners[of_a], b.corners[next(of_b)], b.corners[previous(of_b)]);
    }
    return touch ? Meeting::touch : Meeting::none;
}

/// True if the corners of `face` but the common ones lie on one side of the plane. In double: with u = 2^-53, the normal and
/// its products with the differences, which are exact, and their sums are off by less than 5 u of `products` by the
/// differences.
bool lies_beside(const RealFace& plane, const RealFace& face, unsigned common) noexcept {
    unsigned in_front = common;  // bits again, as no predictor knows which corner lies where
    unsigned behind = common;
    for (std::size_t i = 0; i < 3; ++i) {
        double height = 0;
        double error = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double from = face.corners[i][axis] - plane.corners[0][axis];
            height += plane.normal[axis] * from;
            error += plane.products[axis] * std::abs(from);
        }
        error *= 0x1p-50;
        in_front |= (height > error ? 1U : 0U) << i;
        behind |= (height < -error ? 1U : 0U) << i;
    }
    return in_front == 7 || behind == 7;
}

}  // namespace

RealFace::RealFace(const std::array<std::uint32_t, 3>& vertex_ids, const std::array<GridVertex, 3>& vertices) noexcept
    : ids(vertex_ids) {
    for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = {static_cast<double>(vertices[i].x), static_cast<double>(vertices[i].y),
                      static_cast<double>(vertices[i].z)};
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = next(axis);
        const std::size_t v = previous(axis);
        const double first = (corners[1][u] - corners[0][u]) * (corners[2][v] - corners[0][v]);
        const double second = (corners[1][v] - corners[0][v]) * (corners[2][u] - corners[0][u]);
        normal[axis] = first - second;
        products[axis] = std::abs(first) + std::abs(second);
    }
}

bool are_apart(const RealFace& a, const RealFace& b) noexcept {
    unsigned common_of_a = 0;  // a bit a corner
    unsigned common_of_b = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            const unsigned same = a.ids[i] == b.ids[j] ? 1 : 0;
            common_of_a |= same << i;
            common_of_b |= same << j;
        }
    }
    return lies_beside(a, b, common_of_b) || lies_beside(b, a, common_of_a);
}

bool contains(const ExactFace& face, const GridVector& p) noexcept {
    return face.height(p) == 0 && PlaneView(face.normal).is_in(p, face);
}

Meeting meet(const ExactFace& a, const ExactFace& b) noexcept {
    assert(a.has_area() && b.has_area());
    const Shared shared(a, b);
    if (shared.count == 3) {
        return Meeting::none;
    }
    const Sides b_sides = sides_of_plane(a, b, shared.corners_of_b);
    if (in_front_or_behind(b_sides)) {
        return Meeting::none;
    }
    if (b_sides == Sides{}) {
        return meet_in_plane(a, b, shared);
    }
    if (shared.count == 2) {  // the common edge lies on the line that the planes share
        return Meeting::none;
    }
    const Sides a_sides = sides_of_plane(b, a, shared.corners_of_a);
    if (in_front_or_behind(a_sides)) {
        return Meeting::none;
    }
    if (!straddles(a_sides)) {
        return meet_at_plane(a, a_sides, b, shared, shared.of_a, shared.of_b);
    }
    if (!straddles(b_sides)) {
        return meet_at_plane(b, b_sides, a, shared, shared.of_b, shared.of_a);
    }
    return meet_on_line(a, a_sides, b, b_sides, shared);
}

std::array<std::array<double, 3>, 2> crossing_segment(const ExactFace& a, const ExactFace& b) noexcept {
    std::array<std::array<double, 3>, 6> points{};
    std::size_t count = 0;
    const auto add_ends = [&](const ExactFace& face, const ExactFace& plane) {
        for (std::size_t i = 0; i < 3; ++i) {
            const GridVector& p = face.corners[i];
            const GridVector& q = face.corners[next(i)];
            const auto from = static_cast<double>(plane.height(p));
            const auto to = static_cast<double>(plane.height(q));
            if (from == 0 || from * to < 0) {
                const double share = from / (from - to);
                points[count++] = {static_cast<double>(p.x) + share * static_cast<double>(q.x - p.x),
                                   static_cast<double>(p.y) + share * static_cast<double>(q.y - p.y),
                                   static_cast<double>(p.z) + share * static_cast<double>(q.z - p.z)};
            }
        }
    };
    add_ends(a, b);
    add_ends(b, a);
    assert(count == 4);  // two segments on the line have four ends; the middle two bound what they share
    std::sort(points.begin(), points.begin() + 4);
    return {points[1], points[2]};
}

}  // namespace lamella
