// The same bytes for the same mesh, whatever cuts it and however its triangles lie; and the bytes that are committed.
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <map>
#include <sstream>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "models/models.hpp"

using lamella::ContourForm;
using lamella::models::Shape;

namespace {

shapes::Soup model(Shape shape, std::uint64_t triangles, double height_mm = 20) {
    lamella::models::Recipe recipe;
    recipe.shape = shape;
    recipe.triangles = triangles;
    recipe.height_mm = height_mm;
    const std::vector<float> soup = lamella::models::make_soup(recipe);
    return {soup.begin(), soup.end()};
}

/// Closed ones, open ones, crossing ones, and one with faces of all kinds at its edges.
std::map<std::string, shapes::Soup> meshes() {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    shapes::Soup torn = ball;
    torn.resize(torn.size() - 9 * std::size_t{40});
    return {{"ball", ball},
            {"torn ball", torn},
            {"crossing balls", shapes::joined({ball, shapes::moved(ball, {3, 4, 5}), shapes::flipped(ball)})},
            {"tetrahedra", shapes::random_tetrahedra(11, 60, 9)},
            {"tangle", shapes::joined({shapes::random_soup(5, 200, 8), shapes::random_tetrahedra(6, 20, 8)})},
            {"bone", model(Shape::bone, 30'000)},
            {"gyroid", model(Shape::gyroid, 30'000)},
            {"torus", model(Shape::torus, 5'000)},
            {"prism", model(Shape::prism, 2'000)}};
}

/// By name: uniform, irregular, and by seed.
std::map<std::string, lamella::SliceOptions> plans() {
    std::map<std::string, lamella::SliceOptions> plans;
    plans["uniform"] = uniform(0.25);
    plans["coarse grid"] = uniform(0.25, 0x1p-8);
    plans["random"].plan.spacing = lamella::RandomLayers{0.1, 0.4, 1};
    plans["explicit"].plan.spacing = lamella::ExplicitPlanes{{-8.5, -3, -1, 0, 0.5, 1, 2, 3, 3.0625, 4, 7, 9, 15}};
    plans["explicit"].plan.side = lamella::Side::above;
    return plans;
}

std::string hex(std::uint64_t hash) {
    std::ostringstream out;
    out << std::hex << std::setw(16) << std::setfill('0') << hash;
    return out.str();
}

const std::string golden_file = std::string(LAMELLA_TESTS_DIR) + "/golden/hashes.txt";

/// Lines "hash name".
std::map<std::string, std::string> golden_hashes() {
    std::map<std::string, std::string> hashes;
    std::ifstream in(golden_file);
    std::string hash;
    std::string name;
    while (in >> hash && std::getline(in >> std::ws, name)) {
        hashes[name] = hash;
    }
    return hashes;
}

std::map<std::string, std::string> current_hashes() {
    std::map<std::string, std::string> hashes;
    for (const auto& [mesh_name, mesh] : meshes()) {
        for (const auto& [plan_name, options] : plans()) {
            hashes[std::string(mesh_name).append(", ").append(plan_name)] = hex(output_hash(sliced(mesh, options)));
        }
        const std::vector<float> floats = shapes::floats(mesh);
        hashes[mesh_name + ", float, turned"] = [&] {
            lamella::SliceOptions options = uniform(0.25);
            options.transform = lamella::Transform::from_normal(1, 2, 3);
            return hex(output_hash(sliced(lamella::MeshView::soup(std::span<const float>(floats)), options)));
        }();
    }
    return hashes;
}

}  // namespace

TEST_CASE("threads, bands and forms do not change the output", "[engine][determinism]") {
    for (const auto& [mesh_name, mesh] : meshes()) {
        lamella::SliceOptions options = uniform(0.125);
        options.threads = 1;
        const std::uint64_t expected = output_hash(sliced(mesh, options));
        for (const int threads : {1, 2, 3, 8}) {
            for (const int band : {0, 1, 2, 7, 1000}) {
                for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
                    options.threads = threads;
                    options.band_planes = band;
                    options.form = form;
                    const lamella::Result<lamella::SliceResult> result = slice(view_of(mesh), options);
                    INFO(mesh_name << ", threads " << threads << ", band " << band << ", assembled "
                                   << (form == ContourForm::assembled));
                    REQUIRE(result.ok());
                    REQUIRE(output_hash(*result) == expected);
                }
            }
        }
    }
}

TEST_CASE("the order of triangles and of their vertices does not change the output", "[engine][determinism]") {
    for (const auto& [mesh_name, mesh] : meshes()) {
        for (const auto& [plan_name, options] : plans()) {
            const std::uint64_t expected = output_hash(sliced(mesh, options));
            for (const std::uint64_t seed : {1U, 2U, 3U}) {
                INFO(mesh_name << ", " << plan_name << ", shuffle " << seed);
                CHECK(output_hash(sliced(shapes::shuffled(mesh, seed), options)) == expected);
            }
        }
    }
}

TEST_CASE("triangles that are there several times may lie in any order", "[engine][determinism]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 1);
    const shapes::Soup tangle = shapes::random_tetrahedra(3, 6, 4);
    for (const shapes::Soup& mesh : {shapes::joined({ball, ball}), shapes::joined({ball, ball, ball}),
                                     shapes::joined({ball, shapes::flipped(ball), ball}),
                                     shapes::joined({tangle, tangle, shapes::flipped(tangle), tangle})}) {
        const lamella::SliceResult result = sliced(mesh, uniform(0.25));
        CHECK(result.summary.open_contours == 0);
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            INFO("shuffle " << seed);
            REQUIRE(output_hash(sliced(shapes::shuffled(mesh, seed), uniform(0.25))) == output_hash(result));
        }
    }
}

TEST_CASE("equal parts give equal contours wherever they stand on the grid", "[engine][determinism]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    const lamella::SliceResult here = sliced(ball, uniform(0.25, 0x1p-10));
    // Whole coordinates of the grid first, so that moving rounds nothing.
    shapes::Soup on_grid = ball;
    for (double& number : on_grid) {
        number = std::nearbyint(number * 0x1p9) * 0x1p-9;
    }
    const lamella::SliceResult there = sliced(shapes::moved(on_grid, {64, -32, 16}), uniform(0.25, 0x1p-10));
    REQUIRE(there.points.size() == here.points.size());
    std::size_t equal = 0;
    for (std::size_t i = 0; i < here.points.size(); ++i) {
        equal += there.points[i].x - here.points[i].x == 64 * 1024 && there.points[i].y - here.points[i].y == -32 * 1024;
    }
    CHECK(equal == here.points.size());
}

TEST_CASE("outputs are those committed", "[engine][golden]") {
    const std::map<std::string, std::string> hashes = current_hashes();
    if (std::getenv("LAMELLA_UPDATE_GOLDEN") != nullptr) {  // NOLINT(concurrency-mt-unsafe)
        std::ofstream out(golden_file);
        for (const auto& [name, hash] : hashes) {
            out << hash << ' ' << name << '\n';
        }
        REQUIRE(out.good());
    }
    const std::map<std::string, std::string> golden = golden_hashes();
    CHECK(golden.size() == hashes.size());
    for (const auto& [name, hash] : hashes) {
        INFO(name);
        CHECK((golden.count(name) == 1 ? golden.at(name) : "nothing committed") == hash);
    }
}
