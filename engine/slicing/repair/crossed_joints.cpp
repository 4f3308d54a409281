#include "slicing/repair/crossed_joints.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t no_joint = std::numeric_limits<std::uint64_t>::max();

/// Whether the edge from `c` to `d` meets the joint between the joint's ends, and does not run along it.
bool meets_between_ends(Point from, Point to, Point c, Point d) noexcept {
    return sign_of_side(c, d, from) * sign_of_side(c, d, to) < 0 &&
           sign_of_side(from, to, c) * sign_of_side(from, to, d) <= 0;
}

}  // namespace

void CrossedJoints::add(std::span<const Point> contour, bool closed) {
    pairs_.add({.points = contour, .contour = no_joint, .closed = closed});
}

std::span<const std::uint8_t> CrossedJoints::find(std::span<const Joint> joints, std::size_t free) {
    ends_.clear();
    ends_.reserve(2 * joints.size());
    for (const Joint& joint : joints) {
        ends_.insert(ends_.end(), {joint.from, joint.to});
        pairs_.add({.points = std::span(ends_).last(2), .contour = ends_.size() / 2 - 1, .closed = false});
    }
    crossed_.assign(joints.size(), 0);
    between_joints_.clear();
    pairs_.find(0, no_joint, [&](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        const auto [joint, path, edge] =
            a.contour <= b.contour ? std::tuple(a.contour, &b, j) : std::tuple(b.contour, &a, i);
        if (joint == no_joint ||
            !meets_between_ends(joints[joint].from, joints[joint].to, (*path)[edge], (*path)[edge + 1])) {
            return;
        }
        if (path->contour == no_joint) {
            crossed_[joint] = joint >= free ? 1 : 0;
        } else if (path->contour >= free) {
            between_joints_.emplace_back(static_cast<std::uint32_t>(path->contour), static_cast<std::uint32_t>(joint));
        }
    });
    std::sort(between_joints_.begin(), between_joints_.end());
    for (const auto& [later, earlier] : between_joints_) {
        crossed_[later] |= static_cast<std::uint8_t>(crossed_[earlier] == 0);
    }
    return crossed_;
}

}  // namespace lamella
