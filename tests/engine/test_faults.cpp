// Every allocation fails in turn. Each failure must be an error, and no memory may stay allocated.
#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"
#include "input/files.hpp"
#include "lamella/io.hpp"

using lamella::ErrorCode;
using lamella::Memory;
using lamella::SliceOptions;

namespace {

/// Runs `call` until it succeeds. In each run, the first failing allocation is `step` later. `call` returns the code with
/// which it failed, or nothing.
using Call = std::function<std::optional<ErrorCode>(const Memory*)>;

void fail_everywhere(const Call& call, std::uint64_t step = 1) {
    std::uint64_t failures = 0;
    for (std::uint64_t at = 1;; at += step) {
        CountingMemory memory(~std::size_t{0}, at);
        const std::optional<ErrorCode> code = call(&memory);
        INFO("allocation " << at);
        REQUIRE(memory.held() == 0);
        if (!code) {
            break;
        }
        REQUIRE(*code == ErrorCode::out_of_memory);
        ++failures;
    }
    CHECK(failures > 0);
}

void fail_slicing_everywhere(const shapes::Soup& soup, const SliceOptions& options, Way way, std::uint64_t step = 1) {
    fail_everywhere(
        [&](const Memory* memory) {
            way.context.memory = memory;
            lamella::Slicer slicer;
            lamella::SliceResult result(memory);
            return code_of(slice_tuned(slicer, result, view_of(soup), options, way.tuning, way.context));
        },
        step);
}

/// Nested and overlapping shells, one inverted, one with a hole in its surface: contours of every role.
shapes::Soup everything() {
    shapes::Soup soup =
        shapes::joined({shapes::box({0, 0, 0}, {9, 9, 9}), shapes::flipped(shapes::box({1, 1, 1}, {4, 4, 8})),
                        shapes::box({6, 6, 0}, {12, 12, 9}), shapes::octasphere({20, 0, 5}, 5, 2)});
    soup.erase(soup.end() - 9 * 20, soup.end() - 9 * 14);
    return soup;
}

/// One plane that cuts enough segments for threads to share it: the sides of many prisms.
shapes::Soup wide_plane() {
    constexpr std::size_t wide = std::size_t{1} << 18;
    constexpr std::size_t prisms = 64;
    shapes::Soup soup;
    for (std::size_t i = 0; i < prisms; ++i) {
        shapes::append(soup, shapes::moved(shapes::prism(static_cast<int>(wide / prisms / 8) + 1, 1, 1),
                                           {3.0 * static_cast<double>(i), 0, 0}));
    }
    return soup;
}

}  // namespace

TEST_CASE("a slice fails cleanly at each of its allocations", "[engine][faults]") {
    const auto form = GENERATE(lamella::ContourForm::swept, lamella::ContourForm::assembled);
    const int threads = GENERATE(1, 3);
    fail_slicing_everywhere(everything(), uniform(0.4),
                            {{.threads = threads}, {.band_planes = GENERATE(0, 5), .form = form}});
}

TEST_CASE("every source to every destination fails cleanly at each of its allocations", "[engine][faults][sink][host]") {
    const shapes::Soup soup = everything();
    SliceOptions options = uniform(0.4);
    options.stitch_mm = 2;
    const EverySource sources(soup, options.frame);
    const auto nothing = [](const lamella::LayerView&) noexcept {};
    const lamella::LayerSink in_any_order{.take = nothing, .order = lamella::SinkOrder::any};
    const lamella::LayerSink in_order{.take = nothing};
    const ArraySizes sizes{1 << 16, 1 << 12, 1 << 10};
    const GuardedArrays as_they_are(sizes);
    const GuardedArrays converted(sizes, {.type = lamella::Number::f64});
    for (const auto& [name, source] : sources.all()) {
        for (const lamella::Destination to :
             {lamella::Destination(in_any_order), lamella::Destination(in_order), lamella::Destination(as_they_are.arrays),
              lamella::Destination(converted.arrays)}) {
            for (const int threads : {1, 3}) {
                INFO(name << ", " << threads << " threads");
                fail_everywhere([&, &source = source](const Memory* memory) {
                    lamella::Slicer slicer;
                    return code_of(slicer.slice_to(to, source, options, {.threads = threads, .memory = memory}));
                });
            }
        }
    }
}

TEST_CASE("what faces project fails cleanly at each of its allocations", "[engine][faults][slabs]") {
    SliceOptions options = uniform(0.4);
    options.content = GENERATE(lamella::LayerContent::upward_faces, lamella::LayerContent::downward_faces);
    options.region.drop_collinear = true;
    options.region.closing_mm = GENERATE(0.0, 0.6);
    fail_slicing_everywhere(everything(), options, {{.threads = GENERATE(1, 3)}, {}});
}

TEST_CASE("a slice by random planes fails cleanly at each of its allocations", "[engine][faults]") {
    fail_slicing_everywhere(everything(), {}, {{.threads = 1}, {.random_heights = lamella::RandomHeights{0.2, 0.6, 4}}});
}

TEST_CASE("filling and closing gaps fail cleanly at each of their allocations", "[engine][faults]") {
    SliceOptions options = uniform(0.7);
    options.region.fill_rule = GENERATE(lamella::FillRule::contours, lamella::FillRule::even_odd,
                                        lamella::FillRule::non_zero, lamella::FillRule::positive);
    options.stitch_mm = 2;
    fail_slicing_everywhere(everything(), options, {{.threads = 2}, {}});
}

TEST_CASE("every rule of regions fails cleanly at each of its allocations", "[engine][faults][closing]") {
    using lamella::FillRule;
    constexpr FillRule united = FillRule::non_zero;
    const lamella::RegionRules rules[] = {
        {.fill_rule = united, .closing_mm = 0.01},
        {.fill_rule = united, .closing_mm = 0.6},
        {.fill_rule = united, .closing_mm = 2},
        {.fill_rule = united, .offset_mm = -0.5},
        {.fill_rule = united, .offset_mm = 0.5},
        {.fill_rule = united, .closing_mm = 0.6, .offset_mm = 0.2, .drop_collinear = true, .largest_only = true},
        {.fill_rule = FillRule::outermost},
        {.fill_rule = FillRule::contours, .simplify_mm = 0.3},
        {.fill_rule = FillRule::positive, .simplify_mm = 0.3},
        {.fill_rule = FillRule::contours, .flag_closing_mm = 0.6},
        {.fill_rule = FillRule::positive, .flag_closing_mm = 0.6},
    };
    SliceOptions options = uniform(1.4);
    for (const lamella::RegionRules& one : rules) {
        INFO("case " << &one - rules);
        options.region = one;
        options.origins = one.simplify_mm != 0;
        fail_slicing_everywhere(everything(), options, {{.threads = 1}, {}});
    }
}

TEST_CASE("the region of given contours fails cleanly at each of its allocations", "[engine][faults][closing]") {
    const std::vector<lamella::Point> low = {{0, 0}, {4000, 0}, {4000, 4000}, {0, 4000}};
    const std::vector<lamella::Point> high = {{2000, 2000}, {6000, 2000}, {6000, 6000}, {2000, 6000}};
    const std::vector<lamella::Point> beside = {{6100, 0}, {9000, 0}, {9000, 5000}, {6100, 5000}};
    const std::vector<std::span<const lamella::Point>> contours = {low, high, beside};
    lamella::RegionRules rules;
    rules.fill_rule = lamella::FillRule::non_zero;
    rules.closing_mm = 60;
    rules.offset_mm = -20;
    rules.drop_collinear = true;
    fail_everywhere(
        [&](const Memory* memory) { return code_of(lamella::region_of(contours, rules, 1, {.memory = memory})); });
}

TEST_CASE("a wide plane fails cleanly at its allocations", "[engine][faults][wide][threads]") {
    const shapes::Soup soup = wide_plane();
    SliceOptions options;
    options.heights_mm = std::vector<double>{0.5};
    const CountingMemory counting;
    REQUIRE(slice(view_of(soup), options, {.threads = 2, .memory = &counting}).ok());
    // Each run slices 2^18 segments, so only about a dozen allocations are tested, spread over all.
    fail_slicing_everywhere(soup, options, {{.threads = 2}, {}}, std::max<std::uint64_t>(1, counting.asked() / 12));
}

TEST_CASE("a slicer that ran out of memory slices again", "[engine][faults][threads]") {
    const shapes::Soup soup = everything();
    const SliceOptions options = uniform(0.4);
    const std::uint64_t expected = sliced(soup, options).hash();
    for (std::uint64_t at = 1; at < 200; at += 7) {
        lamella::Slicer slicer;
        lamella::SliceResult result;
        const CountingMemory memory(~std::size_t{0}, at);
        (void)slicer.slice_to(result, view_of(soup), options, {.threads = 2, .memory = &memory});
        INFO("allocation " << at);
        REQUIRE(slicer.slice_to(result, view_of(soup), options, {.threads = 2}).ok());
        CHECK(result.hash() == expected);
        CHECK(memory.held() == 0);
    }
}

TEST_CASE("welding fails cleanly at each of its allocations", "[engine][faults]") {
    const shapes::Soup soup = everything();
    fail_everywhere([&](const Memory* memory) { return code_of(weld(view_of(soup), 0.01, {.memory = memory})); });
}

TEST_CASE("assembling fails cleanly at each of its allocations", "[engine][faults]") {
    std::vector<lamella::Segment> segments;
    for (std::uint64_t i = 0; i < 5000; ++i) {
        const auto at = static_cast<std::int32_t>(i);
        segments.push_back({{i, 0, 0}, {i % 3 == 2 ? i - 2 : i + 1, 0, 0}, {at, at % 7}, {at + 1, at % 5}, 0, 0});
    }
    fail_everywhere([&](const Memory* memory) { return code_of(assemble(segments, {.memory = memory})); });
}

TEST_CASE("reading fails cleanly at each of its allocations", "[engine][faults]") {
    const TempFolder folder;
    const auto facets = lamella::input_test::numbered_facets(500);
    const bool text = GENERATE(false, true);
    const auto path = folder.write(text ? "text.stl" : "binary.stl",
                                   text ? lamella::input_test::ascii_stl(facets) : lamella::input_test::binary_stl(facets));
    fail_everywhere([&](const Memory* memory) { return code_of(lamella::read_mesh(path, {}, {.memory = memory})); });
}
