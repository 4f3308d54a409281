// The made-up host of the page on hosts calls its adapter.
#include <atomic>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "host.hpp"
#include "lamella/lamella.hpp"

std::vector<HostLayer> slice_for_host(const HostMesh& mesh, HostJob& job, lamella::Workspace& workspace);

namespace {

/// Adds a box whose facets look outwards, or inwards.
void add_box(HostMesh& mesh, std::array<float, 3> low, std::array<float, 3> high, bool hollow = false) {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int corner = 0; corner < 8; ++corner) {
        mesh.vertices.push_back({(corner & 1) != 0 ? high[0] : low[0], (corner & 2) != 0 ? high[1] : low[1],
                                 (corner & 4) != 0 ? high[2] : low[2], 0xFFFFFFFF});
    }
    for (const auto [a, b, c, d] : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                                    std::array{1, 3, 7, 5}, std::array{3, 2, 6, 7}, std::array{2, 0, 4, 6}}) {
        mesh.triangles.push_back({7, {first + a, first + (hollow ? c : b), first + (hollow ? b : c)}});
        mesh.triangles.push_back({7, {first + a, first + (hollow ? d : c), first + (hollow ? c : d)}});
    }
}

HostMesh pipe() {
    HostMesh mesh;
    add_box(mesh, {0, 0, 0}, {10, 8, 6});
    add_box(mesh, {2, 2, -1}, {4, 6, 7}, true);
    return mesh;
}

double area_mm2(const HostPolygon& polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const HostPoint& a = polygon[i];
        const HostPoint& b = polygon[(i + 1) % polygon.size()];
        twice += static_cast<double>(a.x) * static_cast<double>(b.y) - static_cast<double>(b.x) * static_cast<double>(a.y);
    }
    return twice / 2e12;
}

double area_mm2(const HostLayer& layer) {
    double area = 0;
    for (const HostIsland& island : layer) {
        area += area_mm2(island.outer);
        for (const HostPolygon& hole : island.holes) {
            area += area_mm2(hole);
        }
    }
    return area;
}

struct Cancelled {
    int reason;
};

}  // namespace

TEST_CASE("the adapter on the page gives the host islands by height", "[examples][host]") {
    lamella::Workspace workspace;
    HostJob job;
    job.heights_mm = {5.5, 0.5, 3, 20, 3};
    const std::vector<HostLayer> layers = slice_for_host(pipe(), job, workspace);
    REQUIRE(layers.size() == 5);
    for (const std::size_t cut : {0, 1, 2, 4}) {
        REQUIRE(layers[cut].size() == 1);
        CHECK(layers[cut][0].outer.size() == 4);
        CHECK(layers[cut][0].holes.size() == 1);
        CHECK(area_mm2(layers[cut]) == Approx(72).epsilon(1e-6));
    }
    CHECK(layers[3].empty());
    CHECK(job.warnings.empty());
}

TEST_CASE("the adapter on the page transforms, and fits large meshes", "[examples][host]") {
    lamella::Workspace workspace;
    HostJob job;
    job.to_bed = {300, 0, 0, 5, 0, 300, 0, 5, 0, 0, 1, 0};  // 3 m wide
    job.heights_mm = {3};
    const std::vector<HostLayer> layers = slice_for_host(pipe(), job, workspace);
    REQUIRE(layers.size() == 1);
    CHECK(area_mm2(layers[0]) == Approx(72 * 90000.0).epsilon(1e-6));
    CHECK(std::llabs(layers[0][0].outer[0].x - 5'000'000) <= 8);
}

TEST_CASE("the adapter on the page closes gaps of any orientation and warns of them", "[examples][host]") {
    lamella::Workspace workspace;
    HostMesh torn;
    add_box(torn, {0, 0, 0}, {1, 1, 6});
    torn.triangles.erase(torn.triangles.begin() + 6, torn.triangles.begin() + 8);  // the wall at x = 1
    std::swap(torn.triangles[4].corners[1], torn.triangles[4].corners[2]);         // the wall at y = 0, inside out
    std::swap(torn.triangles[5].corners[1], torn.triangles[5].corners[2]);
    HostJob job;
    job.heights_mm = {3, 4};
    const std::vector<HostLayer> layers = slice_for_host(torn, job, workspace);
    CHECK(area_mm2(layers[0]) == Approx(1).epsilon(1e-5));
    CHECK(area_mm2(layers[1]) == Approx(1).epsilon(1e-5));
    CHECK(job.warnings == std::vector<std::string>{"2 gaps in the outlines were closed"});
}

TEST_CASE("the adapter on the page gives empty layers of an empty mesh", "[examples][host]") {
    lamella::Workspace workspace;
    HostJob job;
    job.heights_mm = {1, 2};
    const std::vector<HostLayer> layers = slice_for_host({}, job, workspace);
    REQUIRE(layers.size() == 2);
    CHECK(layers[0].empty());
    CHECK(layers[1].empty());
}

TEST_CASE("the host's own exception ends a call of the adapter on the page", "[examples][host]") {
    lamella::Workspace workspace;
    HostJob job;
    job.heights_mm = {1, 2, 3};
    std::atomic<int> asked = 0;
    job.throw_on_cancel = [&asked] {
        if (++asked == 2) {
            throw Cancelled{42};
        }
    };
    try {
        slice_for_host(pipe(), job, workspace);
        FAIL("nothing was thrown");
    } catch (const Cancelled& cancelled) {
        CHECK(cancelled.reason == 42);
    }
    job.throw_on_cancel = [] {};
    CHECK(area_mm2(slice_for_host(pipe(), job, workspace)[0]) == Approx(72).epsilon(1e-6));
}

TEST_CASE("the host's exception names what is wrong with the mesh", "[examples][host]") {
    lamella::Workspace workspace;
    HostMesh mesh = pipe();
    mesh.vertices[9].y = std::numeric_limits<float>::quiet_NaN();
    HostJob job;
    job.heights_mm = {3};
    CHECK_THROWS_WITH(slice_for_host(mesh, job, workspace),
                      Catch::StartsWith("triangle 1") && Catch::EndsWith("y is not finite"));
    CHECK_THROWS_AS(slice_for_host(mesh, job, workspace), HostError);
}
