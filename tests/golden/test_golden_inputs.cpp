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
#include "golden/mesh_files.hpp"
#include "golden/shape_cases.hpp"
#include "temp_folder.hpp"

namespace golden {

TEST_CASE("inputs of the golden cases are those committed", "[golden]") {
    Group group("input");
    for (const std::string& name : mesh_names()) {
        group.output(name, hash_of(mesh(name)));
    }
    for (const auto& [name, bytes] : mesh_files()) {
        group.output(name, hash_of(bytes));
    }
    for (const auto& [name, shape] : shape_cases::meshes()) {
        group.output("shape " + name, hash_of(shape));
    }
    group.finish();
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
    Group group("read");
    for (const auto& [name, bytes] : mesh_files()) {
        if (same_input(name, hash_of(bytes))) {
            add_read(group, name, folder.write(name, bytes));
        }
    }
    group.finish();
}

TEST_CASE("outputs are those committed", "[engine][golden]") {
    Group group("");
    for (const auto& [name, shape] : shape_cases::meshes()) {
        if (!same_input("shape " + name, hash_of(shape))) {
            continue;
        }
        for (const auto& [plan_name, options] : shape_cases::plans(shape)) {
            group.output(std::string(name).append(", ").append(plan_name), ::sliced(shape, options).hash());
        }
        const std::vector<float> floats = shapes::floats(shape);
        lamella::SliceOptions options = ::uniform(0.25);
        options.frame.transform = lamella::Transform::from_normal(1, 2, 3);
        group.output(name + ", float, turned",
                     ::sliced(lamella::MeshView::soup(std::span<const float>(floats)), options).hash());
    }
    group.finish();
}

}  // namespace golden
