// The inputs themselves, so that a result that differs is told from an input that does; and the shortest ways from them:
// files that are read, and slices of generated shapes. Their generators use sums, products and square roots alone, which
// every platform rounds alike.
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "golden/calls.hpp"
#include "golden/shape_cases.hpp"
#include "temp_folder.hpp"

namespace golden {

namespace {

std::uint64_t hash_of_file(const lamella::MeshFile& file) {
    Hash hash;
    const lamella::MeshView view = file.view();
    const std::size_t number = size_of(view.vertex_type);
    const std::size_t rows = view.indices == nullptr ? view.triangle_count : view.vertex_count;
    const std::size_t row_bytes = number * (view.indices == nullptr ? 9 : 3);
    for (std::size_t row = 0; row < rows; ++row) {
        hash.add(std::string_view(reinterpret_cast<const char*>(view.vertex_at(row)), row_bytes));
    }
    hash.add(file.indices, name_of(file.format), view.triangle_count, view.vertex_count, number, file.text, file.compressed,
             file.mm_per_unit, file.states_unit, name_of(file.patient_frame), file.warnings.size(), file.file_bytes);
    return hash.value();
}

/// The same read and mapped, on 1 and 3 threads.
void add_read(Hashes& hashes, const std::string& name, const std::filesystem::path& path) {
    std::vector<std::uint64_t> found;
    for (const bool map : {false, true}) {
        for (const int threads : {1, 3}) {
            found.push_back(hash_of_file(
                value_of(lamella::read_mesh(path, {.map_file = map, .mm_per_unit = 0.5}, {.threads = threads}))));
        }
    }
    INFO(name);
    CHECK(std::count(found.begin(), found.end(), found.front()) == 4);
    add(hashes, name, found.front());
}

}  // namespace

TEST_CASE("inputs of the golden cases are those committed", "[golden]") {
    Hashes hashes;
    for (const std::string& name : mesh_names()) {
        add(hashes, name, hash_of(mesh(name)));
    }
    for (const auto& [name, bytes] : mesh_files()) {
        add(hashes, name, hash_of(bytes));
    }
    for (const auto& [name, shape] : shape_cases::meshes()) {
        add(hashes, "shape " + name, hash_of(shape));
    }
    check_golden("input", hashes);
}

TEST_CASE("generated models have the committed bytes on every platform", "[golden][models]") {
    using namespace lamella::models;
    std::vector<Recipe> recipes{{.shape = Shape::gyroid, .triangles = 200'000, .seed = 3},
                                {.shape = Shape::bone, .triangles = 400'000, .seed = 3}};
    for (const Shape shape : {Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism}) {
        recipes.push_back({.shape = shape, .triangles = 3000});
        const std::uint64_t segments = shape == Shape::gyroid ? 300'000 : 100'000;
        recipes.push_back({shape, 20'000, 40, 30.0, segments, 0.032, Order::random, 9});
    }
    const TempFolder folder;
    Hashes hashes;
    for (const Recipe& recipe : recipes) {
        CHECK(value_of(write_stl(recipe, folder / "mesh.stl")) == recipe.triangles);
        const std::string name(shape_names[static_cast<std::size_t>(recipe.shape)]);
        add(hashes, name + " of " + std::to_string(recipe.triangles), hash_of(bytes_of(folder / "mesh.stl")));
    }
    check_golden("models", hashes);
}

TEST_CASE("float and double hold the same golden meshes", "[golden]") {
    for (const std::string& name : mesh_names()) {
        INFO(name);
        const Soup doubles = mesh(name);
        CHECK(std::all_of(doubles.begin(), doubles.end(),
                          [](double x) { return static_cast<double>(static_cast<float>(x)) == x; }));
    }
}

TEST_CASE("files of every format are read to the committed meshes", "[golden][input]") {
    const TempFolder folder;
    Hashes hashes;
    for (const auto& [name, bytes] : mesh_files()) {
        if (same_input(name, hash_of(bytes))) {
            add_read(hashes, name, folder.write(name, bytes));
        }
    }
    check_golden("read", hashes);
}

TEST_CASE("outputs are those committed", "[engine][golden]") {
    Hashes hashes;
    for (const auto& [name, shape] : shape_cases::meshes()) {
        if (!same_input("shape " + name, hash_of(shape))) {
            continue;
        }
        for (const auto& [plan_name, options] : shape_cases::plans(shape)) {
            add(hashes, std::string(name).append(", ").append(plan_name), sliced(shape, options).hash());
        }
        const std::vector<float> floats = shapes::floats(shape);
        lamella::SliceOptions options = uniform(0.25);
        options.frame.transform = lamella::Transform::from_normal(1, 2, 3);
        add(hashes, name + ", float, turned",
            sliced(lamella::MeshView::soup(std::span<const float>(floats)), options).hash());
    }
    check_golden("", hashes);
}

}  // namespace golden
