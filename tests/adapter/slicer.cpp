// The made-up slicer of the page about hosts, with lamella as its slicing step: what its layers must be.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "adapter.hpp"
#include "engine/shapes.hpp"

namespace {

const host::ThrowOnCancel go_on = [] {};

host::Mesh mesh_of(const shapes::Soup& soup) {
    const shapes::Indexed shared = shapes::indexed(soup);
    host::Mesh mesh;
    for (std::size_t i = 0; i < shared.xyz.size(); i += 3) {
        const auto at = [&](std::size_t axis) { return static_cast<float>(shared.xyz[i + axis]); };
        mesh.vertices.push_back({at(0), at(1), at(2), 0xffffffff});
    }
    for (std::size_t i = 0; i < shared.indices.size(); i += 3) {
        const auto corner = [&](std::size_t k) { return static_cast<std::int32_t>(shared.indices[i + k]); };
        mesh.triangles.push_back({{corner(0), corner(1), corner(2)}, 7});
    }
    return mesh;
}

shapes::Soup box_with_hole() {
    return shapes::joined({shapes::box({0, 0, 0}, {40, 40, 10}), shapes::flipped(shapes::box({10, 10, 2}, {20, 20, 8}))});
}

std::vector<host::Layer> slice(const host::Mesh& mesh, const std::vector<double>& heights_mm,
                               const host::Settings& settings = {}) {
    lamella::Slicer slicer;
    return host::slice(mesh, heights_mm, settings, go_on, slicer);
}

/// Polygons as numbers, to be compared and measured: outer ones, each before its holes.
using Rings = std::vector<std::vector<std::pair<std::int64_t, std::int64_t>>>;

template <class Points>
void add_ring(Rings& rings, const Points& points) {
    auto& ring = rings.emplace_back();
    for (const auto& point : points) {
        ring.emplace_back(point.x, point.y);
    }
}

Rings rings_of(const host::Layer& layer) {
    Rings rings;
    for (const host::Island& island : layer.islands) {
        add_ring(rings, island.outer);
        for (const host::Polygon& hole : island.holes) {
            add_ring(rings, hole);
        }
    }
    return rings;
}

double area_mm2(const host::Layer& layer) {
    double twice = 0;
    for (const auto& ring : rings_of(layer)) {
        for (std::size_t at = 0; at < ring.size(); ++at) {
            const auto [ax, ay] = ring[at];
            const auto [bx, by] = ring[(at + 1) % ring.size()];
            twice += static_cast<double>(ax) * static_cast<double>(by) - static_cast<double>(bx) * static_cast<double>(ay);
        }
    }
    return twice / 2 * 1e-12;
}

// One plane by the library's plainest call.
lamella::SliceResult slice_by_library(const shapes::Soup& soup, double height_mm, lamella::Transform transform = {}) {
    const std::vector<float> floats = shapes::floats(soup);
    lamella::Result<lamella::SliceResult> sliced = lamella::slice(
        lamella::MeshView::soup(floats), {.heights_mm = {{height_mm}},
                                          .frame = {.transform = transform, .grid_mm = 1e-6},
                                          .region = {.fill_rule = lamella::FillRule::non_zero, .drop_collinear = true}});
    REQUIRE(sliced);
    return std::move(*sliced);
}

Rings rings_of(const lamella::SliceResult& result) {
    Rings rings;
    for (const lamella::Contour& contour : result.contours) {
        add_ring(rings, result.points_of(contour));
    }
    return rings;
}

}  // namespace

TEST_CASE("the adapter gives the layers of slice(), in the order of the heights") {
    const shapes::Soup soup = box_with_hole();
    const std::vector<double> heights{5, 1, 5, 9, 20, 1, -3};
    const std::vector<double> areas{1500, 1600, 1500, 1600, 0, 1600, 0};
    const std::vector<host::Layer> layers = slice(mesh_of(soup), heights);
    REQUIRE(layers.size() == heights.size());
    for (std::size_t at = 0; at < heights.size(); ++at) {
        CAPTURE(at);
        CHECK(area_mm2(layers[at]) == Approx(areas[at]).margin(1e-4));
        CHECK(layers[at].warnings.empty());
        CHECK(rings_of(layers[at]) == rings_of(slice_by_library(soup, heights[at])));
    }
    REQUIRE(layers[0].islands.size() == 1);
    CHECK(layers[0].islands[0].holes.size() == 1);
}

TEST_CASE("points are those of slice(), to the nanometre") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 17.3, 4);
    const Rings rings = rings_of(slice(mesh_of(soup), {3.3})[0]);
    REQUIRE(rings.size() == 1);
    CHECK(rings == rings_of(slice_by_library(soup, 3.3)));
    CHECK(std::any_of(rings[0].begin(), rings[0].end(), [](const auto& point) { return point.first % 2 != 0; }));
}

TEST_CASE("a face on a plane is met where the host's floats put it") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {9, 9, 7});
    const host::Mesh mesh = mesh_of(soup);
    host::Settings settings;
    settings.transform[10] = 0.3F;
    lamella::Transform in_double;
    in_double.m[10] = settings.transform[10];
    int met = 0;
    int met_in_double = 0;
    constexpr int tries = 400;
    for (int at = 0; at < tries; ++at) {
        settings.transform[11] = 0.1F * static_cast<float>(at);
        in_double.m[11] = settings.transform[11];
        const float top = 7 * settings.transform[10] + settings.transform[11];
        met += slice(mesh, {top}, settings)[0].islands.empty() ? 0 : 1;
        met_in_double += slice_by_library(soup, top, in_double).contours.empty() ? 0 : 1;
    }
    CHECK(met == tries);
    CHECK(met_in_double < tries);
}

TEST_CASE("a mirrored part stays solid") {
    host::Settings settings;
    settings.transform[0] = -1;
    CHECK(area_mm2(slice(mesh_of(box_with_hole()), {5}, settings)[0]) == Approx(1500));
}

TEST_CASE("gaps are closed against the facets' orientation too, and are warnings of their layer") {
    // In the place of the side y = 0 a wall that is inverted and ends 0.5 and 0.3 mm before the corners.
    const shapes::Soup open = shapes::without(shapes::box({0, 0, 0}, {40, 40, 10}), 4, 2);
    const host::Mesh mesh = mesh_of(shapes::joined({open, shapes::wall({39.7, 0}, {0.5, 0})}));
    const std::vector<host::Layer> layers = slice(mesh, {5, 20, 3});
    for (const std::size_t at : {std::size_t{0}, std::size_t{2}}) {
        CAPTURE(at);
        CHECK(area_mm2(layers[at]) == Approx(1600));
        REQUIRE(layers[at].warnings.size() == 2);
        CHECK(layers[at].warnings[0].rfind("gap closed at ", 0) == 0);
        CHECK(layers[at].warnings[0] != layers[at].warnings[1]);
    }
    CHECK(layers[1].warnings.empty());
    host::Settings settings;
    settings.stitch_mm = 0.4;
    CHECK(slice(mesh, {5}, settings)[0].islands.empty());
}

TEST_CASE("an empty mesh has an empty layer for each height") {
    const std::vector<host::Layer> layers = slice({}, {3, 1, 3});
    REQUIRE(layers.size() == 3);
    for (const host::Layer& layer : layers) {
        CHECK(layer.islands.empty());
    }
    CHECK(slice(mesh_of(box_with_hole()), {}).empty());
}

TEST_CASE("bodies are united or cancel out by the fill rule, and narrow gaps are closed") {
    const host::Mesh overlapping =
        mesh_of(shapes::joined({shapes::box({0, 0, 0}, {10, 10, 10}), shapes::box({5, 0, 0}, {15, 10, 10})}));
    host::Settings settings;
    CHECK(area_mm2(slice(overlapping, {5}, settings)[0]) == Approx(150));
    settings.even_odd = true;
    CHECK(area_mm2(slice(overlapping, {5}, settings)[0]) == Approx(100));

    const host::Mesh apart =
        mesh_of(shapes::joined({shapes::box({0, 0, 0}, {10, 10, 10}), shapes::box({10.05, 0, 0}, {20, 10, 10})}));
    settings = {};
    CHECK(slice(apart, {5}, settings)[0].islands.size() == 1);
    settings.closing_mm = 0;
    CHECK(slice(apart, {5}, settings)[0].islands.size() == 2);
}

TEST_CASE("a mesh beyond a metre keeps its size in nanometres") {
    const host::Layer layer = slice(mesh_of(shapes::box({0, 0, 0}, {4000, 3000, 10})), {5})[0];
    REQUIRE(layer.islands.size() == 1);
    REQUIRE(layer.islands[0].outer.size() == 4);
    const host::Point far = layer.islands[0].outer[2];
    CHECK(static_cast<double>(far.x) == Approx(4e9).margin(8));
    CHECK(static_cast<double>(far.y) == Approx(3e9).margin(8));
}

TEST_CASE("what the host's cancel function throws arrives, and the slicer can be used again") {
    struct Cancelled {
        std::shared_ptr<int> token;
    };
    const host::Mesh mesh = mesh_of(shapes::octasphere({0, 0, 0}, 20, 6));
    std::vector<double> heights(2000);
    std::iota(heights.begin(), heights.end(), 0.0);
    std::transform(heights.begin(), heights.end(), heights.begin(), [](double at) { return 0.01 * (at + 0.5); });
    std::atomic<int> calls = 0;
    lamella::Slicer slicer;
    const auto count = [&] { ++calls; };
    const std::vector<host::Layer> whole = host::slice(mesh, heights, {}, count, slicer);
    const int middle = calls / 2;
    REQUIRE(middle > 1);

    const auto token = std::make_shared<int>(42);
    calls = 0;
    const auto cancel = [&] {
        if (++calls >= middle) {
            throw Cancelled{token};
        }
    };
    CHECK_THROWS_AS(host::slice(mesh, heights, {}, cancel, slicer), Cancelled);
    CHECK(calls >= middle);
    CHECK(token.use_count() == 1);  // nobody keeps the exception

    CHECK(slicer.bytes() > 0);
    const std::vector<host::Layer> again = host::slice(mesh, heights, {}, go_on, slicer);
    CHECK(std::equal(whole.begin(), whole.end(), again.begin(), again.end(),
                     [](const auto& a, const auto& b) { return rings_of(a) == rings_of(b); }));
}

TEST_CASE("an unusable mesh is the host's error, with the library's line") {
    const host::Mesh whole = mesh_of(box_with_hole());
    host::Mesh mesh = whole;
    mesh.vertices[9].y = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(slice(mesh, {5}), "triangle 12, vertex 1, y is not finite");
    mesh = whole;
    mesh.triangles[3].corners[1] = -1;
    CHECK_THROWS_AS(slice(mesh, {5}), host::Error);
    CHECK_THROWS_WITH(slice(mesh, {5}), "triangle 3 has an index beyond the last vertex");
}
