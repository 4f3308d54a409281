// A slice written into the host's arrays is that of slice(), converted, and nothing else is touched.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/host_arrays.hpp"
#include "engine/same_result.hpp"
#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::Error;
using lamella::ErrorCode;
using lamella::HostOutput;
using lamella::OutputBounds;
using lamella::PointType;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::SliceTotals;

namespace {

void require_same(const HostArrays& host, lamella::Result<SliceTotals> totals, const SliceResult& result) {
    require_same_totals(value_of(std::move(totals)), result);
    REQUIRE(host.has_layers_of(result));
    REQUIRE(host.has_contours_of(result));
    REQUIRE(host.has_points_of(result));
    REQUIRE(host.guards_stand());
}

OutputBounds bounds_of(const lamella::MeshView& mesh, const SliceOptions& options) {
    return value_of(bound_output(mesh, options));
}

Error refusal_of(const HostOutput& output, const lamella::MeshView& mesh, const SliceOptions& options) {
    return error_of(slice_into(output, mesh, options));
}

}  // namespace

TEST_CASE("every type, stride and scale gives the points of slice(), converted", "[engine][host][threads]") {
    struct Form {
        PointType type;
        std::size_t stride;
        double scale;
        std::size_t offset;
    };
    const std::vector<Form> forms = {
        {PointType::i32, 0, 1, 0},       {PointType::i32, 8, 1, 3},         {PointType::i32, 12, 1, 0},
        {PointType::i32, 0, 3, 0},       {PointType::i64, 0, 1, 0},         {PointType::i64, 24, 4294967296.0, 1},
        {PointType::i64, 17, 1000, 0},   {PointType::f32, 0, 0x1p-20, 0},   {PointType::f32, 12, 1.0 / 3, 2},
        {PointType::f64, 0, 0x1p-20, 0}, {PointType::f64, 40, 1e-6 / 7, 5},
    };
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        SliceOptions options = uniform(0.5);
        const SliceResult result = sliced(mesh, options);
        for (const Form& form : forms) {
            for (const int threads : {1, 3}) {
                INFO(mesh_name << ", type " << static_cast<int>(form.type) << ", stride " << form.stride << ", scale "
                               << form.scale << ", threads " << threads);
                options.control.threads = threads;
                options.tuning.band_planes = threads;
                // As much as is needed, and no more.
                HostArrays host(result.points.size(), result.contours.size(), result.layers.size(), form.type, form.stride,
                                form.scale, form.offset);
                require_same(host, slice_into(host.output, view_of(mesh), options), result);
            }
        }
    }
}

TEST_CASE("bounds hold, and arrays of their size are enough", "[engine][host]") {
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        for (const auto& [plan_name, options] : shape_cases::plans()) {
            INFO(mesh_name << ", " << plan_name);
            const SliceResult result = sliced(mesh, options);
            const OutputBounds bounds = bounds_of(view_of(mesh), options);
            CHECK(bounds.layers == result.layers.size());
            CHECK(bounds.segments == result.summary.segments);
            CHECK(bounds.contours >= result.contours.size());
            CHECK(bounds.points >= result.points.size());
            CHECK((result.summary.open_contours > 0 || bounds.segments >= result.points.size()));
            CHECK(bounds.unit_mm == result.unit_mm);
            CHECK(bounds.are_certain);
            HostArrays host(bounds.points, bounds.contours, bounds.layers, PointType::i32);
            require_same(host, slice_into(host.output, view_of(mesh), options), result);
        }
    }
}

TEST_CASE("a polyline of one segment has the two points that bounds say", "[engine][host]") {
    const shapes::Soup sheet = shapes::triangle({0, 0, 0}, {4, 0, 4}, {0, 4, 4});
    const SliceOptions options = at_heights({2});
    const OutputBounds bounds = bounds_of(view_of(sheet), options);
    CHECK(bounds.segments == 1);
    CHECK(bounds.points == 2);
    HostArrays host(2, 1, 1, PointType::i64);
    require_same(host, slice_into(host.output, view_of(sheet), options), sliced(sheet, options));
}

TEST_CASE("regions are written like other contours", "[engine][host][fill][threads]") {
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        INFO(mesh_name);
        SliceOptions options = uniform(4);
        options.control.threads = 2;
        options.tuning.band_planes = 1;
        options.region.fill_rule = lamella::FillRule::non_zero;
        options.region.offset_mm = -0.3;
        CHECK_FALSE(bounds_of(view_of(mesh), options).are_certain);
        const SliceResult result = sliced(mesh, options);
        for (const PointType type : {PointType::i32, PointType::f64}) {
            HostArrays host(result.points.size(), result.contours.size(), result.layers.size(), type);
            require_same(host, slice_into(host.output, view_of(mesh), options), result);
        }
    }
}

TEST_CASE("closed gaps are written where there is memory for them", "[engine][host]") {
    shapes::Soup torn = shapes::octasphere({0, 0, 0}, 10, 3);
    torn.resize(torn.size() - 9 * std::size_t{20});
    SliceOptions options = uniform(0.5);
    options.close_gaps_mm = 50;
    const SliceResult result = sliced(torn, options);
    REQUIRE(result.closed_gaps.size() > 3);
    HostArrays host(result.points.size(), result.contours.size(), result.layers.size(), PointType::i32);
    require_same(host, slice_into(host.output, view_of(torn), options), result);

    std::vector<lamella::ClosedGap> gaps(result.closed_gaps.size());
    host.output.closed_gaps = gaps.data();
    host.output.closed_gap_capacity = gaps.size();
    const auto totals = value_of(slice_into(host.output, view_of(torn), options));
    REQUIRE(totals.closed_gaps == gaps.size());
    for (std::size_t g = 0; g < gaps.size(); ++g) {
        CHECK(gaps[g].layer == result.closed_gaps[g].layer);
        CHECK(gaps[g].from == result.closed_gaps[g].from);
        CHECK(gaps[g].to == result.closed_gaps[g].to);
    }
    host.output.closed_gap_capacity -= 1;
    CHECK(refusal_of(host.output, view_of(torn), options).code == ErrorCode::result_too_large);
}

TEST_CASE("what does not fit is refused, and nothing beyond the capacities is written", "[engine][host][threads]") {
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        SliceOptions options = uniform(0.5);
        options.control.threads = 3;
        options.tuning.band_planes = 2;
        const SliceResult result = sliced(mesh, options);
        const std::uint64_t points = result.points.size();
        const std::uint64_t contours = result.contours.size();
        const std::uint64_t layers = result.layers.size();
        for (const PointType type : {PointType::i32, PointType::i64, PointType::f32}) {
            for (const std::uint64_t fewer : {std::uint64_t{1}, points / 2, points}) {
                INFO(mesh_name << ", points short of " << fewer);
                HostArrays host(points - fewer, contours, layers, type);
                const Error error = refusal_of(host.output, view_of(mesh), options);
                CHECK(error.code == ErrorCode::result_too_large);
                CHECK(error.message.find(std::to_string(points)) != std::string::npos);
                CHECK(host.guards_stand());
            }
            HostArrays few_contours(points, contours - 1, layers, type);
            CHECK(refusal_of(few_contours.output, view_of(mesh), options).code == ErrorCode::result_too_large);
            CHECK(few_contours.guards_stand());
            HostArrays few_layers(points, contours, layers - 1, type);
            const Error error = refusal_of(few_layers.output, view_of(mesh), options);
            CHECK(error.code == ErrorCode::result_too_large);
            CHECK(error.message.find("there is memory for " + std::to_string(layers - 1)) != std::string::npos);
            CHECK(few_layers.guards_stand());
        }
    }
}

TEST_CASE("a scale that the type cannot take is refused before anything is cut", "[engine][host]") {
    const shapes::Soup box = shapes::box({-1, -1, 0}, {100, 7, 4});
    const SliceOptions options = at_heights({2});  // 200 units at most
    const auto code = [&](PointType type, double scale) {
        HostArrays host(8, 1, 1, type, 0, scale);
        const auto totals = slice_into(host.output, view_of(box), options);
        CHECK(host.guards_stand());
        return totals.ok() ? std::string("fits")
                           : std::string(totals.error().code == ErrorCode::invalid_argument ? "refused" : "?");
    };
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK(code(PointType::i32, 10'000'000) == "fits");
    CHECK(code(PointType::i32, 20'000'000) == "refused");
    CHECK(code(PointType::i64, 10'000'000'000'000'000) == "refused");  // beyond 2^53
    CHECK(code(PointType::i64, 4'000'000'000'000'000) == "fits");
    CHECK(code(PointType::f32, 1e30) == "fits");
    CHECK(code(PointType::f32, 1e37) == "refused");
    CHECK(code(PointType::f64, 1e300) == "fits");
    CHECK(code(PointType::f64, 1e307) == "refused");
    for (const PointType type : {PointType::i32, PointType::i64, PointType::f32, PointType::f64}) {
        for (const double scale : {0.0, -1.0, infinity, std::nan("")}) {
            CHECK(code(type, scale) == "refused");
        }
    }
    CHECK(code(PointType::i32, 0.5) == "refused");
    CHECK(code(PointType::i64, 1.5) == "refused");
    CHECK(code(static_cast<PointType>(7), 1) == "refused");
}

TEST_CASE("an offset counts where a scale is judged", "[engine][host][offset]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {8, 8, 4});
    SliceOptions options = at_heights({2});
    options.region.fill_rule = lamella::FillRule::non_zero;
    options.region.offset_mm = 50;
    HostArrays host(8, 1, 1, PointType::i32, 0, 50'000'000);  // 16 units fit, 116 do not
    CHECK(refusal_of(host.output, view_of(box), options).code == ErrorCode::invalid_argument);
}

TEST_CASE("arrays that contradict themselves are refused", "[engine][host][errors]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const SliceOptions options = at_heights({2});
    const auto refused = [&](auto change) {
        HostArrays host(8, 1, 1, PointType::i64);
        change(host.output);
        return refusal_of(host.output, view_of(box), options).code == ErrorCode::invalid_argument;
    };
    CHECK(refused([](HostOutput& output) { output.points = nullptr; }));
    CHECK(refused([](HostOutput& output) { output.contours = nullptr; }));
    CHECK(refused([](HostOutput& output) { output.layers = nullptr; }));
    CHECK(refused([](HostOutput& output) { output.closed_gap_capacity = 1; }));
    CHECK(refused([](HostOutput& output) { output.stride = 15; }));
    CHECK(refusal_of({}, view_of(box), options).code == ErrorCode::result_too_large);
    CHECK(refusal_of({}, lamella::MeshView{}, options).code == ErrorCode::empty_mesh);
    CHECK(bound_output(lamella::MeshView{}, options).error().code == ErrorCode::empty_mesh);
}

TEST_CASE("a prepared mesh is bounded and written like the mesh", "[engine][host][prepare]") {
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        INFO(mesh_name);
        const SliceOptions options = uniform(0.5);
        const auto prepared = value_of(lamella::prepare(view_of(mesh)));
        const OutputBounds expected = bounds_of(view_of(mesh), options);
        const OutputBounds bounds = value_of(bound_output(prepared, options));
        CHECK(bounds.layers == expected.layers);
        CHECK(bounds.segments == expected.segments);
        CHECK(bounds.points == expected.points);
        CHECK(bounds.unit_mm == expected.unit_mm);
        HostArrays host(bounds.points, bounds.contours, bounds.layers, PointType::i64, 0, 1000);
        require_same(host, slice_into(host.output, prepared, options), sliced(mesh, options));
    }
}

TEST_CASE("a layer without contours needs no points", "[engine][host]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    for (const PointType type : {PointType::i32, PointType::f64}) {
        lamella::Layer layer;
        const auto empty =
            value_of(slice_into({.type = type, .layers = &layer, .layer_capacity = 1}, view_of(box), at_heights({9})));
        CHECK(empty.layers == 1);
        CHECK(empty.points == 0);
        CHECK(layer.plane_mm == 9);
    }
}

// So many planes that the output outweighs what two threads hold in their bands, which depends on their pace.
TEST_CASE("a slice into the host's arrays allocates nothing of their size", "[engine][host][memory][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    SliceOptions options = uniform(0.0005);
    options.control.threads = 2;
    const OutputBounds bounds = bounds_of(view_of(ball), options);
    for (const PointType type : {PointType::i32, PointType::f64}) {
        const CountingMemory memory;
        options.control.memory = &memory;
        HostArrays host(bounds.segments, bounds.layers, bounds.layers, type);
        const auto totals = value_of(slice_into(host.output, view_of(ball), options));
        CHECK(memory.held() == 0);
        CHECK(memory.peak() < totals.points * sizeof(lamella::Point) / 2);
    }
}
