// The made-up slicer of the page about hosts, with lamella as its slicing step: what its layers must be.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "adapter.hpp"

namespace {

const host::ThrowOnCancel go_on = [] {};

void add_triangle(host::Mesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c) {
    mesh.triangles.push_back({{a, b, c}, 7});
}

struct Corner {
    float x, y, z;
};

// Twelve triangles, counter-clockwise as seen from outside.
void add_box(host::Mesh& mesh, Corner low, Corner high, bool inverted = false) {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int corner = 0; corner < 8; ++corner) {
        mesh.vertices.push_back({(corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                                 (corner & 4) != 0 ? high.z : low.z, 0xffffffff});
    }
    constexpr std::int32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    for (const auto& face : faces) {
        add_triangle(mesh, first + face[0], first + face[inverted ? 2 : 1], first + face[inverted ? 1 : 2]);
    }
}

host::Mesh box(Corner low, Corner high) {
    host::Mesh mesh;
    add_box(mesh, low, high);
    return mesh;
}

host::Mesh box_with_hole() {
    host::Mesh mesh = box({0, 0, 0}, {40, 40, 10});
    add_box(mesh, {10, 10, 2}, {20, 20, 8}, true);
    return mesh;
}

host::Mesh sphere(int rings, float radius) {
    host::Mesh mesh;
    const int around = 2 * rings;
    for (int ring = 0; ring <= rings; ++ring) {
        for (int at = 0; at < around; ++at) {
            const float polar = std::numbers::pi_v<float> * static_cast<float>(ring) / static_cast<float>(rings);
            const float turn = std::numbers::pi_v<float> * static_cast<float>(at) / static_cast<float>(rings);
            mesh.vertices.push_back({radius * std::sin(polar) * std::cos(turn), radius * std::sin(polar) * std::sin(turn),
                                     -radius * std::cos(polar), 0});
        }
    }
    for (int ring = 0; ring < rings; ++ring) {
        for (int at = 0; at < around; ++at) {
            const int a = ring * around + at;
            const int b = ring * around + (at + 1) % around;
            add_triangle(mesh, a, b, b + around);
            add_triangle(mesh, a, b + around, a + around);
        }
    }
    return mesh;
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

std::vector<host::Polygon> polygons_of(const host::Layer& layer) {
    std::vector<host::Polygon> all;
    for (const host::Island& island : layer.islands) {
        all.push_back(island.outer);
        all.insert(all.end(), island.holes.begin(), island.holes.end());
    }
    return all;
}

bool same(const host::Polygon& a, const host::Polygon& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](host::Point p, host::Point q) { return p.x == q.x && p.y == q.y; });
}

bool same(const host::Layer& a, const host::Layer& b) {
    const std::vector<host::Polygon> of_a = polygons_of(a);
    const std::vector<host::Polygon> of_b = polygons_of(b);
    return std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                      [](const host::Polygon& p, const host::Polygon& q) { return same(p, q); });
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

host::Polygon points_of(const lamella::SliceResult& result, std::size_t contour) {
    host::Polygon points;
    for (const lamella::Point point : result.points_of(result.contours[contour])) {
        points.push_back({point.x, point.y});
    }
    return points;
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
        const lamella::SliceResult expected = slice_by_library(mesh, heights[at]);
        const std::vector<host::Polygon> polygons = polygons_of(layers[at]);
        REQUIRE(polygons.size() == expected.contours.size());
        for (std::size_t contour = 0; contour < polygons.size(); ++contour) {
            CHECK(polygons[contour].size() == 4);
            CHECK(same(polygons[contour], points_of(expected, contour)));
        }
    }
    REQUIRE(layers[0].islands.size() == 1);
    REQUIRE(layers[0].islands[0].holes.size() == 1);
    CHECK(area_mm2(layers[0].islands[0].holes[0]) == Approx(-100));
    CHECK(same(layers[0], layers[2]));
}

TEST_CASE("points are those of slice(), to the nanometre") {
    const host::Mesh mesh = sphere(20, 17.3F);
    const std::vector<host::Layer> layers = slice(mesh, {3.3});
    REQUIRE(layers[0].islands.size() == 1);
    const host::Polygon& points = layers[0].islands[0].outer;
    CHECK(same(points, points_of(slice_by_library(mesh, 3.3), 0)));
    CHECK(std::any_of(points.begin(), points.end(), [](host::Point point) { return point.x % 2 != 0; }));
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
    host::Mesh mesh = box({0, 0, 0}, {40, 40, 10});
    // In the place of the side y = 0 a wall that is inverted and ends 0.5 and 0.3 mm before the corners.
    mesh.triangles.erase(mesh.triangles.begin() + 4, mesh.triangles.begin() + 6);
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{0.5F, 0, 0, 0}, {39.7F, 0, 0, 0}, {0.5F, 0, 10, 0}, {39.7F, 0, 10, 0}});
    add_triangle(mesh, first, first + 2, first + 1);
    add_triangle(mesh, first + 1, first + 2, first + 3);
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
    host::Mesh overlapping = box({0, 0, 0}, {10, 10, 10});
    add_box(overlapping, {5, 0, 0}, {15, 10, 10});
    host::Settings settings;
    CHECK(area_mm2(slice(overlapping, {5}, settings)[0]) == Approx(150));
    settings.even_odd = true;
    CHECK(area_mm2(slice(overlapping, {5}, settings)[0]) == Approx(100));

    host::Mesh apart = box({0, 0, 0}, {10, 10, 10});
    add_box(apart, {10.05F, 0, 0}, {20, 10, 10});
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
    const host::Mesh mesh = sphere(200, 20);
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
    CHECK(std::equal(whole.begin(), whole.end(), again.begin(), again.end(),
                     [](const host::Layer& a, const host::Layer& b) { return same(a, b); }));
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
