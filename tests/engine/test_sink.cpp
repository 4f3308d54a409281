// Layers handed to a sink are those of slice(), in the order asked for, and take no memory that grows with their number.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/collected_layers.hpp"
#include "engine/counting_memory.hpp"
#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"
#include "slicing/handover/sink_target.hpp"

using lamella::LayerSink;
using lamella::LayerView;
using lamella::SinkOrder;
using lamella::SliceOptions;
using lamella::SliceTotals;

namespace {

constexpr std::array orders = {SinkOrder::any, SinkOrder::ascending};

#ifdef LAMELLA_TESTS_SANITIZED
constexpr double region_layer_mm = 5;
#else
constexpr double region_layer_mm = 1;
#endif

SliceTotals handed(const LayerSink& sink, const lamella::MeshView& mesh, const SliceOptions& options) {
    return value_of(slice_to(sink, mesh, options));
}

void require_same_layers(const lamella::MeshView& mesh, const SliceOptions& options) {
    const lamella::SliceResult expected = value_of(slice(mesh, options));
    for (const SinkOrder order : orders) {
        INFO("ascending " << (order == SinkOrder::ascending));
        CollectedLayers collected;
        const SliceTotals totals = handed(LayerSink::to(collected, order), mesh, options);
        REQUIRE(collected.difference(expected) == "");
        require_same_totals(totals, expected);
    }
}

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
        : planes(memory), buckets(memory), scratch(memory), result(memory), bands(bands_of(layers, band_layers)) {
        lamella::Array<lamella::Layer> heights;
        heights.resize_discarding(layers);
        for (std::uint32_t i = 0; i < layers; ++i) {
            heights[i] = {.plane = lamella::PlaneHeight(static_cast<std::int32_t>(2 * i + 1))};
        }
        planes.build(heights);
        buckets.segments.resize_discarding(layers);
        std::fill(buckets.segments.begin(), buckets.segments.end(), layer_points);
        buckets.segment_count = std::uint64_t{layers} * layer_points;
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
    lamella::Buckets buckets;
    lamella::OutputScratch scratch;
    lamella::SliceResult result;
    std::vector<lamella::Band> bands;
    lamella::Parallel parallel{lamella::Control{.threads = 2}};
    lamella::SweepInput input{planes, buckets, bands, parallel, scratch, false, result};
};

}  // namespace

TEST_CASE("a sink gets the layers of slice() whatever threads, bands and form", "[engine][sink][threads]") {
    unsigned combination = 0;
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        SliceOptions options = uniform(0.25);
        options.close_gaps_mm = 0.5;
        for (const Way& way : ways()) {
            INFO(mesh_name << ", " << way);
            if (tried(combination++)) {
                require_same_layers(view_of(mesh), by(way, options));
            }
        }
    }
}

TEST_CASE("a sink gets the regions of slice()", "[engine][sink][fill][threads]") {
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        INFO(mesh_name);
        SliceOptions options = uniform(region_layer_mm);
        options.control.threads = 3;
        options.tuning.band_planes = 1;
        options.region.fill_rule = lamella::FillRule::non_zero;
        options.region.fill_from = {{2, lamella::FillRule::even_odd}};
        options.region.offset_mm = -0.4;
        options.region.largest_only = true;
        options.region.mark_near_mm = 0.1;
        require_same_layers(view_of(mesh), options);
    }
}

TEST_CASE("a sink gets planes that all threads work on together", "[engine][sink][wide][threads]") {
    constexpr int quarters = 1 << 15;  // eight facets each: 2^18 segments
    SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{{0.25, 0.5, 0.75}};
    options.control.threads = 2;
    require_same_layers(view_of(shapes::prism(quarters, 400, 1)), options);
    // With an edge that is open, each band is begun twice.
    const shapes::Soup open = shapes::without(shapes::prism(quarters, 400, 1), 0, 1);
    options.close_gaps_mm = 1;
    require_same_layers(view_of(open), options);
}

TEST_CASE("an ascending sink is called by one thread at a time, in plane order", "[engine][sink][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    for (const int band : {0, 1, 3}) {
        SliceOptions options = uniform(0.02);
        options.control.threads = 4;
        options.tuning.band_planes = band;
        OrderNote note;
        const SliceTotals totals = handed(LayerSink::to(note, SinkOrder::ascending), view_of(ball), options);
        CHECK(note.in_order);
        CHECK(note.next == totals.layers);
    }
}

TEST_CASE("layers that nothing crosses go to the sink, too", "[engine][sink]") {
    SliceOptions options = at_heights({-5, 1, 3, 20});
    std::vector<std::pair<std::uint64_t, std::size_t>> seen;
    const auto note = [&](const LayerView& view) noexcept { seen.emplace_back(view.index, view.contours.size()); };
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const SliceTotals totals = handed(LayerSink::to(note, SinkOrder::ascending), view_of(box), options);
    CHECK(seen == std::vector<std::pair<std::uint64_t, std::size_t>>{{0, 0}, {1, 1}, {2, 1}, {3, 0}});
    CHECK(totals.layers == 4);
    CHECK(totals.contours == 2);
    CHECK(totals.summary.emptied_layers == 0);
}

TEST_CASE("a sink in any order needs no memory for the layers", "[engine][sink][memory][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    const auto peak = [&](double layer_height, std::uint64_t& layer_bytes) {
        const CountingMemory memory;
        SliceOptions options = uniform(layer_height);
        options.control.threads = 2;
        options.control.memory = &memory;
        const auto nothing = [](const LayerView&) noexcept {};
        const SliceTotals totals = handed(LayerSink::to(nothing, SinkOrder::any), view_of(ball), options);
        layer_bytes = totals.points * sizeof(lamella::Point) + totals.contours * sizeof(lamella::Contour);
        CHECK(memory.held() == 0);
        return memory.peak();
    };
    std::uint64_t few_bytes = 0;
    std::uint64_t many_bytes = 0;
    const std::size_t few = peak(0.02, few_bytes);
    const std::size_t many = peak(0.002, many_bytes);
    // What grows is some bytes a plane, and the parcel that each thread makes room for.
    CHECK(many < few + (many_bytes - few_bytes) / 4);
}

TEST_CASE("what is put aside for an ascending sink ends at its window", "[engine][sink][memory][threads]") {
    constexpr std::uint32_t band_layers = 400;  // 200 MB
    const CountingMemory memory;
    ManyLayers given(2 * band_layers, band_layers, &memory);
    OrderNote note;
    const LayerSink sink = LayerSink::to(note, SinkOrder::ascending);
    lamella::SinkBands bands(sink, given.input);
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
    const LayerSink sink = LayerSink::to(note, SinkOrder::ascending);
    lamella::SinkBands bands(sink, given.input);
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
    // Hollow, so that contours have parents, and torn, so that gaps are closed.
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    shapes::Soup hollow = shapes::joined({shapes::flipped(shapes::scaled(ball, {0.5, 0.5, 0.5})), ball});
    hollow.resize(hollow.size() - 9 * std::size_t{20});
    SliceOptions options = uniform(0.1);
    options.control.threads = 4;
    options.tuning.band_planes = 5;
    options.close_gaps_mm = 50;
    const lamella::SliceResult expected = sliced(hollow, options);
    REQUIRE(expected.closed_gaps.size() > 3);
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
        handed(LayerSink::to(slow, order), view_of(hollow), options);
        REQUIRE(collected.difference(expected) == "");
        CHECK(note.in_order);
    }
}

TEST_CASE("a sink may end the call, and gets no layer more", "[engine][sink][control][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    for (const int threads : {1, 3}) {
        for (const SinkOrder order : orders) {
            std::atomic<bool> stop{false};
            std::atomic<std::uint64_t> layers{0};
            const auto end_at_ten = [&](const LayerView& view) noexcept {
                ++layers;
                if (view.index == 10) {
                    stop = true;
                }
            };
            SliceOptions options = uniform(0.02);
            options.control.threads = threads;
            options.control.stop = lamella::StopCheck::when(stop);
            const auto totals = slice_to(LayerSink::to(end_at_ten, order), view_of(ball), options);
            CHECK(code_of(totals) == lamella::ErrorCode::cancelled);
            CHECK((order == SinkOrder::any || layers == 11));
            CHECK(layers < 900);
        }
    }
}

TEST_CASE("a sink may slice", "[engine][sink][executor][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    SliceOptions inner = uniform(0.05);
    inner.control.threads = 3;
    inner.tuning.band_planes = 3;
    auto one_by_one = [](int workers, const auto& body) noexcept {
        for (int i = 0; i < workers; ++i) {
            body();
        }
    };
    for (const bool has_executor : {false, true}) {
        for (const SinkOrder order : orders) {
            std::atomic<std::uint64_t> contours{0};
            const auto slicing = [&](const LayerView&) noexcept {
                const auto result = slice(view_of(box), inner);
                contours += result.ok() ? result->contours.size() : 0;
            };
            SliceOptions options = uniform(0.25);
            options.control.threads = 4;
            options.tuning.band_planes = 2;
            if (has_executor) {
                options.control.executor = lamella::Executor::on(one_by_one, 4);
            }
            const SliceTotals totals = handed(LayerSink::to(slicing, order), view_of(ball), options);
            CHECK(contours == 80 * totals.layers);
        }
    }
}

TEST_CASE("a workspace serves slices to sinks and to results in turn", "[engine][sink][threads]") {
    const auto meshes = shape_cases::meshes();
    lamella::Workspace workspace;
    for (const auto& [mesh_name, mesh] : meshes) {
        INFO(mesh_name);
        SliceOptions options = uniform(0.25);
        options.control.threads = 2;
        lamella::SliceResult result;
        REQUIRE(slice(view_of(mesh), options, workspace, result).ok());
        for (const SinkOrder order : orders) {
            CollectedLayers collected;
            REQUIRE(slice_to(LayerSink::to(collected, order), view_of(mesh), options, workspace).ok());
            REQUIRE(collected.difference(result) == "");
        }
    }
}

TEST_CASE("a sink gets the layers of a prepared mesh, and of heights in any order", "[engine][sink][prepare][threads]") {
    SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{{4, -1, 0.5, 4, 30, 2}};
    options.control.threads = 2;
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        INFO(mesh_name);
        const auto prepared = value_of(lamella::prepare(view_of(mesh)));
        const lamella::SliceResult expected = sliced(mesh, options);
        for (const SinkOrder order : orders) {
            CollectedLayers collected;
            const auto totals = value_of(slice_to(LayerSink::to(collected, order), prepared, options));
            REQUIRE(collected.difference(expected) == "");
            require_same_totals(totals, expected);
            REQUIRE(totals.layer_of.size() == 6);
            CHECK(std::equal(totals.layer_of.begin(), totals.layer_of.end(), expected.layer_of.begin()));
        }
    }
}

TEST_CASE("an empty mesh gives a sink empty layers where asked for", "[engine][sink]") {
    SliceOptions options = at_heights({1, 3});
    options.allow_empty = true;
    std::size_t empty = 0;
    const auto count = [&](const LayerView& view) noexcept {
        empty += view.contours.empty() && view.points.empty() ? 1U : 0U;
    };
    for (const SinkOrder order : orders) {
        CHECK(handed(LayerSink::to(count, order), lamella::MeshView{}, options).layers == 2);
    }
    CHECK(empty == 4);
}

TEST_CASE("a workspace counts what sinks make it hold, and gives it back", "[engine][sink][memory]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    const CountingMemory memory;
    SliceOptions options = uniform(0.02);
    options.control.memory = &memory;
    options.control.threads = 2;
    lamella::Workspace workspace;
    const auto nothing = [](const LayerView&) noexcept {};
    REQUIRE(slice_to(LayerSink::to(nothing, SinkOrder::any), view_of(ball), options, workspace).ok());
    CHECK(workspace.bytes() >= memory.held());
    workspace.reset();
    CHECK(memory.held() == 0);
}

TEST_CASE("a slice to a sink fails as slice() does", "[engine][sink][errors]") {
    const auto nothing = [](const LayerView&) noexcept {};
    const LayerSink sink = LayerSink::to(nothing, SinkOrder::any);
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const auto code = [&](const LayerSink& to, const lamella::MeshView& mesh, const SliceOptions& options) {
        return error_of(slice_to(to, mesh, options)).code;
    };
    CHECK(code({}, view_of(box), uniform(1)) == lamella::ErrorCode::invalid_argument);
    CHECK(code(sink, lamella::MeshView{}, uniform(1)) == lamella::ErrorCode::empty_mesh);
    CHECK(code(sink, view_of(box), uniform(-1)) == failure_of(view_of(box), uniform(-1)).code);
    SliceOptions many = uniform(0.001);
    many.memory_limit_bytes = 1000;
    CHECK(code(sink, view_of(box), many) == lamella::ErrorCode::result_too_large);
    SliceOptions negative = uniform(1);
    negative.control.threads = -1;
    CHECK(code(sink, view_of(box), negative) == lamella::ErrorCode::invalid_argument);
}
