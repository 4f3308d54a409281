// Every allocation fails in turn. Each failure must be an error, and no memory may stay allocated.
#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/calls.hpp"
#include "engine/counting_memory.hpp"
#include "input/files.hpp"

using lamella::ErrorCode;
using lamella::FillRule;
using lamella::SliceOptions;

namespace {

/// Runs `call` until it succeeds. In each run, the first failing allocation is `step` later. Returns how often it failed.
std::uint64_t fail_everywhere(const std::function<std::optional<ErrorCode>(const lamella::Context&)>& call,
                              lamella::Context context = {}, std::uint64_t step = 1) {
    std::optional<ErrorCode> code = ErrorCode::out_of_memory;
    std::uint64_t at = 1;
    for (; code; at += step) {
        const CountingMemory memory(~std::size_t{0}, at);
        context.memory = &memory;
        code = call(context);
        INFO("allocation " << at);
        REQUIRE(memory.held() == 0);
        REQUIRE(code.value_or(ErrorCode::out_of_memory) == ErrorCode::out_of_memory);
    }
    return at / step - 1;
}

void fail_slicing_everywhere(const shapes::Soup& soup, const SliceOptions& options, const Way& way, std::uint64_t step = 1) {
    const std::uint64_t failures = fail_everywhere(
        [&](const lamella::Context& context) {
            lamella::Slicer slicer;
            lamella::SliceResult result(context.memory);
            return code_of(slice_tuned(slicer, result, view_of(soup), options, way.tuning, context));
        },
        way.context, step);
    CHECK(failures > 0);
}

/// Nested and overlapping shells, one inverted, one with a hole in its surface: contours of every role.
shapes::Soup everything() {
    return shapes::joined({shapes::box({0, 0, 0}, {9, 9, 9}), shapes::flipped(shapes::box({1, 1, 1}, {4, 4, 8})),
                           shapes::box({6, 6, 0}, {12, 12, 9}),
                           shapes::without(shapes::octasphere({20, 0, 5}, 5, 2), 108, 6)});
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

TEST_CASE("every call fails cleanly at each of its allocations", "[engine][faults][sink][host]") {
    using namespace lamella::input_test;
    const TempFolder folder;
    const shapes::Soup soup = everything();
    const auto facets = numbered_facets(500);
    ContextCalls calls(view_of(soup), folder.write("a.stl", binary_stl(facets)), 0.4);
    for (const ContextCall& call : calls.all()) {
        for (const int threads : {1, 3}) {
            INFO(call.name << ", " << threads << " threads");
            const std::uint64_t failures = fail_everywhere(call.run, {.threads = threads});
            CHECK((failures > 0 || !call.name.starts_with("slice")));
        }
    }
    const auto text = folder.write("text.stl", text_stl(facets));
    CHECK(0 < fail_everywhere([&](const lamella::Context& c) { return code_of(lamella::read_mesh(text, {}, c)); }));
    std::vector<lamella::Segment> segments;
    for (std::uint64_t i = 0; i < 5000; ++i) {
        const auto at = static_cast<std::int32_t>(i);
        segments.push_back({{i, 0, 0}, {i % 3 == 2 ? i - 2 : i + 1, 0, 0}, {at, at % 7}, {at + 1, at % 5}, 0, 0});
    }
    CHECK(0 < fail_everywhere([&](const lamella::Context& c) { return code_of(assemble(segments, c)); }));
    const std::vector<lamella::Point> low = {{0, 0}, {4000, 0}, {4000, 4000}, {0, 4000}};
    const std::vector<lamella::Point> high = {{2000, 2000}, {6000, 2000}, {6000, 6000}, {2000, 6000}};
    const std::vector<lamella::Point> beside = {{6100, 0}, {9000, 0}, {9000, 5000}, {6100, 5000}};
    const std::vector<std::span<const lamella::Point>> contours = {low, high, beside};
    const lamella::RegionRules rules{
        .fill_rule = FillRule::non_zero, .closing_mm = 60, .offset_mm = -20, .drop_collinear = true};
    CHECK(0 <
          fail_everywhere([&](const lamella::Context& c) { return code_of(lamella::region_of(contours, rules, 1, c)); }));
}

TEST_CASE("a slice fails cleanly at each of its allocations, in every form and by every rule",
          "[engine][faults][closing][slabs]") {
    constexpr FillRule united = FillRule::non_zero;
    for (const Way& way : ways()) {
        if (way.context.threads <= 3 && (way.tuning.band_planes == 0 || way.tuning.band_planes == 7)) {
            fail_slicing_everywhere(everything(), uniform(0.4), way);
        }
    }
    fail_slicing_everywhere(everything(), {}, {{.threads = 1}, {.random_heights = lamella::RandomHeights{0.2, 0.6, 4}}});
    using lamella::LayerContent;
    std::vector<SliceOptions> asked;
    for (const LayerContent content : {LayerContent::upward_faces, LayerContent::downward_faces}) {
        for (const double closing_mm : {0.0, 0.6}) {
            asked.push_back(
                {.layer_height_mm = 0.4, .content = content, .region = {.closing_mm = closing_mm, .drop_collinear = true}});
        }
    }
    for (const FillRule rule : {FillRule::contours, FillRule::even_odd, united, FillRule::positive}) {
        asked.push_back({.layer_height_mm = 0.7, .stitch_mm = 2, .region = {.fill_rule = rule}});
    }
    for (const lamella::RegionRules& rules : std::initializer_list<lamella::RegionRules>{
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
             {.fill_rule = FillRule::positive, .flag_closing_mm = 0.6}}) {
        asked.push_back({.layer_height_mm = 1.4, .origins = rules.simplify_mm != 0, .region = rules});
    }
    int threads = 1;
    for (const SliceOptions& options : asked) {
        INFO("case " << &options - asked.data());
        fail_slicing_everywhere(everything(), options, {{.threads = threads = 3 - threads}, {}});
    }
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
