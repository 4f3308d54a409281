// Copies of parts, against slices of the same meshes moved by hand.
#include <cmath>
#include <list>
#include <map>
#include <random>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"

using namespace lamella;

namespace {

using PlaceMm = std::array<double, 3>;

double on_even_grid(double mm, double grid_mm) {
    return 2 * grid_mm * std::nearbyint(mm / (2 * grid_mm));
}

/// Parts with places, and the same with a moved mesh for each copy.
struct Plate {
    double grid_mm = default_grid_mm;
    std::list<shapes::Soup> soups{};
    std::list<std::vector<PlaceMm>> places{};
    std::vector<Part> copies{};
    std::vector<Part> moved{};

    void add(const shapes::Soup& soup, std::vector<PlaceMm> at, Part part = {}) {
        std::uint32_t i = 0;
        for (const auto& [x, y, z] : at) {
            const PlaceMm by{on_even_grid(x, grid_mm), on_even_grid(y, grid_mm), on_even_grid(z, grid_mm)};
            soups.push_back(shapes::moved(soup, by));
            moved.push_back({.mesh = view_of(soups.back()), .role = part.role, .object = 1000 * part.object + i++});
        }
        soups.push_back(soup);
        part.mesh = view_of(soups.back());
        part.at_mm = places.emplace_back(std::move(at));
        copies.push_back(part);
    }
};

void require_same_result(const SliceResult& found, const SliceResult& expected) {
    REQUIRE(facts_of(found.info) == facts_of(expected.info));
    CHECK(found.info.part_count == expected.info.part_count);
    for (std::size_t l = 0; l < expected.size(); ++l) {
        INFO("layer " << l);
        REQUIRE(is_same(found[l], expected[l]));
    }
    CHECK(found.hash() == expected.hash());
}

/// Each copy that shares contours stands where it is said to, and nothing else is left out.
void require_shared(const SliceResult& shared, const SliceResult& whole) {
    std::map<std::uint32_t, PartCopy> copies;
    for (const PartCopy& copy : shared.info.copies) {
        copies[copy.part] = copy;
    }
    REQUIRE(shared.size() == whole.size());
    for (std::size_t l = 0; l < whole.size(); ++l) {
        std::map<std::uint32_t, std::vector<const Contour*>> by_part;
        for (const Contour& own : shared[l].contours) {
            by_part[own.part].push_back(&own);
        }
        std::map<std::uint32_t, std::size_t> seen;
        for (const Contour& own : whole[l].contours) {
            const auto copy = copies.find(own.part);
            const bool is_copy = copy != copies.end();
            const Contour& first = *by_part.at(is_copy ? copy->second.first : own.part).at(seen[own.part]++);
            const Point by = is_copy ? copy->second.move : Point{};
            REQUIRE((first.role == own.role && first.flags == own.flags && first.point_count == own.point_count));
            for (std::size_t i = 0; i < own.point_count; ++i) {
                const Point at = shared.points_of(first)[i];
                REQUIRE(Point{at.x + by.x, at.y + by.y} == whole.points_of(own)[i]);
            }
        }
        for (const auto& [part, own] : by_part) {
            REQUIRE(own.size() == seen[part]);
        }
    }
}

shapes::Soup random_mesh(std::mt19937_64& random) {
    switch (random() % 4) {
        case 0:
            return shapes::octasphere({1, 2, 3}, 4 + static_cast<double>(random() % 3), 2);
        case 1:
            return shapes::without(shapes::octasphere({0, 0, 5}, 5, 2), 108, 6);  // open
        case 2:
            return shapes::random_tetrahedra(random(), 6, 6);
        default:
            return shapes::joined({shapes::box({0, 0, 0}, {9, 9, 9}), shapes::flipped(shapes::box({1, 1, 1}, {4, 4, 8}))});
    }
}

SliceOptions random_options(std::mt19937_64& random) {
    SliceOptions options = uniform(random() % 2 == 0 ? 0.25 : 0.3);
    if (random() % 3 == 0) {
        options = at_heights({-3, 1.7, 1e8, 4, 4.1, 8.8, -1e9}, 0);
    }
    options.stitch_mm = random() % 2 == 0 ? 4 : 0;
    options.planes.side = random() % 2 == 0 ? PlaneSide::below : PlaneSide::above;
    if (random() % 2 == 0) {
        options.region = {.fill_rule = FillRule::positive, .closing_mm = 0.3, .offset_mm = -0.1, .simplify_mm = 0.01};
        options.unite_parts = random() % 2 == 0;
    }
    options.origins = random() % 2 == 0;
    return options;
}

TEST_CASE("a plate of copies is the plate of the moved meshes, byte for byte", "[engine][parts][copies]") {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> anywhere(-20, 20);
    for (unsigned round = 0; round < rounds(120); ++round) {
        Plate plate;
        for (std::size_t p = 0; p < 1 + random() % 3; ++p) {
            std::vector<PlaceMm> at;
            for (std::size_t i = 0; i < 1 + random() % 5; ++i) {
                at.push_back({anywhere(random), anywhere(random), random() % 2 == 0 ? 0 : 0.25 * double(random() % 4)});
            }
            plate.add(random_mesh(random), at);
        }
        SliceOptions options = random_options(random);
        CAPTURE(round);
        const SliceResult found = sliced(plate.copies, options, {.threads = 1 + static_cast<int>(round % 3)});
        require_same_result(found, sliced(plate.moved, options));
        if (!options.unite_parts) {
            options.share_copies = true;
            options.origins = false;
            const SliceResult shared = sliced(plate.copies, options, {.threads = 1 + static_cast<int>(round % 2)});
            require_shared(shared, found);
            CHECK(shared.info.part_count == found.info.part_count);
        }
    }
}

TEST_CASE("objects with roles are copied as a whole", "[engine][parts][copies][roles]") {
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> anywhere(-9, 9);  // so that copies overlap
    for (unsigned round = 0; round < rounds(30); ++round) {
        Plate plate;
        std::vector<PlaceMm> at;
        for (std::size_t i = 0; i < 2 + random() % 4; ++i) {
            at.push_back({anywhere(random), anywhere(random), random() % 2 == 0 ? 0 : 1.1});
        }
        plate.add(random_mesh(random), at);
        plate.add(shapes::box({2, 2, 2}, {5, 12, 6}), at, {.role = PartRole::negative});
        plate.add(shapes::octasphere({6, 1, 4}, 4, 2), at, {.role = PartRole::modifier});
        plate.add(shapes::box({0, 0, 0}, {3, 3, 3}), {{0, 0, 0}}, {.role = PartRole::support_blocker});
        plate.add(random_mesh(random), {{0, 0, 0}, {1, 1, 1}}, {.object = 1});
        SliceOptions options = uniform(0.3);
        options.region.closing_mm = random() % 2 == 0 ? 0.2 : 0;
        options.region.fill_rule = options.region.closing_mm > 0 ? FillRule::non_zero : FillRule::contours;
        CAPTURE(round);
        const SliceResult found = sliced(plate.copies, options);
        require_same_result(found, sliced(plate.moved, options));
        options.share_copies = true;
        require_shared(sliced(plate.copies, options), found);
        options.share_copies = false;
        options.region.fill_rule = FillRule::non_zero;
        options.unite_parts = true;
        require_same_result(sliced(plate.copies, options), sliced(plate.moved, options));
    }
}

TEST_CASE("copies stand far from where they are cut", "[engine][parts][copies]") {
    const shapes::Soup ball = shapes::octasphere({1000, -1000, -1000}, 8, 3);
    Plate plate;
    plate.add(ball, {{-1990, 1990, 1990}, {0, 0, 0}, {-3, 0, 1990}});
    SliceOptions options = uniform(0.5, default_grid_mm);
    require_same_result(sliced(plate.copies, options), sliced(plate.moved, options));
    options = at_heights({-1e9, -1001, 989.5, 1e9}, default_grid_mm);
    require_same_result(sliced(plate.copies, options), sliced(plate.moved, options));
    // Floats that are moved in the plane have the layers that they have alone.
    const std::vector<float> floats = shapes::floats(shapes::moved(ball, {-1000, 1000, 1000}));
    const std::vector<PlaceMm> at = {{0, 0, 0}, {16, 0, 0}};
    const SliceResult two = sliced(std::vector<Part>{{.mesh = view_of(floats), .at_mm = at}}, uniform(0.1));
    const SliceResult one = sliced(view_of(floats), uniform(0.1));
    REQUIRE(two.points.size() == 2 * one.points.size());
    CHECK(two.layers[7].plane == one.layers[7].plane);
    const std::size_t half = two[0].points.size() / 2;
    CHECK(std::equal(one[0].points.begin(), one[0].points.end(), two[0].points.begin()));
    CHECK(two[0].points[half].x - one[0].points[0].x == 16 << 20);
    // 0.3 mm are not on the grid.
    const std::vector<PlaceMm> near = {{0, 0, 0}, {0.3, 0, 0}};
    SliceOptions share = uniform(0.1);
    share.share_copies = true;
    const SliceResult moved = sliced(std::vector<Part>{{.mesh = view_of(floats), .at_mm = near}}, share);
    CHECK(moved.info.copies == std::vector<PartCopy>{{1, 0, {314572, 0}}});
    CHECK(moved.points.size() == one.points.size());
}

TEST_CASE("places lie before the frame's transform, and prepared parts have them too", "[engine][parts][copies][prepared]") {
    const shapes::Soup bar = shapes::box({-4, 4, 0.5}, {10, 6, 20});
    const std::vector<PlaceMm> at = {{0, 0, 0}, {8, 0, 0}, {0, -16, 0}};
    SliceOptions options = uniform(0.2, default_grid_mm);
    options.frame.transform.m = {0, -2, 0, 5, 2, 0, 0, 0, 0, 0, 2, 1};  // a quarter turn, twice as large
    std::vector<Part> moved;
    std::vector<shapes::Soup> soups;
    for (const PlaceMm& by : at) {
        soups.push_back(shapes::moved(bar, by));
    }
    for (const shapes::Soup& soup : soups) {
        moved.push_back({.mesh = view_of(soup)});
    }
    const SliceResult expected = sliced(moved, options);
    require_same_result(sliced(std::vector<Part>{{.mesh = view_of(bar), .at_mm = at}}, options), expected);
    const PreparedMesh prepared = value_of(prepare(view_of(bar), options.frame));
    require_same_result(sliced(std::vector<Part>{{.prepared = &prepared, .at_mm = at}}, options), expected);
}

TEST_CASE("copies go to every destination", "[engine][parts][copies]") {
    const shapes::Soup ball = shapes::octasphere({1, 2, 3}, 10, 3);
    Plate plate;
    plate.add(ball, {{0, 0, 0}, {30, 0, 0}, {0, 30, 1.5}});
    const SliceResult result = sliced(plate.copies, uniform(0.2));
    LayerHash hash(result.size());
    const auto take = [&hash](const LayerView& layer) noexcept { hash.add(layer); };
    const SliceInfo info = sliced_to(LayerSink{.take = take}, plate.copies, uniform(0.2));
    CHECK(hash.value() == result.hash());
    CHECK(facts_of(info) == facts_of(result.info));
    std::vector<Point> points(result.points.size());
    std::vector<Contour> contours(result.contours.size());
    std::vector<Layer> layers(result.size());
    sliced_to(HostArrays{.points = points.data(), .point_capacity = points.size(), .contours = contours, .layers = layers},
              plate.copies, uniform(0.2));
    CHECK(std::equal(points.begin(), points.end(), result.points.begin()));
    const SliceInfo outline = value_of(Slicer().outline(plate.copies, uniform(0.2)));
    CHECK(outline.segments == result.info.segments);
    for (std::uint64_t fails_at = 1; fails_at < 1500; fails_at += 29) {
        CountingMemory memory(~std::size_t{0}, fails_at);
        const auto code = code_of(Slicer().slice(plate.copies, uniform(2), {.threads = 1, .memory = &memory}));
        CHECK((!code || *code == ErrorCode::out_of_memory));
        CHECK(memory.held() == 0);
    }
}

TEST_CASE("copies that cannot be are refused", "[engine][parts][copies][errors]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {4, 4, 4});
    std::vector<PlaceMm> at = {{0, 0, 0}, {5, std::nan(""), 0}};
    std::vector<Part> parts = {{.mesh = view_of(cube)}, {.mesh = view_of(cube), .at_mm = at}};
    const Error number = failure_of(parts, uniform(1));
    CHECK(number.message == "part 1: place 1 is not finite or beyond 1e9 mm");
    CHECK(number.part == 1);
    at[1] = {5, 1e10, 0};
    CHECK(failure_of(parts, uniform(1)).message == number.message);
    at[1] = {5, 2000, 0};
    CHECK_THAT(failure_of(parts, uniform(1, default_grid_mm)).message, Catch::StartsWith("the mesh reaches 2004 mm"));
    CHECK(sliced(parts, uniform(1)).info.grid_doublings == 1);
    const shapes::Soup none;
    const std::vector<Part> nothing = {{.mesh = view_of(none), .at_mm = at}};
    SliceOptions empty = at_heights({1, 2});
    empty.allow_empty = true;
    CHECK(sliced(nothing, empty).size() == 2);
    parts[1].role = PartRole::negative;
    CHECK(failure_of(parts, uniform(1)).message ==
          "part 1: roles act among parts at the same places, and part 0 of its object stands at others");
    parts[1].role = PartRole::solid;
    SliceOptions share = uniform(1);
    share.share_copies = share.origins = true;
    CHECK(failure_of(parts, share).message == "copies that share points have no origins");
    share.origins = false;
    share.unite_parts = true;
    share.region.fill_rule = FillRule::non_zero;
    CHECK(failure_of(parts, share).message == "parts that are united share no points");
    // More than a result may take, or origins can name.
    at.assign(70000, {0, 0, 0});
    parts[1].at_mm = at;
    const Error large = failure_of(parts, uniform(1), {.memory_limit_bytes = 1 << 22});
    CHECK(large.code == ErrorCode::result_too_large);
    CHECK_THAT(large.message, Catch::StartsWith("4 layers with "));
    share = uniform(1);
    share.share_copies = true;
    CHECK(sliced(parts, share, {.memory_limit_bytes = 1 << 22}).info.copies.size() == 69999);
    SliceOptions origins = uniform(1);
    origins.origins = true;
    CHECK(failure_of(parts, origins).message == "origins name one of at most 65535 parts, not of 70001");
}

}  // namespace
