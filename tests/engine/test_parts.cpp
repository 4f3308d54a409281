// Several meshes in one result.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/shapes.hpp"
#include "engine/slicing.hpp"

using lamella::Contour;
using lamella::ErrorCode;
using lamella::FillRule;
using lamella::Part;
using lamella::SliceOptions;
using lamella::SliceResult;

namespace {

/// Requires success and a valid result.
SliceResult together(const std::vector<Part>& parts, const SliceOptions& options) {
    lamella::Result<SliceResult> result = slice_parts(parts, options);
    INFO((result ? std::string() : result.error().message));
    REQUIRE(result.ok());
    const lamella::Status valid = validate(*result);
    INFO((valid ? std::string() : valid.error().message));
    REQUIRE(valid.ok());
    return std::move(result).value();
}

lamella::Error parts_failure(const std::vector<Part>& parts, const SliceOptions& options) {
    const lamella::Result<SliceResult> result = slice_parts(parts, options);
    REQUIRE_FALSE(result.ok());
    return result.error();
}

Part part_of(const shapes::Soup& soup, const lamella::Transform& transform = {}) {
    return {view_of(soup), transform};
}

lamella::Transform moved_by(double x, double y, double z) {
    lamella::Transform transform;
    transform.m[3] = x;
    transform.m[7] = y;
    transform.m[11] = z;
    return transform;
}

using Names = std::vector<std::uint32_t>;

Names parts_in(const SliceResult& result, std::size_t layer) {
    Names parts;
    for (const Contour& contour : result.contours_of(result.layers[layer])) {
        parts.push_back(contour.part);
    }
    return parts;
}

/// The layers' contours of one part, as lines; see contours_at().
std::vector<std::string> lines_of_part(const SliceResult& result, std::size_t layer, std::uint32_t part) {
    const std::vector<std::string> all = contours_at(result, layer);
    const std::span<const Contour> contours = result.contours_of(result.layers[layer]);
    std::vector<std::string> own;
    for (std::size_t c = 0; c < all.size(); ++c) {
        if (contours[c].part == part && contours[c].parent < 0) {
            own.push_back(all[c]);
        }
    }
    return own;
}

}  // namespace

TEST_CASE("the contours of parts that overlap lie side by side", "[engine][parts]") {
    const shapes::Soup tube =
        shapes::joined({shapes::box({0, 0, 0}, {10, 10, 10}), shapes::flipped(shapes::box({2, 2, 0}, {8, 8, 10}))});
    const shapes::Soup cube = shapes::box({-4, 4, 0}, {4, 6, 20});
    const SliceResult result = together({part_of(tube), part_of(cube)}, at_heights({5, 15, 25}));
    CHECK(result.part_count == 2);
    CHECK(contours_at(result, 0) == std::vector<std::string>{"outer + x8 in -: 0,0 11,0 20,0 20,11 20,20 11,20 0,20 0,11",
                                                             "hole - x8 in 0: 4,4 4,10 4,16 10,16 16,16 16,10 16,4 10,4",
                                                             "outer + x8 in -: -8,8 0,8 8,8 8,10 8,12 0,12 -8,12 -8,10"});
    CHECK(parts_in(result, 0) == Names{0, 0, 1});
    CHECK(parts_in(result, 1) == Names{1});
    CHECK(parts_in(result, 2).empty());
    CHECK(result.layers[0].segments == 24);
    CHECK(result.area_mm2(result.layers[0]) == 64 + 16);
    CHECK(result.summary.triangles == 36);
    CHECK(result.summary.min_mm[0] == -4);
    CHECK(result.summary.max_mm[2] == 20);
}

TEST_CASE("planes and grid are those of the box around all parts", "[engine][parts]") {
    const shapes::Soup low = shapes::box({0, 0, 0}, {4, 4, 1});
    const shapes::Soup high = shapes::box({0, 0, 2.1}, {1500, 4, 3});
    const SliceResult result = together({part_of(high), part_of(low)}, uniform(0.2));
    CHECK(result.unit_mm == 2 * lamella::default_unit_mm);
    REQUIRE(result.layers.size() == 15);
    const SliceResult whole = sliced(shapes::joined({high, low}), uniform(0.2));
    REQUIRE(whole.layers.size() == 15);
    for (std::size_t l = 0; l < 15; ++l) {
        CHECK(result.layers[l].plane == whole.layers[l].plane);
        CHECK(result.layers[l].bottom_mm == whole.layers[l].bottom_mm);
        CHECK(result.layers[l].segments == whole.layers[l].segments);
        CHECK(contours_at(result, l) == contours_at(whole, l));  // they never share a layer
    }
    CHECK(parts_in(result, 0) == Names{1});
    CHECK(parts_in(result, 14) == Names{0});
    // Its far end is at the grid's very limit, which a grid chosen by the mesh takes.
    const shapes::Soup far = shapes::box({0, 0, 0}, {1024, 4, 1});
    CHECK(together({part_of(far), part_of(low)}, uniform(0.5)).unit_mm == lamella::default_unit_mm);
    CHECK(together({part_of(low), part_of(low)}, uniform(0.5, lamella::unit_by_box)).unit_mm ==
          sliced(low, uniform(0.5, lamella::unit_by_box)).unit_mm);
}

TEST_CASE("one part gives the bytes of slice()", "[engine][parts]") {
    const shapes::Soup soup = shapes::octasphere({1, 2, 3}, 10, 4);
    const std::vector<float> floats = shapes::floats(soup);
    SliceOptions options = uniform(0.1);
    options.transform = GENERATE(lamella::Transform{}, lamella::Transform::from_normal(1, 2, 3));
    for (const lamella::MeshView& mesh : {view_of(soup), lamella::MeshView::soup(std::span<const float>(floats))}) {
        const SliceResult alone = sliced(mesh, options);
        CHECK(hash_result(together({{mesh, {}}}, options)) == hash_result(alone));
        SliceOptions rest = options;
        rest.transform = {};
        const SliceResult moved = together({{mesh, options.transform}}, rest);
        CHECK(hash_result(moved) == hash_result(alone));
        CHECK(moved.frame.is_identity());
        CHECK(moved.layers.size() == alone.layers.size());
    }
}

TEST_CASE("a result of parts does not depend on threads", "[engine][parts][threads]") {
    const shapes::Soup first = shapes::octasphere({0, 0, 0}, 10, 4);
    const shapes::Soup second = shapes::random_tetrahedra(3, 40, 12);
    const std::vector<Part> parts = {part_of(first), part_of(second), part_of(first, moved_by(3, 1, 2.03))};
    SliceOptions options = uniform(0.05);
    options.region.fill_rule = GENERATE(FillRule::contours, FillRule::positive);
    options.control.threads = 1;
    const SliceResult expected = together(parts, options);
    for (const int threads : {2, 5}) {
        options.control.threads = threads;
        CHECK(hash_result(together(parts, options)) == hash_result(expected));
    }
    CHECK(hash_result(together({parts[2], parts[1], parts[0]}, options)) != hash_result(expected));
}

TEST_CASE("rules are done to each part by itself", "[engine][parts]") {
    // Two cubes that overlap are one region where they are one part, and two where they are two.
    const shapes::Soup left = shapes::box({0, 0, 0}, {10, 10, 10});
    const shapes::Soup right = shapes::box({5, 0, 0}, {15, 10, 10});
    SliceOptions options = at_heights({5});
    options.region.fill_rule = FillRule::non_zero;
    const shapes::Soup both = shapes::joined({left, right});
    const SliceResult joined = together({part_of(both), part_of(right)}, options);
    CHECK(parts_in(joined, 0) == Names{0, 1});
    CHECK(joined.area_mm2(joined.layers[0]) == 150 + 100);
    const SliceResult apart = together({part_of(left), part_of(right)}, options);
    CHECK(lines_of_part(apart, 0, 1) == contours_at(sliced(right, options), 0));
    CHECK(apart.region.fill_rule == FillRule::non_zero);
    CHECK(apart.area_mm2(apart.layers[0]) == 200);
}

TEST_CASE("equal parts keep a contour each, and gaps are listed by layer", "[engine][parts]") {
    shapes::Soup open = shapes::box({0, 0, 0}, {10, 10, 10});
    open.erase(open.begin() + 9 * 4, open.begin() + 9 * 6);  // no front
    SliceOptions options = at_heights({2, 5});
    options.close_gaps_mm = 20;
    const SliceResult result = together({part_of(open), part_of(open)}, options);
    CHECK(parts_in(result, 1) == Names{0, 1});
    REQUIRE(result.closed_gaps.size() == 4);
    CHECK(result.closed_gaps[1].layer == 0);
    CHECK(result.closed_gaps[2].layer == 1);
    CHECK(result.close_gaps_mm == 20);
}

TEST_CASE("what is wrong with a part is said of that part", "[engine][parts]") {
    const shapes::Soup good = shapes::box({0, 0, 0}, {4, 4, 4});
    shapes::Soup bad = good;
    bad[40] = std::nan("");
    CHECK(parts_failure({}, uniform(1)).code == ErrorCode::invalid_argument);
    const lamella::Error coordinate = parts_failure({part_of(good), part_of(bad)}, uniform(1));
    CHECK(coordinate.code == ErrorCode::bad_coordinate);
    CHECK_THAT(coordinate.message, Catch::StartsWith("part 1: triangle 4, "));
    CHECK(coordinate.triangle == 4);
    CHECK(parts_failure({part_of(good), part_of({})}, uniform(1)).message == "part 1: the mesh has no triangles");
    const shapes::Soup dust = shapes::box({0, 0, 0}, {1e-9, 1e-9, 1e-9});
    const lamella::Error collapsed = parts_failure({part_of(dust), part_of(good)}, uniform(1));
    CHECK(collapsed.code == ErrorCode::empty_mesh);
    CHECK_THAT(collapsed.message, Catch::StartsWith("part 0: each of 12 triangles has"));
    CHECK(parts_failure({part_of(good)}, uniform(-1)).message == "the layer height must be positive");
    SliceOptions closing = uniform(1);
    closing.region.close_mm = -1;
    CHECK_THAT(parts_failure({part_of(bad)}, closing).message, Catch::StartsWith("the closing radius"));
}

TEST_CASE("the memory limit is for all parts", "[engine][parts][errors]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 4, 100});
    SliceOptions options = uniform(0.01);
    const std::uint64_t contents = 10'000 * (8 * sizeof(lamella::Point) + sizeof(Contour));
    const std::uint64_t layers = 10'000 * sizeof(lamella::Layer);
    options.memory_limit_bytes = layers + 2 * contents;
    CHECK(together({part_of(soup), part_of(soup)}, options).contours.size() == 20'000);
    --options.memory_limit_bytes;
    CHECK(parts_failure({part_of(soup), part_of(soup)}, options).code == ErrorCode::result_too_large);
    CHECK(together({part_of(soup)}, options).contours.size() == 10'000);
}

TEST_CASE("slicing parts takes memory from the host, gives it back, and can be stopped", "[engine][parts][cancel]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    const std::vector<Part> parts = {part_of(soup), part_of(soup, moved_by(1, 1, 1))};
    SliceOptions options = uniform(0.05);
    for (std::size_t limit = 1 << 10; limit < (std::size_t{1} << 25); limit *= 2) {
        CountingMemory memory(limit);
        options.control.memory = &memory;
        {
            const lamella::Result<SliceResult> result = slice_parts(parts, options);
            CHECK((result.ok() || result.error().code == ErrorCode::out_of_memory));
            CHECK(result.ok() == (limit > (1 << 23)));
        }
        CHECK(memory.held() == 0);
    }
    options.control.memory = nullptr;
    std::vector<double> seen;
    std::atomic<bool> stop = false;
    options.control.stop = lamella::StopCheck::when(stop);
    const auto note = [&](double done) noexcept { seen.push_back(done); };
    options.control.progress = lamella::Progress::to(note);
    (void)together(parts, options);
    CHECK(std::is_sorted(seen.begin(), seen.end()));
    CHECK(seen.back() == 1);
    CHECK(std::any_of(seen.begin(), seen.end(), [](double done) { return done > 0.2 && done < 0.4; }));
    const auto stop_late = [&](double done) noexcept { stop = done > 0.6; };  // in the second part
    options.control.progress = lamella::Progress::to(stop_late);
    CHECK(parts_failure(parts, options).code == ErrorCode::cancelled);
}

TEST_CASE("a broken order of parts is found", "[engine][parts][validate]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    const auto damaged = [&](void (*damage)(SliceResult&)) {
        SliceResult result = together({part_of(cube), part_of(cube, moved_by(20, 0, 0)), part_of(cube)}, at_heights({5}));
        damage(result);
        const lamella::Status status = validate(result);
        return status ? std::string("valid") : status.error().message;
    };
    CHECK(damaged([](SliceResult&) {}) == "valid");
    CHECK_THAT(damaged([](SliceResult& r) { r.part_count = 2; }), Catch::Contains("the part is none"));
    CHECK_THAT(damaged([](SliceResult& r) { r.contours[2].part = 0; }), Catch::Contains("not in the order of parts"));
    CHECK_THAT(damaged([](SliceResult& r) { r.contours[2].parent = 0; }), Catch::Contains("the parent is of another part"));
}
