// Layers handed to a sink come in the order asked for, and take no memory that grows with their number. That they are those
// of a result: test_sources.cpp.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"

using lamella::LayerSink;
using lamella::LayerView;
using lamella::SinkOrder;

namespace {

constexpr std::array orders = {SinkOrder::any, SinkOrder::ascending};

/// Notes whether layers came by one thread at a time, in plane order.
struct OrderNote {
    std::uint64_t next = 0;
    bool in_order = true;
    std::atomic<int> inside{0};
    void operator()(const LayerView& view) noexcept {
        in_order = in_order && inside.fetch_add(1) == 0 && view.index == next;
        ++next;
        inside.fetch_sub(1);
    }
};

}  // namespace

TEST_CASE("a sink in any order needs no memory for the layers", "[engine][sink][memory][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    const auto peak = [&](double layer_height, std::uint64_t& layer_bytes) {
        const CountingMemory memory;
        const auto nothing = [](const LayerView&) noexcept {};
        lamella::Slicer slicer;
        const lamella::SliceInfo info =
            value_of(slicer.slice_to(LayerSink{.take = nothing, .order = SinkOrder::any}, view_of(ball),
                                     uniform(layer_height), {.threads = 2, .memory = &memory}));
        layer_bytes = info.points * sizeof(lamella::Point) + info.contours * sizeof(lamella::Contour);
        CHECK(slicer.bytes() >= memory.held());
        slicer.reset();
        CHECK(memory.held() == 0);
        return memory.peak();
    };
    std::uint64_t few_bytes = 0;
    std::uint64_t many_bytes = 0;
    const std::size_t few = peak(0.02, few_bytes);
    const std::size_t many = peak(0.002, many_bytes);
    // Some bytes a plane are added, and the parcel that each thread makes room for.
    CHECK(many < few + (many_bytes - few_bytes) / 4);
}

TEST_CASE("what is put aside for an ascending sink ends at its window, and goes when the call ends",
          "[engine][sink][memory][threads]") {
    const shapes::Soup prism = shapes::prism(1 << 13, 400, 800);  // half a megabyte a layer
    const bool ends = GENERATE(false, true);
    const CountingMemory memory;
    OrderNote note;
    std::atomic<bool> ended{false};
    const auto take = [&](const LayerView& view) noexcept {
        if (view.index == 0) {
            // The other thread puts aside what it may: until it has asked for no more memory for a second.
            std::size_t before = 0;
            for (int i = 0, quiet = 0; i < 100 && quiet < 10; ++i) {
                quiet = memory.peak() == std::exchange(before, memory.peak()) ? quiet + 1 : 0;
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
            }
            ended = ends;
        }
        note(view);
    };
    const auto stop = [&]() noexcept { return ended.load(); };
    lamella::Slicer slicer;
    const auto info = slice_tuned(slicer, LayerSink{.take = take}, view_of(prism), uniform(1), {.band_planes = 400},
                                  {.threads = 2, .stop = stop, .memory = &memory});
    CHECK(code_of(info) == (ends ? std::optional(lamella::ErrorCode::cancelled) : std::nullopt));
    CHECK(note.next == (ends ? 1 : 800));
    CHECK(note.in_order);
    CHECK(memory.peak() < 120'000'000);
}

TEST_CASE("a slow sink gets every layer, an ascending one in plane order by one thread at a time",
          "[engine][sink][threads]") {
    const std::int64_t band = GENERATE(0, 1, 5);
    // Hollow, so that contours have parents, and torn, so that there are stitches.
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    shapes::Soup hollow = shapes::joined({shapes::flipped(shapes::scaled(ball, {0.5, 0.5, 0.5})), ball});
    hollow.resize(hollow.size() - 9 * std::size_t{20});
    lamella::SliceOptions options = uniform(0.1);
    options.stitch_mm = 50;
    const lamella::SliceResult expected = sliced(hollow, options);
    REQUIRE(expected.stitches.size() > 3);
    for (const SinkOrder order : orders) {
        ComparedLayers compared(expected);
        OrderNote note;
        const auto slow = [&](const LayerView& view) noexcept {
            if (view.index % 16 == 0) {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));  // the other threads put layers aside
            }
            if (order == SinkOrder::ascending) {
                note(view);
            }
            compared(view);
        };
        const lamella::SliceInfo info = sliced_to(LayerSink{.take = slow, .order = order}, view_of(hollow), options,
                                                  {.threads = 4}, {.band_planes = band});
        require_same(info, expected.info);
        compared.require_all(expected.size());
        CHECK(note.in_order);
    }
}

TEST_CASE("a sink may end the call, and gets no layer more", "[engine][sink][control][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    for (const int threads : {1, 3}) {
        for (const SinkOrder order : orders) {
            std::atomic<bool> ended{false};
            std::atomic<std::uint64_t> layers{0};
            const auto end_at_ten = [&](const LayerView& view) noexcept {
                ++layers;
                if (view.index == 10) {
                    ended = true;
                }
            };
            const auto stop = [&]() noexcept { return ended.load(); };
            const auto info = lamella::Slicer().slice_to(LayerSink{.take = end_at_ten, .order = order}, view_of(ball),
                                                         uniform(0.02), {.threads = threads, .stop = stop});
            CHECK(code_of(info) == lamella::ErrorCode::cancelled);
            CHECK((order == SinkOrder::any || layers == 11));
            CHECK(layers < 900);
        }
    }
}

TEST_CASE("a sink may slice", "[engine][sink][executor][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const auto one_by_one = [](int workers, lamella::Callback<void()> body) noexcept {
        for (int i = 0; i < workers; ++i) {
            body();
        }
    };
    for (const bool has_executor : {false, true}) {
        for (const SinkOrder order : orders) {
            std::atomic<std::uint64_t> contours{0};
            const auto slicing = [&](const LayerView&) noexcept {
                lamella::Slicer slicer;
                lamella::SliceResult result;
                const auto info =
                    slice_tuned(slicer, result, view_of(box), uniform(0.05), {.band_planes = 3}, {.threads = 3});
                contours += info.ok() ? result.contours.size() : 0;
            };
            lamella::Context context{.threads = 4};
            if (has_executor) {
                context.executor = one_by_one;
                context.executor_threads = 4;
            }
            const lamella::SliceInfo info = sliced_to(LayerSink{.take = slicing, .order = order}, view_of(ball),
                                                      uniform(0.25), context, {.band_planes = 2});
            CHECK(contours == 80 * info.layers);
        }
    }
}
