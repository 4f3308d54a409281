// Every allocation fails in turn. Each failure must be an error, and no memory may stay allocated.
#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/host_arrays.hpp"
#include "engine/slicing.hpp"
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

void fail_slicing_everywhere(const shapes::Soup& soup, SliceOptions options, std::uint64_t step = 1) {
    fail_everywhere(
        [&](const Memory* memory) {
            options.control.memory = memory;
            return code_of(slice(view_of(soup), options));
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
    SliceOptions options = uniform(0.4);
    options.tuning.form = GENERATE(lamella::ContourForm::swept, lamella::ContourForm::assembled);
    options.control.threads = GENERATE(1, 3);
    options.tuning.band_planes = GENERATE(0, 5);
    fail_slicing_everywhere(everything(), options);
}

TEST_CASE("a slice to a sink fails cleanly at each of its allocations", "[engine][faults][sink]") {
    SliceOptions options = uniform(0.4);
    options.close_gaps_mm = 2;
    options.control.threads = GENERATE(1, 3);
    options.tuning.band_planes = GENERATE(0, 5);
    const auto order = GENERATE(lamella::SinkOrder::any, lamella::SinkOrder::ascending);
    const auto nothing = [](const lamella::LayerView&) noexcept {};
    const shapes::Soup soup = everything();
    fail_everywhere([&](const Memory* memory) {
        options.control.memory = memory;
        return code_of(slice_to(lamella::LayerSink::to(nothing, order), view_of(soup), options));
    });
}

TEST_CASE("a slice into the host's arrays fails cleanly at each of its allocations", "[engine][faults][host]") {
    SliceOptions options = uniform(0.4);
    options.control.threads = GENERATE(1, 3);
    const auto type = GENERATE(lamella::PointType::i32, lamella::PointType::f64);
    const shapes::Soup soup = everything();
    const HostArrays host(1 << 16, 1 << 12, 1 << 10, type);
    fail_everywhere([&](const Memory* memory) {
        options.control.memory = memory;
        return code_of(slice_into(host.output, view_of(soup), options));
    });
}

TEST_CASE("slabs fail cleanly at each of their allocations", "[engine][faults][slabs]") {
    const shapes::Soup soup = everything();
    lamella::SlabOptions options;
    options.plan.spacing = lamella::UniformLayers{0.4};
    options.region.drop_collinear = true;
    options.region.close_mm = GENERATE(0.0, 0.6);
    options.control.threads = GENERATE(1, 3);
    fail_everywhere([&](const Memory* memory) {
        options.control.memory = memory;
        return code_of(slice_slabs(view_of(soup), options));
    });
}

TEST_CASE("a slice by random planes fails cleanly at each of its allocations", "[engine][faults]") {
    SliceOptions options;
    options.plan.spacing = lamella::RandomLayers{0.2, 0.6, 4};
    options.control.threads = 1;
    fail_slicing_everywhere(everything(), options);
}

TEST_CASE("filling and closing gaps fail cleanly at each of their allocations", "[engine][faults]") {
    SliceOptions options = uniform(0.7);
    options.region.fill_rule = GENERATE(lamella::FillRule::contours, lamella::FillRule::even_odd,
                                        lamella::FillRule::non_zero, lamella::FillRule::positive);
    options.close_gaps_mm = 2;
    options.control.threads = 2;
    fail_slicing_everywhere(everything(), options);
}

TEST_CASE("every rule of regions fails cleanly at each of its allocations", "[engine][faults][closing]") {
    SliceOptions options = uniform(1.4);
    options.region.fill_rule = lamella::FillRule::non_zero;
    SECTION("closing") {
        options.region.close_mm = GENERATE(0.01, 0.6, 2.0);
    }
    SECTION("offset") {
        options.region.offset_mm = GENERATE(-0.5, 0.5);
    }
    SECTION("closing, offset and what comes after them") {
        options.region.close_mm = 0.6;
        options.region.offset_mm = 0.2;
        options.region.largest_only = true;
        options.region.drop_collinear = true;
    }
    SECTION("outermost") {
        options.region.fill_rule = lamella::FillRule::outermost;
    }
    SECTION("simplification") {
        options.region.fill_rule = GENERATE(lamella::FillRule::contours, lamella::FillRule::positive);
        options.region.simplify_mm = 0.3;
        options.origins = true;
    }
    SECTION("marks") {
        options.region.fill_rule = GENERATE(lamella::FillRule::contours, lamella::FillRule::positive);
        options.region.mark_near_mm = 0.6;
    }
    options.control.threads = 1;
    fail_slicing_everywhere(everything(), options);
}

TEST_CASE("the region of given contours fails cleanly at each of its allocations", "[engine][faults][closing]") {
    const std::vector<lamella::Point> low = {{0, 0}, {4000, 0}, {4000, 4000}, {0, 4000}};
    const std::vector<lamella::Point> high = {{2000, 2000}, {6000, 2000}, {6000, 6000}, {2000, 6000}};
    const std::vector<lamella::Point> beside = {{6100, 0}, {9000, 0}, {9000, 5000}, {6100, 5000}};
    const std::vector<std::span<const lamella::Point>> contours = {low, high, beside};
    lamella::RegionRules rules;
    rules.fill_rule = lamella::FillRule::non_zero;
    rules.close_mm = 60;
    rules.offset_mm = -20;
    rules.drop_collinear = true;
    fail_everywhere([&](const Memory* memory) {
        lamella::Control control;
        control.memory = memory;
        return code_of(lamella::region_of(contours, rules, 1, control));
    });
}

TEST_CASE("a wide plane fails cleanly at its allocations", "[engine][faults][wide][threads]") {
    const shapes::Soup soup = wide_plane();
    SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{{0.5}};
    options.control.threads = 2;
    CountingMemory counting;
    options.control.memory = &counting;
    REQUIRE(slice(view_of(soup), options).ok());
    // Each run slices 2^18 segments, so only about a dozen allocations are tested, spread over all.
    fail_slicing_everywhere(soup, options, std::max<std::uint64_t>(1, counting.asked() / 12));
}

TEST_CASE("a workspace that ran out of memory slices again", "[engine][faults][threads]") {
    const shapes::Soup soup = everything();
    SliceOptions options = uniform(0.4);
    options.control.threads = 2;
    const std::uint64_t expected = hash_result(sliced(soup, options));
    for (std::uint64_t at = 1; at < 200; at += 7) {
        lamella::Workspace workspace;
        lamella::SliceResult result;
        CountingMemory memory(~std::size_t{0}, at);
        options.control.memory = &memory;
        (void)slice(view_of(soup), options, workspace, result);
        options.control.memory = nullptr;
        INFO("allocation " << at);
        REQUIRE(slice(view_of(soup), options, workspace, result).ok());
        CHECK(hash_result(result) == expected);
        CHECK(memory.held() == 0);
    }
}

TEST_CASE("welding fails cleanly at each of its allocations", "[engine][faults]") {
    const shapes::Soup soup = everything();
    fail_everywhere([&](const Memory* memory) { return code_of(weld(view_of(soup), {.control = {.memory = memory}})); });
}

TEST_CASE("assembling fails cleanly at each of its allocations", "[engine][faults]") {
    std::vector<lamella::Segment> segments;
    for (std::uint64_t i = 0; i < 5000; ++i) {
        const auto at = static_cast<std::int32_t>(i);
        segments.push_back({{i, 0, 0}, {i % 3 == 2 ? i - 2 : i + 1, 0, 0}, {at, at % 7}, {at + 1, at % 5}, 0, 0});
    }
    fail_everywhere([&](const Memory* memory) {
        lamella::Control control;
        control.memory = memory;
        return code_of(assemble(segments, control));
    });
}

TEST_CASE("reading fails cleanly at each of its allocations", "[engine][faults]") {
    const TempFolder folder;
    const auto facets = lamella::input_test::numbered_facets(500);
    const bool text = GENERATE(false, true);
    const auto path = folder.write(text ? "text.stl" : "binary.stl",
                                   text ? lamella::input_test::ascii_stl(facets) : lamella::input_test::binary_stl(facets));
    fail_everywhere([&](const Memory* memory) {
        lamella::ReadOptions options;
        options.control.memory = memory;
        return code_of(read_mesh(path, options));
    });
}
