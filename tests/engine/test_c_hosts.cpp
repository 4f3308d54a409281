// lamella.h: any source to any destination, and what hosts carry from mesh to layers.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "engine/c_calls.hpp"
#include "engine/shapes.hpp"
#include "lamella/lamella.h"
#include "lamella/lamella.hpp"

using namespace lamella;
using namespace c_calls;

namespace {

/// Arrays of a host that hold what the outline says.
struct Arrays {
    explicit Arrays(const lamella_info& outline)
        : points(outline.segments), origins(outline.segments), contours(outline.segments), layers(outline.layers) {
        arrays = fresh<lamella_arrays>(LAMELLA_ARRAYS);
        arrays.points = points.data();
        arrays.point_capacity = points.size();
        arrays.contours = contours.data();
        arrays.contour_capacity = contours.size();
        arrays.layers = layers.data();
        arrays.layer_capacity = layers.size();
        arrays.origins = origins.data();
    }
    std::vector<lamella_point> points;
    std::vector<lamella_point_origin> origins;
    std::vector<lamella_contour> contours;
    std::vector<lamella_layer> layers;
    lamella_arrays arrays;
};

/// The layers that a sink was given, put together.
struct Collected {
    std::vector<lamella_point> points;
    std::vector<lamella_point_origin> origins;
    std::vector<std::uint64_t> order;
    void operator()(const lamella_layer_view& layer) {
        order.push_back(layer.index);
        points.insert(points.end(), layer.points, layer.points + layer.point_count);
        if (layer.origins != nullptr) {
            origins.insert(origins.end(), layer.origins, layer.origins + layer.point_count);
        }
    }
};

template <class T>
bool same_bytes(const std::vector<T>& got, const T* expected, std::uint64_t count) {
    return got.size() >= count && std::memcmp(got.data(), expected, count * sizeof(T)) == 0;
}

/// A box with a box in it that is empty, beside a smaller one.
std::vector<float> hollow_and_solid() {
    using namespace shapes;
    return floats(joined({box({0, 0, 0}, {9, 9, 9}), flipped(box({2, 2, 2}, {7, 7, 7})), box({12, 0, 0}, {15, 3, 9})}));
}

}  // namespace

TEST_CASE("any source goes to any destination by C", "[c]") {
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({1, 2, 3}, 20, 3));
    const lamella_mesh mesh = soup_of(sphere);
    lamella_options options = options_at(0.7);
    options.origins = 1;
    lamella_prepared* handle = nullptr;
    REQUIRE(lamella_prepare(&mesh, &options, nullptr, &handle, nullptr) == LAMELLA_OK);
    const std::unique_ptr<lamella_prepared, Freed> prepared(handle);
    CHECK(lamella_prepared_grid_mm(handle) == LAMELLA_DEFAULT_GRID_MM);
    CHECK(lamella_prepared_bytes(handle) >= mesh.triangle_count * 48);
    lamella_part parts[2] = {{&mesh, {}}, {&mesh, {1, 0, 0, 50, 0, 1, 0, 0, 0, 0, 1, 0}}};  // the second is moved along x
    lamella_source source = fresh<lamella_source>(LAMELLA_SOURCE);
    std::uint64_t times = 1;

    SECTION("a mesh") {
        source.mesh = &mesh;
    }
    SECTION("a prepared mesh") {
        source.prepared = handle;
    }
    SECTION("parts") {
        source.parts = parts;
        source.part_count = 2;
        times = 2;
    }
    SECTION("what faces project") {
        source.mesh = &mesh;
        options.content =
            GENERATE(as<std::int32_t>{}, LAMELLA_LAYER_CONTENT_UPWARD_FACES, LAMELLA_LAYER_CONTENT_DOWNWARD_FACES);
        lamella_result* refused = nullptr;
        CHECK(lamella_slice(nullptr, &mesh, &options, &refused, nullptr) == LAMELLA_INVALID_ARGUMENT);  // no origins
        options.origins = 0;
    }
    const ResultHandle expected = sliced_from(source, options);
    const lamella_view view = view_of(expected);
    REQUIRE(view.info.points != 0);
    if (source.mesh != nullptr) {
        const auto content = static_cast<LayerContent>(options.content);
        const auto in_cpp =
            slice(MeshView::soup(sphere), {.layer_height_mm = 0.7, .origins = options.origins != 0, .content = content});
        REQUIRE(in_cpp);
        CHECK(lamella_result_hash(expected.get()) == in_cpp->hash());
        CHECK(std::equal(in_cpp->origins.begin(), in_cpp->origins.end(), view.origins,
                         [](const auto& a, const auto& b) { return std::memcmp(&a, &b, sizeof a) == 0; }));
    }
    CHECK(view.info.part_count == times);
    if (options.content == LAMELLA_LAYER_CONTENT_SECTION) {
        CHECK(view.info.points == times * view_of(sliced(mesh, options)).info.points);
    }

    const std::unique_ptr<lamella_slicer, Freed> slicer(lamella_slicer_create());
    auto outline = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_outline(slicer.get(), &source, &options, nullptr, &outline, nullptr) == LAMELLA_OK);
    CHECK(outline.layers == view.info.layers);
    CHECK(lamella_slicer_bytes(slicer.get()) > 0);

    Collected got;
    const lamella_sink sink = sink_to(got);
    auto to = into(nullptr, &sink, nullptr);
    auto info = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_slice_to(slicer.get(), &to, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    CHECK(info.points == view.info.points);
    CHECK(got.order.size() == view.info.layers);
    CHECK(std::is_sorted(got.order.begin(), got.order.end()));
    CHECK(same_bytes(got.points, view.points, view.info.points));

    outline.segments = std::max(outline.segments, view.info.points);  // regions make points
    Arrays host(outline);
    to = into(nullptr, nullptr, &host.arrays);
    REQUIRE(lamella_slice_to(slicer.get(), &to, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    CHECK(info.contours == view.info.contours);
    CHECK(same_bytes(host.points, view.points, view.info.points));
    if (view.origins != nullptr) {
        CHECK(same_bytes(got.origins, view.origins, view.info.points));
        CHECK(same_bytes(host.origins, view.origins, view.info.points));
    }
    lamella_slicer_reset(slicer.get());
    CHECK(lamella_slicer_bytes(slicer.get()) == 0);
}

TEST_CASE("the info of C holds the counts of a result, and the layer of each height", "[c]") {
    const std::vector<float> soup = hollow_and_solid();
    const lamella_mesh mesh = soup_of(soup);
    const lamella_source source = source_of(mesh);
    const std::vector<double> heights = {7.5, 1, 4.5, 1};
    const lamella_options options = at_heights(heights);
    const ResultHandle expected = sliced(mesh, options);
    const lamella_info counts = view_of(expected).info;
    Collected got;
    const lamella_sink sink = sink_to(got);
    const auto to = into(nullptr, &sink, nullptr);
    const std::unique_ptr<lamella_slicer, Freed> slicer(lamella_slicer_create());
    auto info = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_slice_to(slicer.get(), &to, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    REQUIRE(info.layer_of_count == 4);
    CHECK(std::vector<std::uint64_t>(info.layer_of, info.layer_of + 4) == std::vector<std::uint64_t>{2, 0, 1, 0});
    CHECK(info.triangles == 36);
    CHECK(info.holes == 1);
    CHECK(info.holes == counts.holes);
    CHECK(info.segments == counts.segments);
    CHECK(std::equal(info.min_mm, info.min_mm + 3, counts.min_mm));
    CHECK(info.max_mm[0] == 15);
    // A slicer that ends with the call keeps no list.
    REQUIRE(lamella_slice_to(nullptr, &to, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    CHECK(info.layer_of_count == 0);
}

TEST_CASE("islands and areas go through C", "[c]") {
    const std::vector<float> soup = hollow_and_solid();
    const std::vector<double> heights = {4.5};
    const ResultHandle result = sliced(soup_of(soup), at_heights(heights));
    const lamella_view view = view_of(result);
    std::vector<double> areas;
    lamella_island island;
    for (std::uint64_t at = 0; lamella_next_island(view.contours, view.info.contours, &at, &island) != 0;) {
        double area = lamella_contour_area_mm2(island.outer, view.info.grid_mm);
        for (std::uint64_t h = 0; h < island.hole_count; ++h) {
            CHECK(view.contours + island.holes[h].parent == island.outer);
            area += lamella_contour_area_mm2(island.holes + h, view.info.grid_mm);
        }
        areas.push_back(area);
    }
    CHECK(areas == std::vector<double>{81 - 25, 9});
    std::uint64_t none = 0;
    CHECK(lamella_next_island(nullptr, 0, &none, &island) == 0);
    CHECK(lamella_contour_area_mm2(nullptr, 1) == 0);
}
