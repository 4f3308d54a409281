// Convex sets have no point in common where an axis separates them: where all of one lies before all of the other along it.
// Two triangles in different planes are separated by one of their normals, by an axis normal to a side of each, or not at
// all; two in one plane by an axis in the plane and normal to a side. Where an axis leaves them one end in common, and not
// all of both, their insides are apart.
#include "mesh/check/meeting.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdlib>

#include "base/numbers.hpp"
#include "base/sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t next(std::size_t i) {
    return i == 2 ? 0 : i + 1;
}

/// A triangle as it is seen along an axis.
using View = std::array<Point, 3>;
View seen_along(std::size_t axis, const ExactFace& face) noexcept {
    View view;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::array<std::int64_t, 3> numbers = {face.corners[i].x, face.corners[i].y, face.corners[i].z};
        view[i] = {static_cast<std::int32_t>(numbers[next(axis)]), static_cast<std::int32_t>(numbers[next(next(axis))])};
    }
    return view;
}

/// True if a line along one of the first one's sides parts them.
bool has_parting_side(const View& view, const View& other) noexcept {
    const int inside = side_of(view[0], view[1], view[2]);
    for (std::size_t i = 0; i < 3 && inside != 0; ++i) {
        int sides = 0;  // without a branch for each corner
        for (const Point& p : other) {
            sides += side_of(view[i], view[next(i)], p);
        }
        if (sides == -3 * inside) {
            return true;
        }
    }
    return false;
}

/// Faces that lie side by side in a surface are parted as seen along the axis that their normals are nearest to: four in
/// five of those whose boxes meet.
bool are_parted_in_view(const ExactFace& a, const ExactFace& b) noexcept {
    const std::array<std::int64_t, 3> sizes = {std::abs(a.normal.x), std::abs(a.normal.y), std::abs(a.normal.z)};
    const auto axis = static_cast<std::size_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
    const View of_a = seen_along(axis, a);
    const View of_b = seen_along(axis, b);
    return has_parting_side(of_a, of_b) || has_parting_side(of_b, of_a);
}

GridVector side_from(const ExactFace& face, std::size_t corner) {
    return face.corners[next(corner)] - face.corners[corner];
}

/// Of a normal and a difference: up to 92 bits, and 124 in the product with a difference.
struct WideVector {
    Int128 x;
    Int128 y;
    Int128 z;
};
WideVector wide_cross(const GridVector& a, const GridVector& b) {
    return {Int128{a.y} * b.z - Int128{a.z} * b.y, Int128{a.z} * b.x - Int128{a.x} * b.z,
            Int128{a.x} * b.y - Int128{a.y} * b.x};
}
Int128 dot(const WideVector& a, const GridVector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// What the axes so far say of two triangles.
struct Parting {
    bool apart = false;
    bool insides_apart = false;

    template <class Axis>
    void look_along(const Axis& axis, const ExactFace& a, const ExactFace& b) {
        const GridVector& from = a.corners[0];
        const auto [low_a, high_a] =
            std::minmax({Int128{0}, dot(axis, a.corners[1] - from), dot(axis, a.corners[2] - from)});
        const auto [low_b, high_b] =
            std::minmax({dot(axis, b.corners[0] - from), dot(axis, b.corners[1] - from), dot(axis, b.corners[2] - from)});
        apart = apart || low_b > high_a || low_a > high_b;
        // Where both lie in one plane normal to the axis, or there is none, it says nothing.
        insides_apart = insides_apart || ((low_b >= high_a || low_a >= high_b) && (low_a != high_b || low_b != high_a));
    }
};

/// How many corners of a triangle lie above another one's plane, and below it.
struct Sides {
    int above = 0;
    int below = 0;

    Sides(const ExactFace& plane, const ExactFace& face) {
        for (const GridVector& corner : face.corners) {
            const Int128 height = plane.height(corner);
            above += height > 0 ? 1 : 0;
            below += height < 0 ? 1 : 0;
        }
    }
    /// All but those that the triangles share lie on one side.
    bool part(int shared) const { return above + shared == 3 || below + shared == 3; }
};

/// The vertices that two triangles share: how many, and the last of them as a corner of each.
struct Shared {
    int count = 0;
    std::size_t of_a = 0;
    std::size_t of_b = 0;

    Shared(const ExactFace& a, const ExactFace& b) {
        for (std::size_t i = 0; i < 9; ++i) {
            if (a.ids[i / 3] == b.ids[i % 3]) {
                ++count;
                of_a = i / 3;
                of_b = i % 3;
            }
        }
    }
};

/// True if triangles that share one vertex have more than it in common: if the side of `a` opposite to it meets the angle of
/// `b` at it. Else the side lies before the angle, and the angle opens away from it, along one of these axes.
bool meet_beside_vertex(const ExactFace& a, const ExactFace& b, const Shared& shared) {
    const GridVector& apex = a.corners[shared.of_a];
    const std::size_t from = next(shared.of_a);
    const std::size_t arm = next(shared.of_b);
    const GridVector side = side_from(a, from);
    const std::array<GridVector, 2> ends = {a.corners[from] - apex, a.corners[next(from)] - apex};
    const std::array<GridVector, 2> arms = {b.corners[arm] - apex, b.corners[next(arm)] - apex};
    const auto separates = [&](const auto& axis) {
        const std::array<int, 4> signs = {sign_of(dot(axis, ends[0])), sign_of(dot(axis, ends[1])),
                                          sign_of(dot(axis, arms[0])), sign_of(dot(axis, arms[1]))};
        return signs[0] != 0 && signs[0] == signs[1] && signs[0] * signs[2] <= 0 && signs[0] * signs[3] <= 0;
    };
    return !(separates(b.normal) || separates(cross(side, arms[0])) || separates(cross(side, arms[1])) ||
             separates(wide_cross(b.normal, arms[0])) || separates(wide_cross(b.normal, arms[1])) ||
             separates(wide_cross(b.normal, side)));
}

}  // namespace

bool contains(const ExactFace& face, const GridVector& p) noexcept {
    const auto left_of_side = [&](std::size_t i) {
        return dot(wide_cross(face.normal, side_from(face, i)), p - face.corners[i]) >= 0;
    };
    return face.height(p) == 0 && left_of_side(0) && left_of_side(1) && left_of_side(2);
}

Meeting meet(const ExactFace& a, const ExactFace& b) noexcept {
    assert(a.has_area() && b.has_area());
    const Shared shared(a, b);
    if (shared.count == 0 && are_parted_in_view(a, b)) {
        return Meeting::none;
    }
    const Sides of_b(a, b);
    const bool one_plane = of_b.above + of_b.below == 0;
    if (of_b.part(shared.count) || (shared.count == 2 && !one_plane)) {
        return Meeting::none;
    }
    const Sides of_a(b, a);
    if (of_a.part(shared.count) || (shared.count == 1 && !meet_beside_vertex(a, b, shared))) {
        return Meeting::none;
    }
    Parting parting;
    parting.insides_apart = !one_plane && (of_b.above == 0 || of_b.below == 0 || of_a.above == 0 || of_a.below == 0);
    const auto is_known = [&] { return shared.count == 0 ? parting.apart : parting.insides_apart; };
    for (std::size_t i = 0; i < 6 && one_plane && !is_known(); ++i) {
        parting.look_along(wide_cross(a.normal, side_from(i < 3 ? a : b, i % 3)), a, b);
    }
    for (std::size_t i = 0; i < 9 && !one_plane && !is_known(); ++i) {
        parting.look_along(cross(side_from(a, i / 3), side_from(b, i % 3)), a, b);
    }
    if (!parting.insides_apart) {
        return one_plane ? Meeting::overlap : Meeting::cross;
    }
    return parting.apart || shared.count == 2 ? Meeting::none : Meeting::touch;
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
    sort_briefly(points.begin(), points.begin() + 4);
    return {points[1], points[2]};
}

}  // namespace lamella
