// lamella.h: what hosts carry from mesh to layers, and the forms that they take layers in.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "engine/c_calls.hpp"
#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "lamella/lamella.h"
#include "lamella/lamella.hpp"

using namespace c_calls;
using namespace lamella;

namespace {

bool same_bytes(const lamella_point_origin* a, const lamella_point_origin* b, std::uint64_t count) {
    return std::memcmp(a, b, count * sizeof *a) == 0;
}

/// A box with a box in it that is empty, beside a smaller one.
std::vector<float> hollow_and_solid() {
    using namespace shapes;
    return floats(joined({box({0, 0, 0}, {9, 9, 9}), flipped(box({2, 2, 2}, {7, 7, 7})), box({12, 0, 0}, {15, 3, 9})}));
}

}  // namespace

TEST_CASE("origins by C are those of C++", "[c]") {
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({1, 2, 3}, 20, 3));
    const lamella_mesh mesh = soup_of(sphere);
    lamella_options options = options_at(0.7);
    CHECK(view_of(sliced(mesh, options)).origins == nullptr);
    options.origins = 1;
    SliceOptions same;
    same.plan.spacing = UniformLayers{.layer_height_mm = 0.7};
    same.origins = true;
    const SliceResult expected = value_of(slice(MeshView::soup(sphere), same));
    const ResultHandle result = sliced(mesh, options);
    const lamella_view view = view_of(result);
    REQUIRE(view.origins != nullptr);
    REQUIRE(view.point_count == expected.origins.size());
    for (std::uint64_t i = 0; i < view.point_count; ++i) {
        const PointOrigin& origin = expected.origins[i];
        REQUIRE(view.origins[i].triangle == origin.triangle);
        REQUIRE(view.origins[i].triangle < mesh.triangle_count);
        REQUIRE(view.origins[i].edge == origin.edge);
        REQUIRE(view.origins[i].end_edge == origin.end_edge);
    }

    SECTION("in a sink") {
        std::vector<lamella_point_origin> got;
        const lamella_sink sink = {[](void* context, const lamella_layer_view* layer) {
                                       if (layer->point_count != 0) {
                                           static_cast<std::vector<lamella_point_origin>*>(context)->insert(
                                               static_cast<std::vector<lamella_point_origin>*>(context)->end(),
                                               layer->origins, layer->origins + layer->point_count);
                                       }
                                   },
                                   &got, LAMELLA_SINK_ASCENDING, 0};
        REQUIRE(lamella_slice_to(&sink, &mesh, &options, nullptr, nullptr, nullptr) == LAMELLA_OK);
        REQUIRE(got.size() == view.point_count);
        CHECK(same_bytes(got.data(), view.origins, view.point_count));
    }
    SECTION("in host arrays") {
        lamella_output_bounds bounds = fresh(lamella_output_bounds_init_sized);
        REQUIRE(lamella_bound_output(&mesh, &options, nullptr, &bounds, nullptr) == LAMELLA_OK);
        HostArrays<std::int32_t> host(bounds, LAMELLA_I32);
        host.output.origins = host.origins.data();
        lamella_totals totals = fresh(lamella_totals_init_sized);
        REQUIRE(lamella_slice_into(&host.output, &mesh, &options, nullptr, &totals, nullptr) == LAMELLA_OK);
        REQUIRE(totals.points == view.point_count);
        CHECK(same_bytes(host.origins.data(), view.origins, view.point_count));
    }
    SECTION("of parts, which they name") {
        const lamella_mesh* const meshes[] = {&mesh, &mesh};
        lamella_result* both = nullptr;
        REQUIRE(lamella_slice_parts(meshes, nullptr, 2, &options, LAMELLA_PARTS_SEPARATE, &both, nullptr) == LAMELLA_OK);
        const ResultHandle owned(both);
        const lamella_view parts = view_of(owned);
        REQUIRE(parts.point_count == 2 * view.point_count);
        const auto seconds = std::count_if(parts.origins, parts.origins + parts.point_count,
                                           [](const lamella_point_origin& origin) { return origin.part == 1; });
        CHECK(static_cast<std::uint64_t>(seconds) == view.point_count);
    }
}

TEST_CASE("a prepared mesh is written into host arrays by C", "[c]") {
    const lamella_mesh mesh = soup_of(tetrahedron);
    lamella_options options = options_at(0.5);
    options.origins = 1;
    const ResultHandle expected = sliced(mesh, options);
    const lamella_view view = view_of(expected);
    lamella_prepared* handle = nullptr;
    REQUIRE(lamella_prepare(&mesh, &options, &handle, nullptr) == LAMELLA_OK);
    const std::unique_ptr<lamella_prepared, Freed> prepared(handle);
    CHECK(lamella_prepared_unit_mm(handle) == LAMELLA_DEFAULT_UNIT_MM);
    CHECK(lamella_prepared_unit_mm(nullptr) == 0);
    lamella_output_bounds bounds = fresh(lamella_output_bounds_init_sized);
    REQUIRE(lamella_bound_prepared_output(handle, &options, nullptr, &bounds, nullptr) == LAMELLA_OK);
    CHECK(bounds.layers == view.layer_count);
    HostArrays<std::int32_t> host(bounds, LAMELLA_I32);
    host.output.origins = host.origins.data();
    lamella_totals totals = fresh(lamella_totals_init_sized);
    REQUIRE(lamella_slice_prepared_into(&host.output, handle, &options, nullptr, &totals, nullptr) == LAMELLA_OK);
    REQUIRE(totals.points == view.point_count);
    CHECK(std::memcmp(host.points.data(), view.points, view.point_count * sizeof(lamella_point)) == 0);
    CHECK(same_bytes(host.origins.data(), view.origins, view.point_count));
    CHECK(lamella_bound_prepared_output(nullptr, &options, nullptr, &bounds, nullptr) == LAMELLA_INVALID_ARGUMENT);
    CHECK(lamella_slice_prepared_into(&host.output, nullptr, &options, nullptr, nullptr, nullptr) ==
          LAMELLA_INVALID_ARGUMENT);
}

TEST_CASE("totals of C hold the counts of a result, and the layer of each height", "[c]") {
    const std::vector<float> soup = hollow_and_solid();
    const lamella_mesh mesh = soup_of(soup);
    const std::vector<double> heights = {7.5, 1, 4.5, 1};
    lamella_options options = options_at(heights);
    const ResultHandle expected = sliced(mesh, options);
    const lamella_view view = view_of(expected);
    const lamella_sink sink = {[](void*, const lamella_layer_view*) {}, nullptr, LAMELLA_SINK_ANY, 0};
    std::vector<std::uint64_t> layer_of(4, 99);
    lamella_totals totals = fresh(lamella_totals_init_sized);
    totals.layer_of = layer_of.data();
    totals.layer_of_capacity = layer_of.size();
    REQUIRE(lamella_slice_to(&sink, &mesh, &options, nullptr, &totals, nullptr) == LAMELLA_OK);
    CHECK(layer_of == std::vector<std::uint64_t>{2, 0, 1, 0});
    CHECK(totals.layer_of == layer_of.data());
    CHECK(totals.triangles == 36);
    CHECK(totals.holes == 1);
    CHECK(totals.holes == view.holes);
    CHECK(totals.segments == view.segments);
    CHECK(std::equal(totals.min_mm, totals.min_mm + 3, view.min_mm));
    CHECK(totals.max_mm[0] == 15);

    totals.layer_of_capacity = 3;
    lamella_error error = fresh_error();
    CHECK(lamella_slice_to(&sink, &mesh, &options, nullptr, &totals, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(error.message) == "layer_of has room for 3 layers, but there are 4 heights");
    totals.struct_size = offsetof(lamella_totals, triangles);  // of a program that knows neither
    CHECK(lamella_slice_to(&sink, &mesh, &options, nullptr, &totals, &error) == LAMELLA_OK);
}

TEST_CASE("islands and areas go through C", "[c]") {
    const std::vector<float> soup = hollow_and_solid();
    const lamella_mesh mesh = soup_of(soup);
    const std::vector<double> heights = {4.5};
    const lamella_options options = options_at(heights);
    const ResultHandle result = sliced(mesh, options);
    const lamella_view view = view_of(result);
    std::vector<double> areas;
    lamella_island island;
    for (std::uint64_t at = 0; lamella_next_island(view.contours, view.contour_count, &at, &island) != 0;) {
        double area = lamella_contour_area_mm2(island.outer, view.unit_mm);
        for (std::uint64_t h = 0; h < island.hole_count; ++h) {
            CHECK(view.contours + island.holes[h].parent == island.outer);
            area += lamella_contour_area_mm2(island.holes + h, view.unit_mm);
        }
        areas.push_back(area);
    }
    CHECK(areas == std::vector<double>{81 - 25, 9});
    std::uint64_t none = 0;
    CHECK(lamella_next_island(nullptr, 0, &none, &island) == 0);
    CHECK(lamella_contour_area_mm2(nullptr, 1) == 0);
}

TEST_CASE("slabs by C are those of C++", "[c]") {
    const std::vector<float> soup = hollow_and_solid();
    const lamella_mesh mesh = soup_of(soup);
    lamella_options options = options_at(3);
    lamella_result* top = nullptr;
    lamella_result* bottom = nullptr;
    REQUIRE(lamella_slice_slabs(&mesh, &options, &top, &bottom, nullptr) == LAMELLA_OK);
    const ResultHandle tops(top);
    const ResultHandle bottoms(bottom);
    SlabOptions same;
    same.plan.spacing = UniformLayers{.layer_height_mm = 3};
    const Slabs expected = value_of(slice_slabs(MeshView::soup(soup), same));
    REQUIRE(view_of(tops).contour_count != 0);
    REQUIRE(view_of(bottoms).contour_count != 0);
    CHECK(lamella_result_hash(top) == hash_result(expected.top));
    CHECK(lamella_result_hash(bottom) == hash_result(expected.bottom));
    CHECK(lamella_result_hash(top) != lamella_result_hash(bottom));

    lamella_result* alone = nullptr;
    REQUIRE(lamella_slice_slabs(&mesh, &options, nullptr, &alone, nullptr) == LAMELLA_OK);
    const ResultHandle owned(alone);
    CHECK(lamella_result_hash(alone) == lamella_result_hash(bottom));
    REQUIRE(lamella_slice_slabs(&mesh, &options, &alone, nullptr, nullptr) == LAMELLA_OK);
    CHECK(lamella_result_hash(alone) == lamella_result_hash(top));
    CHECK(lamella_slice_slabs(&mesh, &options, nullptr, nullptr, nullptr) == LAMELLA_INVALID_ARGUMENT);
    options.origins = 1;
    lamella_error error = fresh_error();
    CHECK(lamella_slice_slabs(&mesh, &options, &alone, nullptr, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(error.message) == "slabs have neither gaps that are joined nor origins");
}

TEST_CASE("a tolerance of simplification goes through C", "[c]") {
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({0, 0, 0}, 20, 4));
    const lamella_mesh mesh = soup_of(sphere);
    lamella_region_rules rules = fresh(lamella_region_rules_init_sized);
    rules.simplify_mm = 0.5;
    lamella_options options = options_at(1);
    const std::uint64_t points = view_of(sliced(mesh, options)).point_count;
    options.region = &rules;
    CHECK(view_of(sliced(mesh, options)).point_count < points / 2);
    rules.struct_size = offsetof(lamella_region_rules, simplify_mm);
    CHECK(view_of(sliced(mesh, options)).point_count == points);
}
