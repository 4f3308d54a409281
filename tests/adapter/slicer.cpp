// The made-up slicer of the page about hosts, with lamella as its slicing step: what its layers must be.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

host::Mesh box(shapes::Xyz low, shapes::Xyz high) {
    return mesh_of(shapes::box(low, high));
}

host::Mesh box_with_hole() {
    return mesh_of(
        shapes::joined({shapes::box({0, 0, 0}, {40, 40, 10}), shapes::flipped(shapes::box({10, 10, 2}, {20, 20, 8}))}));
}

std::vector<host::Layer> slice(const host::Mesh& mesh, const std::vector<double>& heights_mm,
                               const host::Settings& settings = {}) {
    lamella::Slicer slicer;
    return host::slice(mesh, heights_mm, settings, go_on, slicer);
}

double area_mm2(const host::Polygon& polygon) {
    double twice = 0;
    for (std::size_t at = 0; at < polygon.size(); ++at) {
        const host::Point a = polygon[at];
        const host::Point b = polygon[(at + 1) % polygon.size()];
        twice += static_cast<double>(a.x) * static_cast<double>(b.y) - static_cast<double>(b.x) * static_cast<double>(a.y);
    }
    return twice / 2 * 1e-12;
}

double area_mm2(const host::Layer& layer) {
    double sum = 0;
    for (const host::Island& island : layer.islands) {
        sum += area_mm2(island.outer);
        for (const host::Polygon& hole : island.holes) {
            sum += area_mm2(hole);
        }
    }
    return sum;
}

using Points = std::vector<std::pair<std::int64_t, std::int64_t>>;

/// To be compared.
Points points_of(const host::Polygon& polygon) {
    Points points;
    for (const host::Point& point : polygon) {
        points.emplace_back(point.x, point.y);
    }
    return points;
}

std::vector<Points> polygons_of(const host::Layer& layer) {
    std::vector<Points> all;
    for (const host::Island& island : layer.islands) {
        all.push_back(points_of(island.outer));
        std::transform(island.holes.begin(), island.holes.end(), std::back_inserter(all), points_of);
    }
    return all;
}

std::vector<std::vector<Points>> polygons_of(const std::vector<host::Layer>& layers) {
    std::vector<std::vector<Points>> all;
    for (const host::Layer& layer : layers) {
        all.push_back(polygons_of(layer));
    }
    return all;
}

std::vector<float> soup_of(const host::Mesh& mesh) {
    std::vector<float> soup;
    for (const host::Triangle& triangle : mesh.triangles) {
        for (const std::int32_t corner : triangle.corners) {
            const host::Vertex& vertex = mesh.vertices[static_cast<std::size_t>(corner)];
            soup.insert(soup.end(), {vertex.x, vertex.y, vertex.z});
        }
    }
    return soup;
}

// One plane by the library's plainest call.
lamella::SliceResult slice_by_library(const host::Mesh& mesh, double height_mm, lamella::Transform transform = {}) {
    lamella::SliceOptions options;
    options.heights_mm = std::vector<double>{height_mm};
    options.frame.grid_mm = 1e-6;
    options.frame.transform = transform;
    options.region.fill_rule = lamella::FillRule::non_zero;
    options.region.drop_collinear = true;
    const std::vector<float> soup = soup_of(mesh);
    lamella::Result<lamella::SliceResult> sliced = lamella::slice(lamella::MeshView::soup(soup), options);
    REQUIRE(sliced);
    return std::move(*sliced);
}

std::vector<Points> polygons_of(const lamella::SliceResult& result) {
    std::vector<Points> all;
    for (const lamella::Contour& contour : result.contours) {
        Points& points = all.emplace_back();
        for (const lamella::Point point : result.points_of(contour)) {
            points.emplace_back(point.x, point.y);
        }
    }
    return all;
}

std::vector<double> every(double step_mm, std::size_t count) {
    std::vector<double> heights(count);
    for (std::size_t at = 0; at < count; ++at) {
        heights[at] = step_mm * (static_cast<double>(at) + 0.5);
    }
    return heights;
}

}  // namespace

TEST_CASE("the adapter gives the layers of slice(), in the order of the heights") {
    const host::Mesh mesh = box_with_hole();
    const std::vector<double> heights{5, 1, 5, 9, 20, 1, -3};
    const std::vector<double> areas{1500, 1600, 1500, 1600, 0, 1600, 0};
    const std::vector<host::Layer> layers = slice(mesh, heights);
    REQUIRE(layers.size() == heights.size());
    for (std::size_t at = 0; at < heights.size(); ++at) {
        CAPTURE(at);
        CHECK(area_mm2(layers[at]) == Approx(areas[at]).margin(1e-4));
        CHECK(layers[at].warnings.empty());
        CHECK(polygons_of(layers[at]) == polygons_of(slice_by_library(mesh, heights[at])));
    }
    REQUIRE(layers[0].islands.size() == 1);
    REQUIRE(layers[0].islands[0].holes.size() == 1);
    CHECK(area_mm2(layers[0].islands[0].holes[0]) == Approx(-100));
    CHECK(polygons_of(layers[0]) == polygons_of(layers[2]));
}

TEST_CASE("points are those of slice(), to the nanometre") {
    const host::Mesh mesh = mesh_of(shapes::octasphere({0, 0, 0}, 17.3, 4));
    const std::vector<Points> polygons = polygons_of(slice(mesh, {3.3})[0]);
    REQUIRE(polygons.size() == 1);
    CHECK(polygons == polygons_of(slice_by_library(mesh, 3.3)));
    CHECK(std::any_of(polygons[0].begin(), polygons[0].end(), [](const auto& point) { return point.first % 2 != 0; }));
}

TEST_CASE("a face on a plane is met where the host's floats put it") {
    const host::Mesh mesh = box({0, 0, 0}, {9, 9, 7});
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
        met_in_double += slice_by_library(mesh, top, in_double).contours.empty() ? 0 : 1;
    }
    CHECK(met == tries);
    CHECK(met_in_double < tries);
}

TEST_CASE("a mirrored part stays solid") {
    host::Settings settings;
    settings.transform[0] = -1;
    CHECK(area_mm2(slice(box_with_hole(), {5}, settings)[0]) == Approx(1500));
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
    CHECK(slice(box_with_hole(), {}).empty());
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
    const host::Layer layer = slice(box({0, 0, 0}, {4000, 3000, 10}), {5})[0];
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
    const std::vector<double> heights = every(0.01, 2000);
    std::atomic<int> calls = 0;
    lamella::Slicer slicer;
    const std::vector<host::Layer> whole = host::slice(
        mesh, heights, {}, [&] { ++calls; }, slicer);
    const int middle = calls / 2;
    REQUIRE(middle > 1);

    const auto token = std::make_shared<int>(42);
    calls = 0;
    bool cancelled = false;
    try {
        host::slice(
            mesh, heights, {},
            [&] {
                if (++calls >= middle) {
                    throw Cancelled{token};
                }
            },
            slicer);
    } catch (const Cancelled& thrown) {
        cancelled = true;
        CHECK(thrown.token == token);
    }
    CHECK(cancelled);
    CHECK(calls >= middle);
    CHECK(token.use_count() == 1);  // nobody keeps the exception

    CHECK(slicer.bytes() > 0);
    const std::vector<host::Layer> again = host::slice(mesh, heights, {}, go_on, slicer);
    CHECK((polygons_of(whole) == polygons_of(again)));
}

TEST_CASE("an unusable mesh is the host's error, with the library's line") {
    const auto message_of = [](const host::Mesh& mesh) -> std::string {
        try {
            slice(mesh, {5});
        } catch (const host::Error& error) {
            return error.what();
        }
        return "no error";
    };
    host::Mesh mesh = box_with_hole();
    mesh.vertices[9].y = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> soup = soup_of(mesh);
    CHECK(message_of(mesh) == lamella::slice(lamella::MeshView::soup(soup)).error().message);
    CHECK(message_of(mesh).find("triangle ") != std::string::npos);
    CHECK(message_of(mesh).find('\n') == std::string::npos);

    mesh = box_with_hole();
    mesh.triangles[3].corners[1] = -1;
    CHECK(message_of(mesh) == "triangle 3 has an index beyond the last vertex");
}
