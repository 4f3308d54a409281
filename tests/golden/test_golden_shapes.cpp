// Slices of generated shapes. The generators use sums, products and square roots alone, which every platform rounds alike;
// that their meshes are the committed ones is checked all the same before slices are compared.
#include <span>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "golden/golden_file.hpp"
#include "golden/shape_cases.hpp"

TEST_CASE("outputs are those committed", "[engine][golden]") {
    golden::Group group("");
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        if (!golden::same_input("shape " + mesh_name, golden::hash_of(mesh))) {
            continue;
        }
        for (const auto& [plan_name, options] : shape_cases::plans()) {
            group.output(std::string(mesh_name).append(", ").append(plan_name), hash_result(sliced(mesh, options)));
        }
        const std::vector<float> floats = shapes::floats(mesh);
        lamella::SliceOptions options = uniform(0.25);
        options.transform = lamella::Transform::from_normal(1, 2, 3);
        group.output(mesh_name + ", float, turned",
                     hash_result(sliced(lamella::MeshView::soup(std::span<const float>(floats)), options)));
    }
    group.finish();
}
