// A slice written into the host's arrays: what does not fit is refused, and nothing else is touched. That it is that of
// slice(), converted: test_sources.cpp.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"
#include "golden/shape_cases.hpp"

using lamella::Error;
using lamella::ErrorCode;
using lamella::HostArrays;
using lamella::Number;
using lamella::SliceInfo;
using lamella::SliceOptions;
using lamella::SliceResult;

namespace {

Error refusal_of(const HostArrays& arrays, const lamella::Source& mesh, const SliceOptions& options,
                 const lamella::Context& context = {}) {
    return error_of(lamella::Slicer().slice_to(arrays, mesh, options, context));
}

}  // namespace

TEST_CASE("stitches are counted where there is no memory for them, and refused where there is too little",
          "[engine][host]") {
    shapes::Soup torn = shapes::octasphere({0, 0, 0}, 10, 3);
    torn.resize(torn.size() - 9 * std::size_t{20});
    SliceOptions options = uniform(0.5);
    options.stitch_mm = 50;
    const SliceResult result = sliced(torn, options);
    REQUIRE(result.stitches.size() > 3);
    GuardedArrays host(result);
    host.arrays.stitches = {};
    require_same(sliced_to(host.arrays, view_of(torn), options), result.info);
    host.require_hold(result);
    GuardedArrays few(result);
    few.arrays.stitches = few.arrays.stitches.first(result.stitches.size() - 1);
    CHECK(refusal_of(few.arrays, view_of(torn), options).code == ErrorCode::result_too_large);
}

TEST_CASE("what does not fit is refused, and nothing beyond the capacities is written", "[engine][host][threads]") {
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        const SliceOptions options = uniform(0.5);
        const SliceResult result = sliced(mesh, options);
        const auto refused = [&, &mesh = mesh](const ArraySizes& sizes, Number type) {
            const GuardedArrays host(sizes, {.type = type});
            const Error error = refusal_of(host.arrays, view_of(mesh), options, {.threads = 3});
            CHECK(error.code == ErrorCode::result_too_large);
            CHECK(host.guards_stand());
            return error.message;
        };
        const ArraySizes enough{result.points.size(), result.contours.size(), result.layers.size()};
        for (const Number type : {Number::i32, Number::i64, Number::f32}) {
            for (const std::uint64_t fewer : {std::uint64_t{1}, enough.points / 2, enough.points}) {
                INFO(mesh_name << ", points short of " << fewer);
                CHECK_THAT(refused({enough.points - fewer, enough.contours, enough.layers}, type),
                           Catch::Contains(std::to_string(enough.points)));
            }
            refused({enough.points, enough.contours - 1, enough.layers}, type);
            CHECK_THAT(refused({enough.points, enough.contours, enough.layers - 1}, type),
                       Catch::Contains("there is memory for " + std::to_string(enough.layers - 1)));
        }
    }
}

TEST_CASE("a scale that the type cannot take is refused before anything is cut", "[engine][host]") {
    const shapes::Soup box = shapes::box({-1, -1, 0}, {100, 7, 4});
    const SliceOptions options = at_heights({2});  // 200 units at most
    const auto code = [&](Number type, double scale) {
        const GuardedArrays host({8, 1, 1}, {.type = type, .scale = scale});
        const auto code = code_of(lamella::Slicer().slice_to(host.arrays, view_of(box), options));
        CHECK(host.guards_stand());
        return std::string(!code ? "fits" : *code == ErrorCode::invalid_argument ? "refused" : "?");
    };
    const std::tuple<Number, double, const char*> cases[] = {
        {Number::i32, 1e7, "fits"},    {Number::i32, 2e7, "refused"},   {Number::i32, 0.5, "refused"},
        {Number::i64, 4e15, "fits"},   {Number::i64, 1e16, "refused"},  // beyond 2^53
        {Number::i64, 1.5, "refused"}, {Number::f32, 1e30, "fits"},     {Number::f32, 1e37, "refused"},
        {Number::f64, 1e300, "fits"},  {Number::f64, 1e307, "refused"}, {static_cast<Number>(7), 1, "refused"}};
    for (const auto& [type, scale, expected] : cases) {
        CHECK(code(type, scale) == expected);
    }
    for (const Number type : {Number::i32, Number::i64, Number::f32, Number::f64}) {
        for (const double scale : {0.0, -1.0, HUGE_VAL, std::nan("")}) {
            CHECK(code(type, scale) == "refused");
        }
    }
    SliceOptions offset = options;  // counts, too: 200 units fit, 300 do not
    offset.region.fill_rule = lamella::FillRule::non_zero;
    offset.region.offset_mm = 50;
    const GuardedArrays host({8, 1, 1}, {.scale = 1e7});
    CHECK(refusal_of(host.arrays, view_of(box), offset).code == ErrorCode::invalid_argument);
}

TEST_CASE("parts and faces that do not fit are refused before progress shows the end", "[engine][host][parts][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {10, 10, 4});
    lamella::Part parts[2];
    parts[0].mesh = parts[1].mesh = view_of(box);
    SliceOptions faces = uniform(1);
    faces.content = lamella::LayerContent::upward_faces;
    std::vector<lamella::Layer> layers(100);
    double reached = -1;
    const auto note = [&](double done) noexcept { reached = done; };
    for (const HostArrays& arrays : {HostArrays{}, HostArrays{.layers = layers}}) {
        const double most = arrays.layers.empty() ? 0.4 : 1;  // with too few layers, before anything is cut
        CHECK(refusal_of(arrays, parts, uniform(1), {.progress = note}).code == ErrorCode::result_too_large);
        CHECK(std::exchange(reached, -1) < most);
        CHECK(refusal_of(arrays, view_of(box), faces, {.progress = note}).code == ErrorCode::result_too_large);
        CHECK(std::exchange(reached, -1) < most);
    }
}

TEST_CASE("arrays that contradict themselves are refused", "[engine][host][errors]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const SliceOptions options = at_heights({2});
    const auto refused = [&](auto change) {
        GuardedArrays host({8, 1, 1}, {.type = Number::i64});
        change(host.arrays);
        return refusal_of(host.arrays, view_of(box), options).code == ErrorCode::invalid_argument;
    };
    CHECK(refused([](HostArrays& arrays) { arrays.points = nullptr; }));
    CHECK(refused([](HostArrays& arrays) { arrays.contours = {static_cast<lamella::Contour*>(nullptr), 1}; }));
    CHECK(refused([](HostArrays& arrays) { arrays.layers = {static_cast<lamella::Layer*>(nullptr), 1}; }));
    CHECK(refused([](HostArrays& arrays) { arrays.stitches = {static_cast<lamella::Stitch*>(nullptr), 1}; }));
    CHECK(refused([](HostArrays& arrays) { arrays.point_stride = 15; }));
    CHECK(refused([](HostArrays& arrays) { arrays.point_type = Number::u32; }));
    CHECK(refusal_of({}, view_of(box), options).code == ErrorCode::result_too_large);
    CHECK(refusal_of({}, lamella::MeshView{}, options).code == ErrorCode::empty_mesh);
    CHECK(code_of(lamella::Slicer().outline(lamella::MeshView{}, options)) == ErrorCode::empty_mesh);
}

TEST_CASE("a layer without contours needs no points", "[engine][host]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    for (const Number type : {Number::i32, Number::f64}) {
        lamella::Layer layer;
        const HostArrays arrays{.point_type = type, .layers = {&layer, 1}};
        const SliceInfo empty = sliced_to(arrays, view_of(box), at_heights({9}));
        CHECK(empty.layers == 1);
        CHECK(empty.points == 0);
        CHECK(layer.plane_mm == 9);
    }
}

// So many planes that the output outweighs what two threads hold in their bands, which depends on their pace.
TEST_CASE("a slice into the host's arrays allocates nothing of their size", "[engine][host][memory][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    const SliceOptions options = uniform(0.0005);
    const SliceInfo outline = value_of(lamella::Slicer().outline(view_of(ball), options));
    for (const Number type : {Number::i32, Number::f64}) {
        const CountingMemory memory;
        const GuardedArrays host({outline.segments, outline.layers, outline.layers}, {.type = type});
        const SliceInfo info = sliced_to(host.arrays, view_of(ball), options, {.threads = 2, .memory = &memory});
        CHECK(memory.held() == 0);
        CHECK(memory.peak() < info.points * sizeof(lamella::Point) / 2);
    }
}
