// Every allocation fails in turn. Each failure must be an error, and no memory may stay allocated.
#include "engine/calls.hpp"

using namespace lamella;

namespace {

void fail_slicing_everywhere(const shapes::Soup& soup, const SliceOptions& options, const Way& way, std::uint64_t step = 1) {
    const std::uint64_t failures = fail_everywhere(
        [&](const Context& context) {
            Slicer slicer;
            SliceResult result(context.memory);
            return code_of(slice_tuned(slicer, result, view_of(soup), options, way.tuning, context));
        },
        way.context, step);
    CHECK(failures > 0);
}

TEST_CASE("every call fails cleanly at each of its allocations", "[engine][faults][sink][host]") {
    const shapes::Soup soup = everything();
    ContextCalls calls(view_of(soup), 0.4);
    for (const ContextCall& call : calls.all_and_small()) {
        for (const int threads : {1, 3}) {
            INFO(call.name << ", " << threads << " threads");
            const std::uint64_t failures = fail_everywhere(call.run, {.threads = threads});
            CHECK((failures > 0 || !call.name.starts_with("slice")));
        }
    }
}

TEST_CASE("a slice fails cleanly at each of its allocations, in every form and by every rule",
          "[engine][faults][closing][slabs]") {
    constexpr FillRule united = FillRule::non_zero;
    for (const Way& way : ways()) {
        if (way.context.threads <= 3 && (way.tuning.band_planes == 0 || way.tuning.band_planes == 7)) {
            fail_slicing_everywhere(everything(), uniform(0.4), way);
        }
    }
    fail_slicing_everywhere(everything(), {}, {{.threads = 1}, {.random_heights = RandomHeights{0.2, 0.6, 4}}});
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
    for (const RegionRules& rules : std::initializer_list<RegionRules>{
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
    const shapes::Soup soup = shapes::prism(1 << 15, 400, 1);  // which threads share: 2^18 segments
    const SliceOptions options{.heights_mm = {{0.5}}};
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
        Slicer slicer;
        SliceResult result;
        const CountingMemory memory(~std::size_t{0}, at);
        (void)slicer.slice_to(result, view_of(soup), options, {.threads = 2, .memory = &memory});
        INFO("allocation " << at);
        REQUIRE(slicer.slice_to(result, view_of(soup), options, {.threads = 2}).ok());
        CHECK(result.hash() == expected);
        CHECK(memory.held() == 0);
    }
}

}  // namespace
