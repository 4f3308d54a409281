// A file sliced in ranges within a budget of memory gives what slice() gives of the whole mesh.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/counting_memory.hpp"
#include "engine/shapes.hpp"
#include "input/read.hpp"
#include "input/slices_in_ranges.hpp"
#include "lamella/io.hpp"
#include "models/models.hpp"

using namespace lamella;
using namespace lamella::input_test;
using Catch::Contains;

namespace {

shapes::Soup soup_of(models::Shape shape, models::Order order, std::uint64_t triangles) {
    const std::vector<float> soup = models::make_soup({.shape = shape, .triangles = triangles, .order = order});
    return {soup.begin(), soup.end()};
}

/// Open, degenerate, flat and tall facets, with points and needles.
shapes::Soup every_kind() {
    shapes::Soup soup = shapes::joined({shapes::octasphere({0, 0, 10}, 10, 5), shapes::box({20, 0, 0}, {30, 10, 40}),
                                        shapes::box({20, 20, 5}, {30, 30, 10}), shapes::random_soup(3, 400, 40),
                                        shapes::random_tetrahedra(5, 200, 20)});
    for (int i = 0; i < 100; ++i) {
        const double at = i / 4.0;
        soup = shapes::joined({std::move(soup), shapes::triangle({at, at, at}, {at, at, at}, {at, at + 1, 30})});
    }
    soup.resize(soup.size() - 9 * 7);
    return shapes::shuffled(soup, 11);
}

struct Case {
    const char* name;
    shapes::Soup soup;
    SliceOptions options;
    Tuning tuning{};
};

std::vector<Case> cases() {
    using enum models::Shape;
    using enum models::Order;
    const shapes::Soup tilted = soup_of(torus, random, 100'000);
    const shapes::Soup kinds = every_kind();
    const Transform turn = Transform::from_normal(1, 2, 3);
    const std::vector<double> heights{-30, 90, 20.5, 20.5, 1e7, 3, 77.125, 1.5, 60, 60.1, 60.2, 140};
    const PlaneOptions on_faces{.first_height_mm = 0.25};
    return {
        {"in the order of height", soup_of(bone, z, 150'000), uniform(0.5)},
        {"in any order", soup_of(gyroid, random, 150'000), uniform(0.4)},
        {"facets as tall as the part", soup_of(prism, random, 20'000), uniform(1)},
        {"listed heights, some of them twice and some beyond the mesh", tilted, {.heights_mm = heights}},
        {"random heights", tilted, {}, {.random_heights = RandomHeights{0.05, 3, 7}}},
        {"another datum, side and grid",
         tilted,
         {.layer_height_mm = 0.7, .planes = {.datum = Datum::zero, .side = PlaneSide::above}, .frame = {.grid_mm = 0.001}}},
        {"a transform, another grid", tilted, {.layer_height_mm = 0.7, .frame = {.transform = turn, .grid_mm = 0.001}}},
        {"rules by layer", tilted, {.region = {.fill_from = {{20, FillRule::non_zero}, {70, FillRule::even_odd}}}}},
        {"some layers", tilted, {.layer_height_mm = 0.3, .planes = {.first_layer = 100, .end_layer = 333}}},
        {"facets of every kind", kinds, {.layer_height_mm = 0.25, .planes = on_faces}},
        {"gaps closed",
         kinds,
         {.layer_height_mm = 0.25, .stitch_mm = 0.5, .stitch_direction = StitchDirection::any, .planes = on_faces}},
        {"facets of every kind, on the side above",
         kinds,
         {.layer_height_mm = 0.25, .planes = {.first_height_mm = 0.25, .side = PlaneSide::above}}},
    };
}

}  // namespace

TEST_CASE("a file gives the same layers in ranges, in every format and form", "[slice_file][threads]") {
    const PlyVariant forms[] = {{.encoding = little},
                                {.encoding = big, .coordinate = "double", .index = "uint"},
                                {.encoding = little, .coordinate = "double", .extra_numbers = true},
                                {.encoding = big, .index = "uint", .extra_numbers = true}};
    std::size_t number = 0;
    for (const Case& one : cases()) {
        INFO(one.name);
        require_same_at_all_budgets(dir.write("mesh.stl", stl_of(one.soup)), one.options, one.tuning);
        const std::string ply = ply_of(one.soup, forms[number++ % std::size(forms)]);
        require_same_at_all_budgets(dir.write("mesh.ply", ply), one.options, one.tuning);
    }
}

TEST_CASE("a file in the order of height is cut as it is read, one in any order is spilled", "[slice_file][threads]") {
    const auto sorted = made(models::Shape::bone, models::Order::z, 300'000);
    const Ranges cut = in_ranges(sorted, {.memory_bytes = 4'000'000}, uniform(0.2), {.threads = 2});
    CHECK(cut.spent.ranges > 4);
    CHECK(cut.spent.spilled_bytes == 0);
    const auto shuffled = made(models::Shape::gyroid, models::Order::random, 300'000);
    const Ranges spilled = in_ranges(shuffled, {.memory_bytes = 3'000'000}, uniform(0.2));
    CHECK(spilled.spent.ranges > 4);
    CHECK(spilled.spent.spilled_bytes > 44 * spilled.result.info.crossed / 2);
}

TEST_CASE("a file written layer by layer is the file of the whole", "[slice_file][write]") {
    const TempFolder folder;
    const shapes::Soup soup = shapes::joined(
        {shapes::octasphere({0, 0, 10}, 10, 5), shapes::box({20, 0, 0}, {30, 10, 40}), shapes::random_soup(3, 400, 40)});
    const auto path = folder.write("mesh.stl", stl_of(soup));
    SliceOptions options = uniform(0.25);
    options.planes.first_layer = 3;
    options.planes.end_layer = 150;
    options.frame.transform = Transform::from_normal(0, 1, 2);
    StreamOptions stream{.memory_bytes = GENERATE(std::uint64_t{1'500'000}, std::uint64_t{50'000'000})};
    stream.read.mm_per_unit = 2;
    std::optional<SvgStream> svg;
    std::vector<SliceInfo> begun;
    std::uint64_t layers = 0;
    const auto streamed = folder / "streamed.svg";
    auto begin = [&](const SliceInfo& info) noexcept {
        begun.push_back(info);
        svg = SvgStream::begin(info, streamed).value();
    };
    auto take = [&](const LayerView& view) noexcept {
        svg->add(view);
        ++layers;
    };
    const MeshStream file = value_of(open_mesh(path, stream));
    sliced_to(LayerSink{.take = take, .begin = begin}, file, options);
    REQUIRE(begun.size() == 1);
    CHECK(begun[0].layers == layers);
    CHECK_FALSE(std::filesystem::exists(streamed));
    require_ok(svg->finish());

    const Ranges whole = in_ranges(path, stream, options);
    REQUIRE(whole.result.info.open_contours > 0);
    Slicer slicer;
    const SliceInfo outline = value_of(slicer.outline(file, options));
    CHECK(outline.segments == whole.result.info.segments);
    CHECK(outline.degenerate == whole.result.info.degenerate);
    for (const SliceInfo& info : {begun[0], outline}) {
        CHECK(info.layers == whole.result.size());
        CHECK(info.options == whole.result.info.options);
        CHECK(info.box == whole.result.info.box);
    }
    require_ok(write_svg(whole.result, folder / "whole.svg"));
    CHECK(bytes_of(streamed) == bytes_of(folder / "whole.svg"));
}

TEST_CASE("the engine holds no more than the budget", "[slice_file]") {
    const auto shape = GENERATE(models::Shape::bone, models::Shape::gyroid, models::Shape::sphere, models::Shape::prism);
    const auto order = GENERATE(models::Order::z, models::Order::random);
    const auto path = made(shape, order, shape == models::Shape::prism ? 10'000 : budget_triangles);
    for (const double height : budget_heights_mm) {
        for (const int budget : {3'000'000, 10'000'000}) {
            for (const auto& [threads, order_of_sink] :
                 {std::pair{1, SinkOrder::any}, std::pair{2, SinkOrder::any}, std::pair{4, SinkOrder::ascending}}) {
                CountingMemory memory;
                const auto file = value_of(open_mesh(path, {.memory_bytes = static_cast<std::uint64_t>(budget)}));
                const auto take = [](const LayerView&) noexcept {};
                Slicer slicer;
                const auto sliced = slicer.slice_to(LayerSink{.take = take, .order = order_of_sink}, file, uniform(height),
                                                    {.threads = threads, .memory = &memory});
                INFO("layers of " << height << ", budget " << budget << ", " << threads << " threads");
                if (!sliced) {
                    INFO(sliced.error().message);
                    CHECK_THAT(sliced.error().message, Contains("too small"));
                    continue;
                }
                INFO(file.spent().ranges << " ranges");
                CHECK(memory.peak() <= file.spent().memory_bytes);
            }
        }
    }
}

TEST_CASE("vertices count against the budget", "[slice_file]") {
    const auto order = GENERATE(models::Order::z, models::Order::random);
    const auto* const number = GENERATE("float", "double");
    const auto soup = soup_of(models::Shape::bone, order, 100'000);
    const auto path = dir.write("mesh.ply", ply_of(soup, {.encoding = little, .coordinate = number}));
    for (const double height : budget_heights_mm) {
        for (const int threads : {1, 2}) {
            CountingMemory memory;
            const SliceOptions options = uniform(height);
            const StreamOptions stream{.memory_bytes = least_budget(path, options, {.threads = threads})};
            INFO(stream.memory_bytes << " bytes, " << threads << " threads");
            CHECK(refusal_of(path, stream, options, {.threads = threads, .memory = &memory}).empty());
            CHECK(memory.peak() <= stream.memory_bytes);
        }
    }
    CHECK_THAT(refusal_of(path, {.memory_bytes = 10'000}), Contains("vertices stay in memory, which takes at least"));
}
