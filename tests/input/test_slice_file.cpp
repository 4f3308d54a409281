// A file sliced in ranges within a budget of memory gives what slice() gives of the whole mesh.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/collected_layers.hpp"
#include "engine/counting_memory.hpp"
#include "engine/shapes.hpp"
#include "input/files.hpp"
#include "input/slices_in_ranges.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "models/models.hpp"
#include "temp_folder.hpp"

namespace {

using lamella::CollectedFileSlice;
using lamella::FileSliceOptions;
using lamella::SliceOptions;
using lamella::input_test::budget_heights_mm;
using lamella::input_test::budget_triangles;
using lamella::input_test::in_ranges;
using lamella::input_test::layers_of;
using lamella::input_test::require_same_at_all_budgets;

std::string stl_of(const std::vector<float>& soup) {
    std::vector<lamella::input_test::Facet> facets(soup.size() / 9);
    std::memcpy(facets.data(), soup.data(), soup.size() * sizeof(float));
    return lamella::input_test::binary_stl(facets);
}

std::filesystem::path made(const TempFolder& folder, lamella::models::Shape shape, lamella::models::Order order,
                           std::uint64_t triangles) {
    std::filesystem::path path = folder / "mesh.stl";
    REQUIRE(lamella::models::write_stl({.shape = shape, .triangles = triangles, .order = order}, path).ok());
    return path;
}

}  // namespace

TEST_CASE("a file in the order of height is cut as it is read", "[slice_file][threads]") {
    const TempFolder folder;
    const auto path = made(folder, lamella::models::Shape::bone, lamella::models::Order::z, 300'000);
    require_same_at_all_budgets(path, layers_of(0.5));
    FileSliceOptions options;
    options.slice = layers_of(0.2);
    options.slice.control.threads = 2;
    options.memory_bytes = 4'000'000;
    const CollectedFileSlice ranges = in_ranges(path, options);
    CHECK(ranges.file.ranges > 4);
    CHECK(ranges.file.spilled_bytes == 0);
}

TEST_CASE("a file in any order is spilled", "[slice_file][threads]") {
    const TempFolder folder;
    const auto path = made(folder, lamella::models::Shape::gyroid, lamella::models::Order::random, 300'000);
    require_same_at_all_budgets(path, layers_of(0.4));
    FileSliceOptions options;
    options.slice = layers_of(0.2);
    options.memory_bytes = 3'000'000;
    const CollectedFileSlice ranges = in_ranges(path, options);
    CHECK(ranges.file.ranges > 4);
    CHECK(ranges.file.spilled_bytes > 44 * ranges.result.summary.crossed / 2);
}

TEST_CASE("facets as tall as the part need a budget that holds them", "[slice_file]") {
    const TempFolder folder;
    const auto path = made(folder, lamella::models::Shape::prism, lamella::models::Order::random, 20'000);
    require_same_at_all_budgets(path, layers_of(1));
}

TEST_CASE("all kinds of planes and rules give the same layers in ranges", "[slice_file]") {
    const TempFolder folder;
    const auto path = made(folder, lamella::models::Shape::torus, lamella::models::Order::random, 100'000);
    SliceOptions options;
    SECTION("listed heights, some of them twice and some beyond the mesh") {
        options.plan.spacing = lamella::ExplicitPlanes{{-30, 90, 20.5, 20.5, 1e7, 3, 77.125, 1.5, 60, 60.1, 60.2, 140}};
    }
    SECTION("random heights") {
        options.plan.spacing = lamella::RandomLayers{.min_height_mm = 0.05, .max_height_mm = 3, .seed = 7};
    }
    SECTION("another datum, side and grid") {
        options = layers_of(0.7);
        options.plan.side = lamella::PlaneSide::above;
        std::get<lamella::UniformLayers>(options.plan.spacing).datum = lamella::Datum::zero;
        options.unit_mm = 0.001;
    }
    SECTION("a transform") {
        options = layers_of(0.7);
        options.transform = lamella::Transform::from_normal(1, 2, 3);
    }
    SECTION("rules by layer") {
        options = layers_of(1);
        options.region.fill_from = {{20, lamella::FillRule::non_zero}, {70, lamella::FillRule::even_odd}};
    }
    SECTION("some layers") {
        options = layers_of(0.3);
        options.layers = {100, 333};
    }
    require_same_at_all_budgets(path, options);
}

TEST_CASE("open, degenerate, flat and tall facets give the same layers in ranges", "[slice_file]") {
    const TempFolder folder;
    shapes::Soup soup = shapes::joined({shapes::octasphere({0, 0, 10}, 10, 5), shapes::box({20, 0, 0}, {30, 10, 40}),
                                        shapes::box({20, 20, 5}, {30, 30, 10}), shapes::random_soup(3, 400, 40),
                                        shapes::random_tetrahedra(5, 200, 20)});
    for (int i = 0; i < 100; ++i) {  // points and needles
        const double at = i / 4.0;
        soup = shapes::joined({std::move(soup), shapes::triangle({at, at, at}, {at, at, at}, {at, at + 1, 30})});
    }
    soup.resize(soup.size() - 9 * 7);  // open
    const auto path = folder.write("mesh.stl", stl_of(shapes::floats(shapes::shuffled(soup, 11))));
    SliceOptions options = layers_of(0.25);  // planes at whole numbers too, where faces lie
    options.plan.spacing = lamella::UniformLayers{.layer_height_mm = 0.25, .first_height_mm = 0.25};
    SECTION("as cut") {}
    SECTION("gaps closed") {
        options.close_gaps_mm = 0.5;
        options.gap_sense = lamella::GapSense::any;
    }
    SECTION("on the side above") {
        options.plan.side = lamella::PlaneSide::above;
    }
    require_same_at_all_budgets(path, options);
}

TEST_CASE("a file written layer by layer is the file of the whole", "[slice_file][write]") {
    const TempFolder folder;
    const shapes::Soup soup = shapes::joined(
        {shapes::octasphere({0, 0, 10}, 10, 5), shapes::box({20, 0, 0}, {30, 10, 40}), shapes::random_soup(3, 400, 40)});
    const auto path = folder.write("mesh.stl", stl_of(shapes::floats(soup)));
    FileSliceOptions options;
    options.slice = layers_of(0.25);
    options.slice.layers = {3, 150};
    options.slice.transform = lamella::Transform::from_normal(0, 1, 2);
    options.mm_per_unit = 2;
    options.memory_bytes = GENERATE(std::uint64_t{1'500'000}, std::uint64_t{50'000'000});
    struct {
        std::filesystem::path path;
        std::optional<lamella::SvgStream> stream{};
        std::uint64_t outlines = 0;
        std::uint64_t promised = 0;
        std::uint64_t layers = 0;
        lamella::Transform frame{};
        void operator()(const lamella::LayerView& view) noexcept {
            stream->add(view);
            ++layers;
        }
    } writing{folder / "streamed.svg"};
    options.outline = {[](void* context, const lamella::FileOutline& outline) noexcept {
                           auto& own = *static_cast<decltype(writing)*>(context);
                           ++own.outlines;
                           own.promised = outline.layers;
                           own.frame = outline.facts.frame;
                           own.stream = lamella::SvgStream::begin(outline.facts, outline.layers, own.path).value();
                       },
                       &writing};
    REQUIRE(lamella::slice_file(path, lamella::LayerSink::to(writing, lamella::SinkOrder::ascending), options).ok());
    REQUIRE(writing.outlines == 1);
    CHECK(writing.promised == writing.layers);
    CHECK_FALSE(std::filesystem::exists(writing.path));
    REQUIRE(writing.stream->finish().ok());

    options.outline = {};
    const CollectedFileSlice whole = in_ranges(path, options);
    REQUIRE(whole.result.summary.open_contours > 0);
    CHECK(writing.promised == whole.result.layers.size());
    CHECK(writing.frame.m == whole.result.frame.m);
    const lamella::FileOutline outline = lamella::outline_file(path, options).value();
    CHECK(outline.layers == writing.promised);
    CHECK(outline.facts.frame.m == writing.frame.m);
    CHECK(std::ranges::equal(outline.facts.summary.min_mm, whole.result.summary.min_mm));
    CHECK(std::ranges::equal(outline.facts.summary.max_mm, whole.result.summary.max_mm));
    REQUIRE(lamella::write_svg(whole.result, folder / "whole.svg").ok());
    CHECK(bytes_of(folder / "streamed.svg") == bytes_of(folder / "whole.svg"));
}

TEST_CASE("the engine holds no more than the budget", "[slice_file]") {
    const TempFolder folder;
    const auto shape = GENERATE(lamella::models::Shape::bone, lamella::models::Shape::gyroid, lamella::models::Shape::sphere,
                                lamella::models::Shape::prism);
    const auto order = GENERATE(lamella::models::Order::z, lamella::models::Order::random);
    const auto path = made(folder, shape, order, shape == lamella::models::Shape::prism ? 10'000 : budget_triangles);
    for (const double height : budget_heights_mm) {
        for (const int budget : {3'000'000, 10'000'000}) {
            for (const auto& [threads, order_of_sink] :
                 {std::pair{1, lamella::SinkOrder::any}, std::pair{2, lamella::SinkOrder::any},
                  std::pair{4, lamella::SinkOrder::ascending}}) {
                CountingMemory memory;
                FileSliceOptions options;
                options.slice = layers_of(height);
                options.slice.control = {.threads = threads, .memory = &memory};
                options.memory_bytes = static_cast<std::uint64_t>(budget);
                const auto take = [](const lamella::LayerView&) noexcept {};
                const auto sliced = lamella::slice_file(path, lamella::LayerSink::to(take, order_of_sink), options);
                INFO("layers of " << height << ", budget " << budget << ", " << threads << " threads");
                if (!sliced) {
                    INFO(sliced.error().message);
                    CHECK(sliced.error().message.find("too small") != std::string::npos);
                    continue;
                }
                INFO(sliced->ranges << " ranges");
                CHECK(memory.peak() <= options.memory_bytes);
            }
        }
    }
}

TEST_CASE("what cannot be sliced in ranges is refused by name", "[slice_file]") {
    const TempFolder folder;
    const std::vector<float> soup = shapes::floats(shapes::box({0, 0, 0}, {5, 5, 5}));
    const auto message_of = [](const std::filesystem::path& path, const FileSliceOptions& options = {}) {
        const auto refused = lamella::slice_file(path, options);
        REQUIRE(!refused);
        return refused.error().message;
    };
    const std::string stl = stl_of(soup);
    const std::string at = (folder.path() / "a").string();
    CHECK(message_of(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")) ==
          at + ".obj: is a text OBJ file: only binary STL and PLY can be sliced within a budget of memory; "
               "'lamella convert MESH -o MESH.ply' makes the latter of it");
    CHECK(message_of(folder.write("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\n")).find("is a text STL file") !=
          std::string::npos);
    CHECK(message_of(folder.write("a.stl.gz", "\x1f\x8b\x08")).find("gunzip") != std::string::npos);
    CHECK(message_of(folder.write("a.stl", stl.substr(0, 300))).find("truncated") != std::string::npos);
    CHECK(message_of(folder.write("a.stl", "")).find("is empty") != std::string::npos);
    CHECK(message_of(folder / "none.stl").find("cannot be opened") != std::string::npos);
    FileSliceOptions options;
    options.slice.origins = true;
    CHECK(message_of(folder.write("a.stl", stl), options).find("origins") != std::string::npos);
    options.slice.origins = false;
    options.slice.layers = {70, 80};
    CHECK(message_of(folder / "a.stl", options).find("none of the 25 layers") != std::string::npos);
    std::vector<float> bad = soup;
    bad[9 * 7 + 4] = std::nanf("");
    CHECK(message_of(folder.write("a.stl", stl_of(bad))) == at + ".stl: triangle 7, vertex 1, y is not finite");
    options = {};
    options.temporary_folder = folder / "none";
    options.memory_bytes = 1;
    CHECK(message_of(folder.write("a.stl", stl), options).find("temporary file in") != std::string::npos);
}

TEST_CASE("a mesh that collapses, or that no plane meets, is sliced as in memory", "[slice_file]") {
    const TempFolder folder;
    const auto dots = shapes::floats(shapes::triangle({1, 1, 1}, {1, 1, 1}, {2, 2, 9}));
    const auto path = folder.write("a.stl", stl_of(dots));
    FileSliceOptions options;
    CHECK(!lamella::slice_file(path, options));
    options.slice.allow_empty = true;
    CHECK(in_ranges(path, options).result.layers.empty());
    options.slice.plan.spacing = lamella::ExplicitPlanes{{1, 2, 3}};
    CHECK(in_ranges(path, options).result.layers.size() == 3);
    const auto box = folder.write("b.stl", stl_of(shapes::floats(shapes::box({0, 0, 0}, {5, 5, 5}))));
    options.slice = layers_of(500);
    std::get<lamella::UniformLayers>(options.slice.plan.spacing).first_height_mm = 100;
    CHECK(in_ranges(box, options).result.layers.empty());
}

TEST_CASE("a file in ranges can be stopped and reports its progress", "[slice_file]") {
    const TempFolder folder;
    const auto path = made(folder, lamella::models::Shape::sphere, lamella::models::Order::random, 100'000);
    FileSliceOptions options;
    options.memory_bytes = 2'000'000;
    double last = -1;
    bool rises = true;
    const auto show = [&](double fraction) noexcept {
        rises = rises && fraction >= last;
        last = fraction;
    };
    options.slice.control.progress = lamella::Progress::to(show);
    in_ranges(path, options);
    CHECK(rises);
    CHECK(last == 1);
    std::atomic<bool> stop = true;
    options.slice.control.stop = lamella::StopCheck::when(stop);
    const auto stopped = lamella::slice_file(path, options);
    REQUIRE(!stopped);
    CHECK(stopped.error().code == lamella::ErrorCode::cancelled);
}
