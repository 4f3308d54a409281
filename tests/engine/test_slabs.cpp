// Projections of upward and downward faces, as drawings, and against a look at every face above and below a place.
// test_sources.cpp has the tests that they share with slices.
#include <limits>
#include <random>
#include <tuple>

#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"
#include "rings.hpp"

using namespace lamella;

namespace {

using Lines = std::vector<std::string>;

/// The regions that upward and downward faces project onto the same planes.
struct Slabs {
    SliceResult top;
    SliceResult bottom;
};

/// Requires success and two valid results.
Slabs slabs_of(const Source& mesh, SliceOptions options, const Context& context = {}) {
    options.content = LayerContent::upward_faces;
    SliceResult top = sliced(mesh, options, context);
    options.content = LayerContent::downward_faces;
    return {std::move(top), sliced(mesh, options, context)};
}
Slabs slabs_of(const shapes::Soup& soup, const SliceOptions& options, const Context& context = {}) {
    return slabs_of(view_of(soup), options, context);
}

/// Twice the net area in square units.
oracle::Int128 twice_area(std::span<const Contour> contours) {
    oracle::Int128 sum = 0;
    for (const Contour& contour : contours) {
        sum += (oracle::Int128{contour.twice_area.high} << 64) + contour.twice_area.low;
    }
    return sum;
}
oracle::Int128 twice_area(const oracle::Triangle& t) {
    const auto [a, b, c] = t;
    return oracle::Int128{b.x - a.x} * (c.y - a.y) - oracle::Int128{b.y - a.y} * (c.x - a.x);
}

/// The sum over all faces that look upward.
oracle::Int128 twice_upward_area(const shapes::Soup& soup, double grid_mm) {
    oracle::Int128 sum = 0;
    for (const oracle::Triangle& t : oracle::quantise(soup, grid_mm)) {
        sum += std::max<oracle::Int128>(0, twice_area(t));
    }
    return sum;
}

/// The layer is solid at a place in grid units.
bool covers(const SliceResult& result, std::size_t layer, double x, double y) {
    int winding = 0;
    for (const Contour& contour : result.contours_of(result.layers[layer])) {
        winding += rings::winding(result.points_of(contour), rings::PlaceOf<double>{x, y}).value_or(0);
    }
    return winding > 0;
}

/// The faces above and below one place.
class Plumb {
public:
    /// In grid units.
    Plumb(double x, double y) : x_(x), y_(y) {}

    /// False where the place is too near to a border for doubles to tell.
    bool pass(const oracle::Triangle& t, double mirror) {
        double barycentric[3];
        const auto area = static_cast<double>(twice_area(t));
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& a = t[(i + 1) % 3];
            const auto& b = t[(i + 2) % 3];
            const double side = (double(b.x) - a.x) * (y_ - a.y) - (double(b.y) - a.y) * (x_ - a.x);
            if (std::abs(side) < margin * std::hypot(double(b.x) - a.x, double(b.y) - a.y)) {
                return false;
            }
            barycentric[i] = side / area;
        }
        if (area != 0 && *std::min_element(barycentric, barycentric + 3) > 0) {
            const double z = barycentric[0] * t[0].z + barycentric[1] * t[1].z + barycentric[2] * t[2].z;
            (area * mirror > 0 ? up_ : down_).push_back(z);
        }
        return true;
    }

    /// Compares layer by layer; false where a face pierces a plane too near.
    bool judge(const Slabs& slabs) const {
        const auto& layers = slabs.top.layers;
        const auto height = [&](std::size_t i) { return static_cast<double>(layers[i].plane.z()); };
        for (const auto* const heights : {&up_, &down_}) {
            for (const double z : *heights) {
                for (std::size_t i = 0; i < layers.size(); ++i) {
                    if (std::abs(z - height(i)) < margin) {
                        return false;
                    }
                }
            }
        }
        constexpr double infinity = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const double next = i + 1 < layers.size() ? height(i + 1) : infinity;
            const double before = i > 0 ? height(i - 1) : -infinity;
            INFO("layer " << i << " at " << x_ << ", " << y_);
            REQUIRE(covers(slabs.top, i, x_, y_) == any_between(up_, height(i), next));
            REQUIRE(covers(slabs.bottom, i, x_, y_) == any_between(down_, before, height(i)));
        }
        return true;
    }

private:
    static constexpr double margin = 40;  // of 2^20 units a mm

    static bool any_between(const std::vector<double>& heights, double low, double high) {
        return std::any_of(heights.begin(), heights.end(), [&](double z) { return low < z && z < high; });
    }

    double x_;
    double y_;
    std::vector<double> up_;
    std::vector<double> down_;
};

/// At random places. `moved`: the soup as the transform leaves it, with faces turned where it mirrors.
std::size_t judge_by_plumbs(const shapes::Soup& moved, double mirror, const Slabs& slabs, std::uint64_t seed, double range) {
    std::mt19937_64 random(seed);
    const std::vector<oracle::Triangle> triangles = oracle::quantise(moved, slabs.top.info.grid_mm);
    std::size_t judged = 0;
    for (int i = 0; i < 40; ++i) {
        const auto place = [&] { return (static_cast<double>(random() >> 11) * 0x1p-53 * 2 - 0.5) * range * 0x1p20; };
        Plumb plumb(place(), place());
        const bool clear = std::all_of(triangles.begin(), triangles.end(),
                                       [&](const oracle::Triangle& t) { return plumb.pass(t, mirror); });
        judged += clear && plumb.judge(slabs) ? 1U : 0U;
    }
    return judged;
}

TEST_CASE("a horizontal face on a plane lies above it or below it as the plan says", "[engine][slabs]") {
    SliceOptions options = at_heights({-2, 0, 5, 10, 12});
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 10});
    const Lines square = {"outer + x4 in -: 0,0 8,0 8,8 0,8"};
    std::size_t up = 3;    // to its own plane
    std::size_t down = 2;  // to the next above
    SECTION("below") {}
    SECTION("above") {
        options.planes.side = PlaneSide::above;
        up = 2;    // to the next plane below
        down = 1;  // to its own
    }
    const Slabs slabs = slabs_of(box, options);
    for (std::size_t layer = 0; layer < 5; ++layer) {
        CHECK(contours_at(slabs.top, layer) == (layer == up ? square : Lines{}));
        CHECK(contours_at(slabs.bottom, layer) == (layer == down ? square : Lines{}));
    }
    CHECK(slabs.top.layers[up].segments == 2);
    CHECK(slabs.top.info.crossed == 2);
    CHECK(slabs.top.info.segments == 2);
    CHECK(slabs.top.info.triangles == 12);
}

TEST_CASE("one of very many layers is what its two planes alone give", "[engine][slabs][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 3);
    constexpr std::size_t planes = 9'001;
    std::vector<double> heights;
    for (std::size_t i = 0; i < planes; ++i) {
        heights.push_back(-6 + 12 * static_cast<double>(i) / (planes - 1));
    }
    const Slabs all = slabs_of(ball, at_heights(heights, 0), {.threads = 3});
    REQUIRE(all.top.layers.size() == planes);
    CHECK(twice_area(all.top.contours) == twice_upward_area(ball, all.top.info.grid_mm));
    for (const std::size_t layer : {4'500U, 4'501U, 5'000U, 6'999U, 8'249U}) {
        const Slabs two = slabs_of(ball, at_heights({heights[layer], heights[layer + 1]}, 0));
        CHECK(twice_area(all.top[layer].contours) == twice_area(two.top[0].contours));
        CHECK(all.top.layers[layer].segments == two.top.layers[0].segments);
        const Slabs below = slabs_of(ball, at_heights({heights[planes - layer], heights[planes - 1 - layer]}, 0));
        const LayerView low = all.bottom[planes - layer];
        CHECK(twice_area(low.contours) == twice_area(below.bottom[1].contours));
        CHECK(low.segments == below.bottom.layers[1].segments);
        CHECK(low.segments > 0);
    }
}

TEST_CASE("rules of regions follow the union", "[engine][slabs][regions]") {
    const shapes::Soup parts = shapes::joined({shapes::box({0, 0, 0}, {4, 4, 4}), shapes::box({5, 0, 0}, {8, 4, 4})});
    const shapes::Soup tilted = shapes::joined({shapes::quad({0, 0, 3}, {4, 0, 3}, {4, 4, 3}, {0, 4, 3}),
                                                shapes::quad({4, 0, 3}, {8, 0, 3}, {8, 4, 3}, {4, 4, 3})});
    const std::string left = "outer + x4 in -: 0,0 8,0 8,8 0,8";
    const std::tuple<shapes::Soup, RegionRules, Lines> cases[] = {
        {tilted, {}, {"outer + x6 in -: 0,0 8,0 16,0 16,8 8,8 0,8"}},
        {tilted, {.drop_collinear = true}, {"outer + x6 in -: 0,0 16,0 16,8 0,8"}},
        {parts, {}, {left, "outer + x4 in -: 10,0 16,0 16,8 10,8"}},
        {parts, {.closing_mm = 1, .drop_collinear = true}, {"outer + x4 in -: 0,0 16,0 16,8 0,8"}},
        {parts, {.largest_only = true}, {left}},
        {parts, {.offset_mm = -2.5}, {}}};
    for (const auto& [mesh, rules, expected] : cases) {
        const SliceResult found = sliced(mesh, {.heights_mm = {{2}},
                                                .content = LayerContent::upward_faces,
                                                .frame = {.grid_mm = coarse_unit_mm},
                                                .region = rules});
        CHECK(contours_at(found, 0) == expected);
        CHECK(found.info.emptied_layers == (expected.empty() ? 1 : 0));
    }
}

TEST_CASE("slabs refuse what has no meaning for them", "[engine][slabs][errors]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    SliceOptions options{.heights_mm = {{1}}, .content = LayerContent::upward_faces};
    const std::vector<Part> parts = {{.mesh = view_of(box)}};
    CHECK_THAT(failure_of(parts, options).message, Catch::Contains("one mesh"));
    CHECK_THAT(failure_of(value_of(prepare(view_of(box))), options).message, Catch::Contains("one mesh"));
    const Error large = failure_of(view_of(box), options, {.memory_limit_bytes = 79});
    CHECK(large.code == ErrorCode::result_too_large);
    CHECK(large.message == "1 layer with 2 pieces of faces need 80 bytes, more than the memory limit of 79");
    options.region.fill_rule = FillRule::even_odd;
    CHECK_THAT(failure_of(view_of(box), options).message, Catch::Contains("fill rule"));
    options.region = {.closing_mm = -1};
    CHECK_THAT(failure_of(view_of(box), options).message, Catch::StartsWith("closing_mm must be"));
    options.region = {};
    options.origins = true;
    CHECK_THAT(failure_of(view_of(box), options).message, Catch::Contains("no origins"));
}

TEST_CASE("every place is covered as the faces above and below it say", "[engine][slabs][random]") {
    std::mt19937_64 random(3);
    std::size_t judged = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const std::uint64_t range = 3 + random() % 6;
        const shapes::Soup soup = seed % 2 == 0 ? shapes::random_soup(seed, 2 + static_cast<int>(random() % 30), range)
                                                : shapes::random_tetrahedra(seed, 1 + static_cast<int>(random() % 8), range);
        std::vector<double> heights;
        for (std::uint64_t i = 0; i < 1 + random() % 5; ++i) {
            heights.push_back(static_cast<double>(random() % (16 * range)) / 8 - 1);
        }
        SliceOptions options = at_heights(heights, 0x1p-20);
        options.planes.side = random() % 2 == 0 ? PlaneSide::below : PlaneSide::above;
        const Context context{.threads = 1 + static_cast<int>(random() % 3)};
        shapes::Soup moved = soup;
        const bool mirrored = random() % 2 == 0;
        if (mirrored) {
            options.frame.transform.m[0] = -1;
            options.frame.transform.m[3] = static_cast<double>(range);
            for (std::size_t i = 0; i < moved.size(); i += 3) {
                moved[i] = static_cast<double>(range) - moved[i];
            }
        }
        options.allow_empty = true;
        INFO("seed " << seed);
        const Slabs slabs = slabs_of(soup, options, context);
        judged += judge_by_plumbs(moved, mirrored ? -1 : 1, slabs, seed, static_cast<double>(range));
    }
    CHECK(judged > 60 * 40 / 2);
}

}  // namespace
