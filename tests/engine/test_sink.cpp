// Layers handed to a sink come in the order asked for, and take no memory that grows with their number. That they are those
// of a result: test_sources.cpp.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"
#include "slicing/handover/sink_target.hpp"

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

/// All that SinkBands takes for granted, with bands of one wide layer after the other.
struct ManyLayers {
    ManyLayers(std::uint32_t layers, std::uint32_t band_layers, const lamella::Memory* memory)
        : planes(memory), scratch(memory), result(memory), bands(bands_of(layers, band_layers)) {
        lamella::Array<lamella::Layer> heights;
        heights.resize_discarding(layers);
        for (std::uint32_t i = 0; i < layers; ++i) {
            heights[i] = {.plane = lamella::PlaneHeight(static_cast<std::int32_t>(2 * i + 1))};
        }
        planes.build(heights);
    }

    static std::vector<lamella::Band> bands_of(std::uint32_t layers, std::uint32_t band_layers) {
        std::vector<lamella::Band> bands;
        for (std::uint32_t first = 0; first < layers; first += band_layers) {
            bands.push_back({first, std::min(first + band_layers, layers), std::uint64_t{band_layers} * layer_points});
        }
        return bands;
    }

    /// A layer of one contour.
    static void build(lamella::BandOutput& output) {
        std::fill_n(output.reserve_points(layer_points), layer_points, lamella::Point{1, 2});
        lamella::Contour& contour = output.contours.emplace_back();
        contour.first_point = output.point_count;
        contour.point_count = layer_points;
        output.point_count += layer_points;
        output.layer_contours.push_back(1);
        output.end_layer();
    }

    static constexpr std::uint32_t layer_points = 1 << 16;  // half a megabyte
    lamella::PlaneSet planes;
    lamella::OutputScratch scratch;
    lamella::SliceResult result;
    std::vector<lamella::Band> bands;
    lamella::Parallel parallel{{.threads = 2}};
    std::function<lamella::Layer(lamella::PlaneIndex)> layer_at = [this](lamella::PlaneIndex plane) {
        return lamella::describe_layer(planes, plane, layer_points);
    };
    lamella::OutputPlan plan{.layers = static_cast<lamella::PlaneIndex>(planes.size()),
                             .layer_at = layer_at,
                             .segments = std::uint64_t{planes.size()} * layer_points,
                             .cutting = planes.size(),
                             .bands = bands,
                             .parallel = parallel,
                             .scratch = scratch,
                             .origins = false,
                             .result = result,
                             .lead = lamella::usual_lead(parallel)};
};

}  // namespace

TEST_CASE("an ascending sink is called by one thread at a time, in plane order", "[engine][sink][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    for (const std::int64_t band : {0, 1, 3}) {
        OrderNote note;
        const lamella::SliceInfo info =
            sliced_to(LayerSink{.take = note}, view_of(ball), uniform(0.02), {.threads = 4}, {.band_planes = band});
        CHECK(note.in_order);
        CHECK(note.next == info.layers);
    }
}

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

TEST_CASE("what is put aside for an ascending sink ends at its window", "[engine][sink][memory][threads]") {
    constexpr std::uint32_t band_layers = 400;  // 200 MB
    const CountingMemory memory;
    ManyLayers given(2 * band_layers, band_layers, &memory);
    OrderNote note;
    const LayerSink sink{.take = note};
    lamella::SinkBands bands(sink, given.plan);
    lamella::BandOutput* const head = bands.acquire(0);
    std::atomic<std::uint32_t> put_aside{0};
    std::thread ahead([&] {
        lamella::BandOutput* const output = bands.acquire(1);
        for (std::uint32_t i = 0; i < band_layers; ++i) {
            ManyLayers::build(*output);
            ++put_aside;
        }
        bands.submit(1);
    });
    constexpr std::uint32_t in_window = 128;
    while (put_aside < in_window / 2) {
        std::this_thread::yield();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    CHECK(put_aside <= in_window);
    CHECK(note.next == 0);
    CHECK(memory.peak() < 80'000'000);
    for (std::uint32_t i = 0; i < band_layers; ++i) {
        ManyLayers::build(*head);
    }
    bands.submit(0);
    ahead.join();
    CHECK(note.next == 2 * band_layers);
    CHECK(note.in_order);
    CHECK(bands.totals().points == std::uint64_t{2} * band_layers * ManyLayers::layer_points);
    CHECK(memory.peak() < 80'000'000);
}

TEST_CASE("a band that is put aside is dropped when another thread fails", "[engine][sink][threads]") {
    constexpr std::uint32_t band_layers = 400;
    ManyLayers given(2 * band_layers, band_layers, nullptr);
    OrderNote note;
    const LayerSink sink{.take = note};
    lamella::SinkBands bands(sink, given.plan);
    REQUIRE(bands.acquire(0) != nullptr);
    std::atomic<bool> dropped{false};
    std::thread ahead([&] {
        lamella::BandOutput* const output = bands.acquire(1);
        try {
            for (std::uint32_t i = 0; i < band_layers; ++i) {
                ManyLayers::build(*output);
            }
        } catch (const lamella::BandDropped&) {
            dropped = true;
        }
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    bands.abort();
    ahead.join();
    CHECK(dropped);
    CHECK(note.next == 0);
    CHECK(bands.acquire(1) == nullptr);
}

TEST_CASE("a slow sink gets every layer in order", "[engine][sink][threads]") {
    // Hollow, so that contours have parents, and torn, so that there are stitches.
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    shapes::Soup hollow = shapes::joined({shapes::flipped(shapes::scaled(ball, {0.5, 0.5, 0.5})), ball});
    hollow.resize(hollow.size() - 9 * std::size_t{20});
    lamella::SliceOptions options = uniform(0.1);
    options.stitch_mm = 50;
    const lamella::SliceResult expected = sliced(hollow, options);
    REQUIRE(expected.stitches.size() > 3);
    for (const SinkOrder order : orders) {
        CollectedLayers collected;
        OrderNote note;
        const auto slow = [&](const LayerView& view) noexcept {
            if (view.index % 16 == 0) {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));  // the other threads put layers aside
            }
            if (order == SinkOrder::ascending) {
                note(view);
            }
            collected(view);
        };
        const lamella::SliceInfo info =
            sliced_to(LayerSink{.take = slow, .order = order}, view_of(hollow), options, {.threads = 4}, {.band_planes = 5});
        require_same(collected.result(info), expected);
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
