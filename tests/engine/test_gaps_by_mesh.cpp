// Gaps closed by a length that the mesh gives, where nothing lies between the ends.
#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/audit/open_layers.hpp"
#include "lamella/prepare.hpp"
#include "lamella/sink.hpp"
#include "rings.hpp"
#include "slicing/repair/crossed_joints.hpp"

using lamella::Joint;
using lamella::Point;
using lamella::SliceResult;

namespace {

/// Whether the edge meets the joint at a place that is no end of the joint, and does not run along it.
bool lies_between(const Joint& joint, Point c, Point d) {
    using rings::side;
    const bool apart = side(joint.from, joint.to, c) * side(joint.from, joint.to, d) > 0;
    return !apart && side(c, d, joint.from) * side(c, d, joint.to) < 0;
}

struct Path {
    std::vector<Point> points;
    bool closed;
};

/// Joint by joint, edge by edge.
std::vector<std::uint8_t> crossed_by_all(const std::vector<Joint>& joints, std::size_t free,
                                         const std::vector<Path>& paths) {
    std::vector<std::uint8_t> crossed(joints.size(), 0);
    for (std::size_t j = free; j < joints.size(); ++j) {
        for (const Path& path : paths) {
            for (std::size_t i = 0; i + (path.closed ? 0 : 1) < path.points.size(); ++i) {
                crossed[j] |= lies_between(joints[j], path.points[i], path.points[(i + 1) % path.points.size()]) ? 1 : 0;
            }
        }
        for (std::size_t before = 0; before < j; ++before) {
            const bool meets = lies_between(joints[before], joints[j].from, joints[j].to);
            crossed[j] |= crossed[before] == 0 && meets ? 1 : 0;
        }
    }
    return crossed;
}

Point random_point(std::mt19937& random, std::uint32_t size) {
    return {static_cast<std::int32_t>(random() % size), static_cast<std::int32_t>(random() % size)};
}

/// A wall of 10 mm from (x0, y0) to (x1, y1), solid on its left.
shapes::Soup wall(double x0, double y0, double x1, double y1) {
    return shapes::joined({shapes::triangle({x0, y0, 0}, {x1, y1, 0}, {x1, y1, 10}),
                           shapes::triangle({x0, y0, 0}, {x1, y1, 10}, {x0, y0, 10})});
}

/// A square tube of a metre whose lower wall lacks what lies between x = 495 and 505.
shapes::Soup cracked_tube() {
    return shapes::joined({wall(0, 0, 495, 0), wall(505, 0, 1000, 0), wall(1000, 0, 1000, 1000), wall(1000, 1000, 0, 1000),
                           wall(0, 1000, 0, 0)});
}

lamella::SliceOptions by_mesh() {
    lamella::SliceOptions options = at_heights({3, 5});
    options.close_gaps_mm = lamella::gaps_by_mesh;
    return options;
}

}  // namespace

TEST_CASE("joints that meet something between their ends are those found edge by edge", "[engine][gaps]") {
    std::mt19937 random(77);
    lamella::CrossedJoints search(nullptr);
    std::size_t found = 0;
    for (int turn = 0; turn < 2000; ++turn) {
        const std::uint32_t size = turn % 2 == 0 ? 8 : 200;  // many touch, or few
        std::vector<Path> paths(random() % 5);
        std::vector<Joint> joints(1 + random() % 8);
        search.clear();
        for (Path& path : paths) {
            path.closed = random() % 2 == 0;
            path.points.resize(1 + random() % 12);
            std::generate(path.points.begin(), path.points.end(), [&] { return random_point(random, size); });
            search.add(path.points, path.closed);
        }
        std::generate(joints.begin(), joints.end(), [&] {
            return Joint{random_point(random, size), random_point(random, size)};
        });
        const std::size_t free = random() % 3;
        const std::span<const std::uint8_t> crossed = search.find(joints, free);
        const std::vector<std::uint8_t> expected = crossed_by_all(joints, free, paths);
        REQUIRE(std::equal(crossed.begin(), crossed.end(), expected.begin(), expected.end()));
        found += static_cast<std::size_t>(std::count(expected.begin(), expected.end(), 1));
    }
    CHECK(found > 1000);
}

TEST_CASE("the mesh's length is a hundredth of its box's diagonal, and closes a crack", "[engine][gaps]") {
    const shapes::Soup tube = cracked_tube();
    const SliceResult closed = sliced(tube, by_mesh());
    CHECK(closed.close_gaps_mm == std::sqrt(1000.0 * 1000 + 1000 * 1000 + 10 * 10) / 100);
    CHECK(closed.summary.open_contours == 0);
    REQUIRE(closed.closed_gaps.size() == 2);
    CHECK(closed.length_mm(closed.closed_gaps[0]) == 10);
    CHECK(closed.area_mm2(closed.layers[0]) == 1e6);
}

TEST_CASE("a gap with a wall in it stays open by the mesh's length, and not by one that is given", "[engine][gaps]") {
    const shapes::Soup tube = shapes::joined({cracked_tube(), wall(500, -5, 500, 5), wall(500, 5, 500, -5)});
    const SliceResult open = sliced(tube, by_mesh());
    CHECK(open.summary.open_contours > 0);
    lamella::SliceOptions given = by_mesh();
    given.close_gaps_mm = 10;
    const SliceResult closed = sliced(tube, given);
    CHECK(std::any_of(closed.closed_gaps.begin(), closed.closed_gaps.end(),
                      [&](const lamella::ClosedGap& gap) { return closed.length_mm(gap) == 10; }));
    CHECK(std::none_of(open.closed_gaps.begin(), open.closed_gaps.end(),
                       [&](const lamella::ClosedGap& gap) { return open.length_mm(gap) == 10; }));
}

TEST_CASE("the length that closes what is left is no shorter than what was closed", "[engine][gaps][open_layers]") {
    const shapes::Soup walled =
        shapes::joined({wall(0, 2000, 495, 2000), wall(501, 2000, 1000, 2000), wall(1000, 2000, 0, 2100),
                        wall(0, 2100, 0, 2000), wall(498, 1990, 498, 2010), wall(498, 2010, 498, 1990)});
    const SliceResult result = sliced(shapes::joined({cracked_tube(), walled}), by_mesh());
    const auto open = lamella::find_open_layers(result);
    REQUIRE(open);
    CHECK(open->layers == 2);
    CHECK(open->reach_mm == Approx(10));
}

TEST_CASE("parts close gaps by their own boxes; a prepared mesh and a sink by the mesh's", "[engine][gaps]") {
    const shapes::Soup tube = cracked_tube();
    const SliceResult whole = sliced(tube, by_mesh());
    const lamella::MeshView mesh = lamella::MeshView::soup(tube);

    lamella::Transform far;
    far.m[3] = 5000;
    const lamella::Part parts[] = {{mesh, {}}, {mesh, far}};
    const auto together = lamella::slice_parts(parts, by_mesh());
    REQUIRE(together);
    CHECK(together->close_gaps_mm == whole.close_gaps_mm);
    CHECK(together->closed_gaps.size() == 4);

    const auto prepared = lamella::prepare(mesh, {.unit_mm = by_mesh().unit_mm});
    REQUIRE(prepared);
    const auto again = lamella::slice(*prepared, by_mesh());
    REQUIRE(again);
    CHECK(lamella::hash_result(*again) == lamella::hash_result(whole));
    CHECK(again->close_gaps_mm == whole.close_gaps_mm);

    std::uint64_t gaps = 0;
    const auto count = [&](const lamella::LayerView& view) noexcept { gaps += view.closed_gaps.size(); };
    const auto totals = lamella::slice_to(lamella::LayerSink::to(count, lamella::SinkOrder::ascending), mesh, by_mesh());
    REQUIRE(totals);
    CHECK(gaps == 2);
    CHECK(totals->close_gaps_mm == whole.close_gaps_mm);
}
