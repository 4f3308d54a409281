// A file sliced in ranges within a budget of memory gives what slice() gives of the whole mesh.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
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

std::string stl_of(const std::vector<float>& soup) {
    std::vector<Facet> facets(soup.size() / 9);
    std::memcpy(facets.data(), soup.data(), soup.size() * sizeof(float));
    return binary_stl(facets);
}

std::filesystem::path made(models::Shape shape, models::Order order, std::uint64_t triangles) {
    std::filesystem::path path = dir / "mesh.stl";
    REQUIRE(models::write_stl({.shape = shape, .triangles = triangles, .order = order}, path).ok());
    return path;
}

}  // namespace

TEST_CASE("a file in the order of height is cut as it is read", "[slice_file][threads]") {
    const auto path = made(models::Shape::bone, models::Order::z, 300'000);
    require_same_at_all_budgets(path, uniform(0.5));
    const Ranges ranges = in_ranges(path, {.memory_bytes = 4'000'000}, uniform(0.2), {.threads = 2});
    CHECK(ranges.spent.ranges > 4);
    CHECK(ranges.spent.spilled_bytes == 0);
}

TEST_CASE("a file in any order is spilled", "[slice_file][threads]") {
    const auto path = made(models::Shape::gyroid, models::Order::random, 300'000);
    require_same_at_all_budgets(path, uniform(0.4));
    const Ranges ranges = in_ranges(path, {.memory_bytes = 3'000'000}, uniform(0.2));
    CHECK(ranges.spent.ranges > 4);
    CHECK(ranges.spent.spilled_bytes > 44 * ranges.result.info.crossed / 2);
}

TEST_CASE("facets as tall as the part need a budget that holds them", "[slice_file]") {
    const auto path = made(models::Shape::prism, models::Order::random, 20'000);
    require_same_at_all_budgets(path, uniform(1));
}

TEST_CASE("all kinds of planes and rules give the same layers in ranges", "[slice_file]") {
    const auto path = made(models::Shape::torus, models::Order::random, 100'000);
    SliceOptions options;
    Tuning tuning;
    SECTION("listed heights, some of them twice and some beyond the mesh") {
        options.heights_mm = std::vector<double>{-30, 90, 20.5, 20.5, 1e7, 3, 77.125, 1.5, 60, 60.1, 60.2, 140};
    }
    SECTION("random heights") {
        tuning.random_heights = {.min_step_mm = 0.05, .max_step_mm = 3, .seed = 7};
    }
    SECTION("another datum, side and grid") {
        options = uniform(0.7);
        options.planes.side = PlaneSide::above;
        options.planes.datum = Datum::zero;
        options.frame.grid_mm = 0.001;
    }
    SECTION("a transform") {
        options = uniform(0.7);
        options.frame.transform = Transform::from_normal(1, 2, 3);
    }
    SECTION("rules by layer") {
        options = uniform(1);
        options.region.fill_from = {{20, FillRule::non_zero}, {70, FillRule::even_odd}};
    }
    SECTION("some layers") {
        options = uniform(0.3);
        options.planes.first_layer = 100;
        options.planes.end_layer = 333;
    }
    require_same_at_all_budgets(path, options, tuning);
}

TEST_CASE("open, degenerate, flat and tall facets give the same layers in ranges", "[slice_file]") {
    shapes::Soup soup = shapes::joined({shapes::octasphere({0, 0, 10}, 10, 5), shapes::box({20, 0, 0}, {30, 10, 40}),
                                        shapes::box({20, 20, 5}, {30, 30, 10}), shapes::random_soup(3, 400, 40),
                                        shapes::random_tetrahedra(5, 200, 20)});
    for (int i = 0; i < 100; ++i) {  // points and needles
        const double at = i / 4.0;
        soup = shapes::joined({std::move(soup), shapes::triangle({at, at, at}, {at, at, at}, {at, at + 1, 30})});
    }
    soup.resize(soup.size() - 9 * 7);  // open
    const auto path = dir.write("mesh.stl", stl_of(shapes::floats(shapes::shuffled(soup, 11))));
    SliceOptions options = uniform(0.25);  // planes at whole numbers too, where faces lie
    options.layer_height_mm = 0.25;
    options.planes.first_height_mm = 0.25;
    SECTION("as cut") {}
    SECTION("gaps closed") {
        options.stitch_mm = 0.5;
        options.stitch_direction = StitchDirection::any;
    }
    SECTION("on the side above") {
        options.planes.side = PlaneSide::above;
    }
    require_same_at_all_budgets(path, options);
}

TEST_CASE("a file written layer by layer is the file of the whole", "[slice_file][write]") {
    const TempFolder folder;
    const shapes::Soup soup = shapes::joined(
        {shapes::octasphere({0, 0, 10}, 10, 5), shapes::box({20, 0, 0}, {30, 10, 40}), shapes::random_soup(3, 400, 40)});
    const auto path = folder.write("mesh.stl", stl_of(shapes::floats(soup)));
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

TEST_CASE("what cannot be sliced in ranges is refused by name", "[slice_file]") {
    const std::vector<float> soup = shapes::floats(shapes::box({0, 0, 0}, {5, 5, 5}));
    const std::string stl = stl_of(soup);
    const std::string at = (dir.path() / "a").string();
    CHECK(refusal_of(dir.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")) ==
          at + ".obj: is a text OBJ file: only binary STL and PLY can be sliced within a budget of memory; "
               "'lamella convert MESH -o MESH.ply' makes the latter of it");
    CHECK_THAT(refusal_of(dir.write("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\n")), Contains("is a text STL file"));
    CHECK_THAT(refusal_of(dir.write("a.stl.gz", "\x1f\x8b\x08")), Contains("gunzip"));
    CHECK_THAT(refusal_of(dir.write("a.stl", stl.substr(0, 300))), Contains("truncated"));
    CHECK_THAT(refusal_of(dir.write("a.stl", "")), Contains("is empty"));
    CHECK_THAT(refusal_of(dir / "none.stl"), Contains("cannot be opened"));
    const auto with = [&](const SliceOptions& options) { return refusal_of(dir.write("a.stl", stl), {}, options); };
    CHECK_THAT(with({.origins = true}), Contains("origins"));
    CHECK_THAT(with({.content = LayerContent::upward_faces}), Contains("faces"));
    CHECK_THAT(with({.planes = {.first_layer = 70, .end_layer = 80}}), Contains("none of the 25 layers"));
    std::vector<float> bad = soup;
    bad[9 * 7 + 4] = std::nanf("");
    CHECK(refusal_of(dir.write("a.stl", stl_of(bad))) == at + ".stl: triangle 7, vertex 1, y is not finite");
    const StreamOptions nowhere{.memory_bytes = 1, .temporary_folder = dir / "none"};
    CHECK_THAT(refusal_of(dir.write("a.stl", stl), nowhere), Contains("temporary file in"));
}

TEST_CASE("a mesh that collapses, or that no plane meets, is sliced as in memory", "[slice_file]") {
    const auto dots = shapes::floats(shapes::triangle({1, 1, 1}, {1, 1, 1}, {2, 2, 9}));
    const auto path = dir.write("a.stl", stl_of(dots));
    CHECK_THAT(refusal_of(path), Contains("the triangle has two equal corners"));
    SliceOptions options{.allow_empty = true};
    CHECK(in_ranges(path, {}, options).result.layers.empty());
    options.heights_mm = std::vector<double>{1, 2, 3};
    CHECK(in_ranges(path, {}, options).result.layers.size() == 3);
    const auto box = dir.write("b.stl", stl_of(shapes::floats(shapes::box({0, 0, 0}, {5, 5, 5}))));
    options = uniform(500);
    options.planes.first_height_mm = 100;
    CHECK(in_ranges(box, {}, options).result.layers.empty());
}

TEST_CASE("a file in ranges can be stopped and reports its progress", "[slice_file]") {
    const auto path = made(models::Shape::sphere, models::Order::random, 100'000);
    const StreamOptions stream{.memory_bytes = 2'000'000};
    double last = -1;
    bool rises = true;
    auto show = [&](double fraction) noexcept {
        rises = rises && fraction >= last;
        last = fraction;
    };
    in_ranges(path, stream, {}, {.progress = show});
    CHECK(rises);
    CHECK(last == 1);
    auto stop = []() noexcept { return true; };
    CHECK(refusal_of(path, stream, {}, {.stop = stop}) == "cancelled");
}

TEST_CASE("a file is sliced to a result, to arrays and by two slicers at once", "[slice_file][threads]") {
    const auto path = made(models::Shape::bone, models::Order::random, 20'000);
    const MeshStream file = value_of(open_mesh(path, {.memory_bytes = 1'000'000}));
    const SliceResult whole = sliced(file, uniform(0.5));
    std::vector<Point> points(whole.points.size());
    std::vector<Contour> contours(whole.contours.size());
    std::vector<Layer> layers(whole.layers.size());
    sliced_to(HostArrays{.points = points.data(), .point_capacity = points.size(), .contours = contours, .layers = layers},
              file, uniform(0.5));
    CHECK(std::equal(points.begin(), points.end(), whole.points.begin()));
    std::uint64_t hashes[2] = {};
    std::thread other([&] { hashes[0] = slice(file, uniform(0.5)).value().hash(); });
    hashes[1] = slice(file, uniform(0.5)).value().hash();
    other.join();
    CHECK(hashes[0] == whole.hash());
    CHECK(hashes[1] == whole.hash());
}
