// Files of meshes: their bytes, and what is read of them.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <catch2/catch.hpp>

#include "golden/golden.hpp"
#include "lamella/io.hpp"
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

TEST_CASE("files of the golden cases are those committed", "[golden]") {
    Hashes hashes;
    for (const auto& [name, bytes] : mesh_files()) {
        add(hashes, name, hash_of(bytes));
    }
    check_golden("file", hashes);
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

TEST_CASE("files of every format are read to the committed meshes", "[golden][input]") {
    const TempFolder folder;
    Hashes hashes;
    for (const auto& [name, bytes] : mesh_files()) {
        add_read(hashes, name, folder.write(name, bytes));
    }
    check_golden("read", hashes);
}

}  // namespace golden
