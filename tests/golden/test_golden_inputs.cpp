// The inputs themselves, so that a result that differs is told from an input that does.
#include <algorithm>
#include <string>

#include <catch2/catch.hpp>

#include "golden/golden_file.hpp"
#include "golden/inputs.hpp"
#include "golden/mesh_files.hpp"
#include "golden/shape_cases.hpp"

TEST_CASE("inputs of the golden cases are those committed", "[golden]") {
    golden::Group group("input");
    for (const std::string& name : golden::mesh_names()) {
        group.output(name, golden::hash_of(golden::mesh(name)));
    }
    for (const auto& [name, bytes] : golden::mesh_files()) {
        group.output(name, golden::hash_of(bytes));
    }
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        group.output("shape " + name, golden::hash_of(mesh));
    }
    group.finish();
}

TEST_CASE("float and double hold the same golden meshes", "[golden]") {
    for (const std::string& name : golden::mesh_names()) {
        INFO(name);
        const golden::Soup mesh = golden::mesh(name);
        CHECK(
            std::all_of(mesh.begin(), mesh.end(), [](double x) { return static_cast<double>(static_cast<float>(x)) == x; }));
    }
}
