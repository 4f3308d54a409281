// Parts with roles, judged cell by cell: parts are prisms over triangles of a lattice, and so is what is left of each.
#include <array>
#include <bit>
#include <random>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"
#include "regions/lattice.hpp"

using namespace lamella;
using lattice::Cells;
using lattice::cells_of;

namespace {

constexpr double triangle_mm2 = lattice::cell * lattice::cell / 4.0;

/// From z = 0 to 10 on a grid of 1 mm, each triangle by itself.
shapes::Soup prisms_over(Cells cells) {
    shapes::Soup soup;
    const auto add = [&soup](Point p, double z) { soup.insert(soup.end(), {double(p.x), double(p.y), z}); };
    for (int t = 0; t < lattice::triangles; ++t) {
        if ((cells >> t & 1) == 0) {
            continue;
        }
        const auto [a, b, c] = lattice::triangle_of(t);
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
            add(from, 0), add(to, 0), add(to, 10);
            add(from, 0), add(to, 10), add(from, 10);
        }
        add(a, 0), add(c, 0), add(b, 0);
        add(a, 10), add(b, 10), add(c, 10);
    }
    return soup;
}

double area_of(const LayerView& layer, std::uint32_t part) {
    double mm2 = 0;
    for (const Contour& contour : layer.contours) {
        mm2 += contour.part == part ? layer.area_mm2(contour) : 0;
    }
    return mm2;
}

struct LatticeParts {
    std::vector<Cells> cells;
    std::vector<shapes::Soup> soups;
    std::vector<Part> parts;

    void add(Cells own, PartRole role, std::uint32_t object = 0) {
        cells.push_back(own);
        soups.push_back(prisms_over(own));
        parts.push_back({.role = role, .object = object});
    }
    void view() {
        for (std::size_t p = 0; p < parts.size(); ++p) {
            parts[p].mesh = view_of(soups[p]);
        }
    }
    /// By the definition, triangle by triangle.
    Cells left_of(std::size_t part) const {
        Cells left = 0;
        for (int t = 0; t < lattice::triangles; ++t) {
            left |= Cells(owner(t, parts[part].object, part)) << t;
        }
        return left;
    }

private:
    bool owner(int t, std::uint32_t object, std::size_t part) const {
        const bool has_roles = std::any_of(parts.begin(), parts.end(), [object](const Part& other) {
            return other.object == object && (other.role == PartRole::negative || other.role == PartRole::modifier);
        });
        if (!has_roles || parts[part].role == PartRole::support_blocker) {
            return (cells[part] >> t & 1) != 0;
        }
        std::optional<std::size_t> solid;
        std::optional<std::size_t> modifier;
        for (std::size_t p = 0; p < parts.size(); ++p) {
            if (parts[p].object != object || (cells[p] >> t & 1) == 0) {
                continue;
            }
            if (parts[p].role == PartRole::negative) {
                return false;
            }
            solid = parts[p].role == PartRole::solid ? p : solid;
            modifier = parts[p].role == PartRole::modifier ? p : modifier;
        }
        return solid && (modifier ? *modifier : *solid) == part;
    }
};

SliceOptions at_five(FillRule rule = FillRule::contours) {
    SliceOptions options = at_heights({5}, 1);
    options.region.fill_rule = rule;
    return options;
}

TEST_CASE("what is left of each part is what its role gives it, triangle by triangle", "[engine][parts][roles]") {
    std::mt19937_64 random(7);
    for (unsigned round = 0; round < rounds(400); ++round) {
        LatticeParts given;
        const std::size_t count = 1 + random() % 6;
        for (std::size_t p = 0; p < count; ++p) {
            const Cells cells = (round % 2 == 0 ? random() & random() : random()) | 1;
            given.add(cells, static_cast<PartRole>(random() % 4), static_cast<std::uint32_t>(random() % 2));
        }
        given.add(random() | 1, PartRole::negative, 5);  // so that some part has a role; alone in its object
        given.view();
        const FillRule rule = round % 3 == 0 ? FillRule::contours : round % 3 == 1 ? FillRule::non_zero : FillRule::positive;
        const SliceResult result = sliced(given.parts, at_five(rule), {.threads = 1 + static_cast<int>(round % 3)});
        CHECK(result.info.part_count == given.parts.size());
        for (std::uint32_t p = 0; p < given.parts.size(); ++p) {
            const Cells left = given.left_of(p);
            CAPTURE(round, p);
            REQUIRE(cells_of(result[0], p) == left);
            REQUIRE(area_of(result[0], p) == triangle_mm2 * std::popcount(left));  // no gap, no overlap, to the unit
        }
        // United, it is all that is solid, as one region.
        SliceOptions unite = at_five(FillRule::non_zero);
        unite.unite_parts = true;
        Cells solid = 0;
        for (std::uint32_t p = 0; p < given.parts.size(); ++p) {
            solid |= given.parts[p].role == PartRole::support_blocker ? 0 : given.left_of(p);
        }
        const SliceResult one = sliced(given.parts, unite);
        REQUIRE(one[0].area_mm2() == triangle_mm2 * std::popcount(solid));
    }
}

TEST_CASE("boxes with roles have the areas that geometry gives them", "[engine][parts][roles]") {
    const shapes::Soup body = shapes::box({0, 0, 0}, {8, 8, 10});
    const shapes::Soup hole = shapes::box({2, 2, -5}, {4, 4, 5});  // reaches up to half
    const shapes::Soup logo = shapes::box({3, 3, 0}, {6, 6, 20});
    const shapes::Soup blocker = shapes::box({6, 6, 0}, {12, 12, 10});
    const std::vector<Part> parts = {{.mesh = view_of(hole), .role = PartRole::negative},
                                     {.mesh = view_of(logo), .role = PartRole::modifier},
                                     {.mesh = view_of(body)},
                                     {.mesh = view_of(blocker), .role = PartRole::support_blocker}};
    const SliceResult result = sliced(parts, at_heights({2.5, 7.5, 15}));
    const auto areas = [&](std::size_t layer) {
        std::vector<double> mm2;
        for (std::uint32_t p = 0; p < parts.size(); ++p) {
            mm2.push_back(area_of(result[layer], p));
        }
        return mm2;
    };
    CHECK(areas(0) == std::vector<double>{0, 8, 52, 36});
    CHECK(areas(1) == std::vector<double>{0, 9, 55, 36});
    CHECK(areas(2) == std::vector<double>{0, 0, 0, 0});
    CHECK(result.info.options.region.fill_rule == FillRule::non_zero);
    // Of two solids that overlap the last has what both have; a negative part of another object takes nothing.
    const std::vector<Part> two = {{.mesh = view_of(body)},
                                   {.mesh = view_of(logo)},
                                   {.mesh = view_of(hole), .role = PartRole::negative},
                                   {.mesh = view_of(body), .object = 1}};
    const SliceResult objects = sliced(two, at_heights({2.5}));
    CHECK(area_of(objects[0], 0) == 64 - 9 - 3);
    CHECK(area_of(objects[0], 1) == 8);
    CHECK(area_of(objects[0], 3) == 64);
}

TEST_CASE("rules of regions are done to each part before roles, and to what is united after", "[engine][parts][roles]") {
    const shapes::Soup left = shapes::box({0, 0, 0}, {4, 8, 10});
    const shapes::Soup right = shapes::box({5, 0, 0}, {9, 8, 10});
    const shapes::Soup hole = shapes::box({-2, 2, 0}, {20, 6, 10});
    const shapes::Soup both = shapes::joined({left, right});
    const std::vector<Part> apart = {
        {.mesh = view_of(left)}, {.mesh = view_of(right)}, {.mesh = view_of(hole), .role = PartRole::negative}};
    const std::vector<Part> joined = {{.mesh = view_of(both)}, {.mesh = view_of(hole), .role = PartRole::negative}};
    SliceOptions options = at_heights({5});
    options.region = {.fill_rule = FillRule::non_zero, .closing_mm = 1};
    CHECK(sliced(apart, options)[0].area_mm2() == 2 * 4 * 4);
    CHECK(sliced(joined, options)[0].area_mm2() == 9 * 4);
    options.unite_parts = true;
    CHECK(sliced(apart, options)[0].area_mm2() == 9 * 4);
    options.region.fill_from = {{0, FillRule::positive}};
    CHECK(sliced(apart, options)[0].area_mm2() == 9 * 4);
}

TEST_CASE("open contours of parts with roles stay, in the order of starts", "[engine][parts][roles]") {
    const shapes::Soup open = shapes::joined({shapes::without(shapes::box({4, 0, 0}, {10, 10, 10}), 4, 2),  // no front
                                              shapes::box({0, 0, 0}, {2, 2, 10}), shapes::box({20, 0, 0}, {26, 6, 10})});
    const shapes::Soup hole = shapes::box({21, 1, 0}, {22, 2, 10});
    const std::vector<Part> parts = {{.mesh = view_of(open)}, {.mesh = view_of(hole), .role = PartRole::negative}};
    const SliceResult result = sliced(parts, at_heights({5}));
    std::string roles;
    for (const Contour& contour : result.contours) {
        roles += std::string(word_of(contour.role)) + " ";
    }
    CHECK(roles == "outer open outer hole ");
    CHECK(result.contours[3].parent == 2);
    CHECK(result.info.open_contours == 1);
}

TEST_CASE("parts with roles go to every destination, with the same bytes on any threads", "[engine][parts][roles]") {
    const shapes::Soup ball = shapes::octasphere({1, 2, 3}, 10, 4);
    const shapes::Soup bar = shapes::box({-4, 4, 0.5}, {40, 6, 20});
    const shapes::Soup small = shapes::octasphere({0, 0, 5}, 4, 4);
    const std::vector<Part> parts = {{.mesh = view_of(ball)},
                                     {.mesh = view_of(small), .role = PartRole::negative},
                                     {.mesh = view_of(bar), .role = PartRole::modifier}};
    const SliceResult result = sliced(parts, uniform(0.1), {.threads = 1});
    CHECK(sliced(parts, uniform(0.1), {.threads = 4}).hash() == result.hash());
    LayerHash hash(result.size());
    const auto take = [&hash](const LayerView& layer) noexcept { hash.add(layer); };
    sliced_to(LayerSink{.take = take}, parts, uniform(0.1));
    CHECK(hash.value() == result.hash());
    require_at_every_destination(result, parts, uniform(0.1));
    for (std::uint64_t fails_at = 1; fails_at < 2000; fails_at += 37) {
        CountingMemory memory(~std::size_t{0}, fails_at);
        const auto code = code_of(Slicer().slice(parts, uniform(1), {.threads = 1, .memory = &memory}));
        CHECK((!code || *code == ErrorCode::out_of_memory));
        CHECK(memory.held() == 0);
    }
}

TEST_CASE("roles that cannot be are refused", "[engine][parts][roles][errors]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {4, 4, 4});
    std::vector<Part> parts(2, {.mesh = view_of(cube)});
    parts[1].role = static_cast<PartRole>(9);
    const Error none = failure_of(parts, uniform(1));
    CHECK(none.message == "part 1: there is no role 9");
    CHECK(none.part == 1);
    parts[1].role = PartRole::modifier;
    SliceOptions origins = uniform(1);
    origins.origins = true;
    CHECK_THAT(failure_of(parts, origins).message, Catch::StartsWith("parts with roles have no origins"));
    parts.resize(64, parts[0]);
    CHECK(failure_of(parts, uniform(1)).message ==
          "object 0 has 64 parts; of an object with roles at most 63 can be overlaid");
    parts[3].object = 1;
    CHECK(area_of(sliced(parts, uniform(1))[0], 1) == 16);
}

TEST_CASE("many small parts side by side are what they are one by one", "[engine][parts][threads]") {
    std::vector<shapes::Soup> soups;
    std::vector<Part> parts;
    for (int i = 0; i < 40; ++i) {
        soups.push_back(shapes::octasphere({i % 7 * 5.0, i % 5 * 4.0, i % 3 * 1.5}, 2 + i % 4, 3));
    }
    soups[11] = shapes::without(soups[11], 20, 9);
    for (const shapes::Soup& soup : soups) {
        parts.push_back({.mesh = view_of(soup)});
    }
    SliceOptions options = uniform(0.05);
    options.origins = true;
    options.stitch_mm = stitch_by_mesh;
    const SliceResult alone = sliced(parts, options, {.threads = 1});
    std::vector<double> progress;
    const auto report = [&progress](double share) noexcept { progress.push_back(share); };
    CHECK(sliced(parts, options, {.threads = 3, .progress = report}).hash() == alone.hash());
    CHECK(std::is_sorted(progress.begin(), progress.end()));
    CHECK(progress.back() == 1);
    // A limit refuses the same on any threads.
    const std::uint64_t most = alone.points.size() * 16 + alone.contours.size() * 48 + 40 * 64 * alone.size();
    std::optional<std::uint64_t> enough;
    for (std::uint64_t limit = most / 8; limit < 2 * most; limit += most / 8) {
        const auto one = Slicer().slice(parts, options, {.threads = 1, .memory_limit_bytes = limit});
        const auto three = Slicer().slice(parts, options, {.threads = 3, .memory_limit_bytes = limit});
        REQUIRE(one.ok() == three.ok());
        CHECK((one.ok() || one.error().message == three.error().message));
        enough = one.ok() && !enough ? limit : enough;
    }
    CHECK((enough && *enough > most / 8));
    // The first that fails speaks.
    soups[30][40] = soups[20][40] = std::nan("");
    CHECK_THAT(failure_of(parts, options, {.threads = 3}).message, Catch::StartsWith("part 20: triangle 4, "));
    Slicer slicer;
    const shapes::Soup dust = shapes::box({0, 0, 0}, {1e-9, 1e-9, 1e-9});
    parts[20].mesh = parts[30].mesh = parts[25].mesh = view_of(dust);
    CHECK_THAT(failure_of(parts, options, {.threads = 3}).message, Catch::StartsWith("part 20: each of 12 triangles has"));
}

TEST_CASE("prepared parts are cut as their meshes are", "[engine][parts][prepared]") {
    const shapes::Soup ball = shapes::octasphere({1, 2, 3}, 10, 4);
    const shapes::Soup bar = shapes::box({-4, 4, 0.5}, {40, 6, 20});
    const Transform turn = Transform::from_normal(1, 2, 30);
    SliceOptions options = uniform(0.2, default_grid_mm);
    const PreparedMesh turned = value_of(prepare(view_of(bar), {.transform = turn, .grid_mm = default_grid_mm}));
    const PreparedMesh plain = value_of(prepare(view_of(ball)));
    const std::vector<Part> meshes = {
        {.mesh = view_of(ball)}, {.mesh = view_of(bar), .placement = turn}, {.mesh = view_of(bar), .placement = turn}};
    const std::vector<Part> prepared = {
        {.prepared = &plain}, {.placement = turn, .prepared = &turned}, {.prepared = &turned}};
    const std::uint64_t hash = sliced(meshes, options).hash();
    CHECK(sliced(prepared, options).hash() == hash);
    options.frame.grid_mm = 0;
    CHECK(sliced(prepared, options, {.threads = 1}).hash() == hash);
    const PreparedMesh coarse = value_of(prepare(view_of(ball), {.grid_mm = 0.25}));
    const Error grid = failure_of(std::vector<Part>{{.prepared = &plain}, {.prepared = &coarse}}, options);
    CHECK_THAT(grid.message, Catch::StartsWith("part 1: it was prepared on a grid of 0.25 mm, and all parts need one of"));
    const Error move = failure_of(std::vector<Part>{{.placement = Transform::scale(2), .prepared = &plain}}, options);
    CHECK(move.message == "part 0: the mesh was prepared with another transform than the one asked for");
}

}  // namespace
