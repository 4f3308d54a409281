// Vertices said to have embedded stars, against every pair of faces around them.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "check/findings.hpp"
#include "mesh/check/embedded_stars.hpp"
#include "mesh/check/finders.hpp"
#include "mesh/check/meeting.hpp"

namespace lamella::check_test {

namespace {

struct Stars {
    std::size_t vertices = 0;
    std::size_t embedded = 0;
    std::size_t pairs = 0;  ///< faces at embedded vertices
};

/// Asserts that faces at a vertex with an embedded star have area, do not meet and are joined in a ring.
Stars examine(const Soup& soup, int threads) {
    const MeshView view = MeshView::soup(std::span<const double>(soup));
    const Parallel parallel({.threads = threads});
    MeshCheck measured;
    measure_mesh(view, {}, parallel, 1, measured);
    const GridMesh mesh = make_grid_mesh(view, {}, measured, parallel);
    const EdgeTable edges(mesh, parallel);
    const EmbeddedStars stars(mesh, edges, parallel);
    std::vector<std::vector<ExactFace>> faces_at(mesh.vertices.size());
    for (const auto& face : mesh.faces) {
        for (const std::uint32_t vertex : face.corners) {
            faces_at[vertex].emplace_back(face.corners, mesh.corners(face));
        }
    }
    Stars found{.vertices = mesh.vertices.size()};
    for (std::uint32_t vertex = 0; vertex < mesh.vertices.size(); ++vertex) {
        if (!stars.contains(vertex)) {
            continue;
        }
        ++found.embedded;
        for (auto face = faces_at[vertex].begin(); face != faces_at[vertex].end(); ++face) {
            REQUIRE(face->has_area());
            for (auto other = faces_at[vertex].begin(); other != face; ++other, ++found.pairs) {
                REQUIRE(meet(*face, *other) == Meeting::none);
            }
        }
    }
    return found;
}

/// A cone without its base: `faces` around the apex, which go round it `rounds` times, up and down by turns.
Soup cone(int faces, int rounds) {
    const auto rim = [&](int i) -> Xyz {
        const double angle = 2 * std::numbers::pi * rounds * (i % faces) / faces;
        return {std::cos(angle), std::sin(angle), 0.1 * (i % faces)};
    };
    Soup soup;
    for (int i = 0; i < faces; ++i) {
        soup = shapes::joined({soup, shapes::triangle({0, 0, 0}, rim(i), rim(i + 1))});
    }
    return soup;
}

}  // namespace

TEST_CASE("nearly every vertex of a smooth body has an embedded star", "[check]") {
    const Stars sphere = examine(shapes::octasphere({1, 2, 3}, 10, 4), GENERATE(1, 3));
    CHECK(sphere.vertices > 500);
    CHECK(100 * sphere.embedded >= 95 * sphere.vertices);
}

TEST_CASE("a vertex around which the faces go twice has no embedded star", "[check]") {
    CHECK(examine(cone(7, 1), 1).embedded == 1);
    CHECK(examine(cone(7, 2), 1).embedded == 0);
    CHECK(examine(cone(15, 4), 1).embedded == 0);
}

TEST_CASE("faces at a vertex with an embedded star do not meet, in meshes of every kind", "[check]") {
    std::mt19937 random(5);
    Stars all;
    for (int round = 0; round < 60; ++round) {
        Soup soup = shapes::octasphere({0, 0, 0}, 10, 2);
        const double jitter = round % 6 * 1.5;
        std::uniform_real_distribution<double> by(-jitter, jitter);
        std::map<Xyz, Xyz> moved;
        for (std::size_t i = 0; i < soup.size(); i += 3) {
            const Xyz at{soup[i], soup[i + 1], soup[i + 2]};
            const auto [place, is_new] =
                moved.try_emplace(at, Xyz{at[0] + by(random), at[1] + by(random), at[2] + by(random)});
            std::copy(place->second.begin(), place->second.end(), soup.begin() + static_cast<std::ptrdiff_t>(i));
        }
        if (round % 2 == 1) {  // on a coarse lattice, with faces missing: flat, doubled and open places
            for (double& coordinate : soup) {
                coordinate = std::round(coordinate / 2);
            }
            soup = without(soup, 3, 2);
        }
        const Stars found = examine(soup, 1);
        all.vertices += found.vertices;
        all.embedded += found.embedded;
        all.pairs += found.pairs;
    }
    CHECK(all.embedded < all.vertices);
    CHECK(all.pairs > 5000);
}

}  // namespace lamella::check_test
