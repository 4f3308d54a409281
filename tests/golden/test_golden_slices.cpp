// The inputs themselves, whose generators use sums, products and square roots alone, which every platform rounds alike; and
// slices of the embedded meshes: every option that decides what comes out, whatever the threads, bands and form.
#include <utility>

#include <catch2/catch.hpp>

#include "golden/golden.hpp"

using namespace lamella;

namespace golden {

namespace {

struct Case {
    std::string name;
    std::string mesh;
    Options options;
    Form form = Form::f64_soup;
    Tuning tuning{};
};

/// Axes exchanged, mirrored, halved and moved: all exact.
Options mapped(Options options) {
    options.frame.transform.m = {0, 0.5, 0, 3, 0, 0, -0.5, 1.25, 0.5, 0, 0, -40};
    return options;
}

/// Every case of a group.
void check_cases(const std::string& group_name, const std::vector<Case>& cases) {
    Hashes hashes;
    for (const Case& at : cases) {
        const HeldMesh held(mesh(at.mesh), at.form);
        add_slices(hashes, at.name, held.view(), at.options, at.tuning);
    }
    check_golden(group_name, hashes);
}

/// Every millimetre and half, where the lattice meshes have their vertices, and heights between and outside.
std::vector<double> listed_heights() {
    std::vector<double> heights{-3.5, -0.015625};
    for (int i = 0; i < 28; ++i) {
        heights.insert(heights.end(), {double(i), i + 0.1, i + 0.5, i + 0.515625});
    }
    heights.push_back(4000);
    return heights;
}

TEST_CASE("inputs of the golden cases are those committed", "[golden]") {
    Hashes hashes;
    for (const std::string& name : mesh_names()) {
        add(hashes, name, hash_of(mesh(name)));
    }
    for (const auto& [name, shape] : shape_cases::meshes()) {
        add(hashes, "shape " + name, hash_of(shape));
    }
    check_golden("input", hashes);
}

TEST_CASE("outputs are those committed", "[engine][golden]") {
    Hashes hashes;
    for (const auto& [name, shape] : shape_cases::meshes()) {
        for (const auto& [plan_name, options] : shape_cases::plans(shape)) {
            add(hashes, std::string(name).append(", ").append(plan_name), sliced(shape, options).hash());
        }
        const std::vector<float> floats = shapes::floats(shape);
        add(hashes, name + ", float, turned", sliced(view_of(floats), turned(1, 2, 3, uniform(0.25))).hash());
    }
    check_golden("", hashes);
}

TEST_CASE("surfaces of every kind give the committed slices", "[golden]") {
    std::vector<Case> cases;
    for (const std::string& name : mesh_names()) {
        if (!name.starts_with("wide ")) {  // which are there to make planes wide
            cases.push_back({name, name, uniform(0.375)});
        }
    }
    check_cases("surface", cases);
}

TEST_CASE("planes of every plan give the committed slices", "[golden]") {
    std::vector<Case> cases;
    for (const std::string mesh : {"voxel body", "torn body", "lattice triangles", "checkerboard"}) {
        cases.insert(
            cases.end(),
            {{mesh + ", uniform above", mesh, above(uniform(0.5))},
             {mesh + ", uniform from zero",
              mesh,
              {.layer_height_mm = 0.7, .planes = {.first_height_mm = 0.3, .datum = Datum::zero}}},
             {mesh + ", uniform, layers of a tenth", mesh, uniform(0.1)},
             {mesh + ", explicit below", mesh, at_heights(listed_heights(), 0)},
             {mesh + ", explicit above", mesh, above(at_heights(listed_heights(), 0))},
             {mesh + ", random", mesh, {}, Form::f64_soup, {.random_heights = RandomHeights{0.05, 0.6, 3}}},
             {mesh + ", random above", mesh, above({}), Form::f64_soup, {.random_heights = RandomHeights{0.2, 0.3, 4}}}});
    }
    check_cases("planes", cases);
}

TEST_CASE("grids and frames give the committed slices", "[golden]") {
    std::vector<Case> cases;
    for (const std::string mesh : {"voxel body", "tetrahedra", "self-crossing prisms"}) {
        cases.insert(cases.end(), {{mesh + ", coarse grid", mesh, on_grid(0x1p-5, uniform(0.25))},
                                   {mesh + ", coarsest grid", mesh, above(on_grid(0x1p-1, uniform(4)))},
                                   {mesh + ", turned", mesh, turned(1, 2, 3, uniform(0.375))},
                                   {mesh + ", turned over", mesh, turned(-3, 1, -2, uniform(0.375))},
                                   {mesh + ", mirrored", mesh, mapped(uniform(0.1875))}});
    }
    check_cases("frame", cases);
}

TEST_CASE("fill rules give the committed slices", "[golden]") {
    std::vector<Case> cases;
    for (const std::string mesh :
         {"overlapping boxes", "crossing bodies", "self-crossing prisms", "nested boxes", "tetrahedra", "crowded tetrahedra",
          "checkerboard", "body of mixed senses", "body with degenerate faces", "torn body"}) {
        for (const Rule rule : {Rule::even_odd, Rule::non_zero, Rule::positive}) {
            const std::string name = mesh + ", " + std::string(name_of(rule));
            cases.push_back({name, mesh, filled(rule, uniform(1.25))});
            cases.push_back({name + ", coarse grid", mesh, filled(rule, on_grid(0x1p-4, uniform(2.5)))});
        }
    }
    check_cases("fill", cases);
}

TEST_CASE("closed gaps give the committed slices", "[golden]") {
    std::vector<Case> cases;
    for (const std::string mesh : {"torn body", "cracked body", "lattice triangles"}) {
        for (const double reach : {0.03125, 0.5, 2.0}) {
            const std::string name = mesh + ", reach " + std::to_string(static_cast<int>(reach * 32)) + "/32 mm";
            cases.push_back({name, mesh, stitched(reach, uniform(0.375))});
        }
        // On so coarse a grid many ends are equally near.
        cases.push_back({mesh + ", coarse grid", mesh, stitched(4, on_grid(0x1p-2, uniform(1)))});
        cases.push_back({mesh + ", then non-zero", mesh, filled(Rule::non_zero, stitched(1, uniform(1.5)))});
    }
    check_cases("gaps", cases);
}

TEST_CASE("coordinates in every form give the committed slices", "[golden]") {
    const std::pair<std::string, Form> forms[] = {{"double soup", Form::f64_soup},
                                                  {"float soup", Form::f32_soup},
                                                  {"indexed doubles", Form::f64_indexed},
                                                  {"indexed floats", Form::f32_indexed},
                                                  {"floats as in STL", Form::f32_strided}};
    std::vector<Case> cases;
    for (const auto& [name, form] : forms) {
        for (const std::string mesh : {"voxel body", "lattice triangles"}) {
            cases.push_back({mesh + ", " + name, mesh, uniform(0.25), form});
            cases.push_back({mesh + ", " + name + ", explicit", mesh, at_heights(listed_heights(), 0), form});
            cases.push_back({mesh + ", " + name + ", turned", mesh, turned(2, -1, 5, uniform(0.25)), form});
        }
    }
    check_cases("form", cases);
}

TEST_CASE("many planes give the committed slices in several bands", "[golden]") {
    Hashes hashes;
    for (const std::string name : {"voxel body", "torn body"}) {
        CHECK(add_slices(hashes, name, HeldMesh(mesh(name)).view(), uniform(0.03125)) > 1);
    }
    check_golden("bands", hashes);
}

TEST_CASE("wide planes give the committed slices", "[golden][wide]") {
    check_cases("wide", {{"comb", "wide comb", at_heights({0.25, 0.5, 0.75}, 0)},
                         {"boxes", "wide boxes", at_heights({0.0625, 0.5}, 0)},
                         {"comb, floats", "wide comb", at_heights({0.3}, 0), Form::f32_soup},
                         {"boxes, indexed", "wide boxes", at_heights({0.7}, 0), Form::f32_indexed}});
}

}  // namespace
}  // namespace golden
