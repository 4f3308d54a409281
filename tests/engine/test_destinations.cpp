// What sinks and the host's arrays promise of their own: order, memory, what does not fit. That they get the layers of a
// result: test_sources.cpp.
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <thread>

#include <catch2/catch.hpp>

#include "cpu_time.hpp"
#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"
#include "golden/inputs.hpp"

using namespace lamella;

namespace {

#ifdef LAMELLA_TESTS_SANITIZED
constexpr std::uint64_t needle_layers = 900;
#else
constexpr std::uint64_t needle_layers = 1600;
#endif

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

TEST_CASE("a sink in any order needs no memory for the layers", "[engine][sink][memory][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    const auto peak = [&](double layer_height, std::uint64_t& layer_bytes) {
        const CountingMemory memory;
        const auto nothing = [](const LayerView&) noexcept {};
        Slicer slicer;
        const SliceInfo info = value_of(slicer.slice_to(LayerSink{.take = nothing, .order = SinkOrder::any}, view_of(ball),
                                                        uniform(layer_height), {.threads = 2, .memory = &memory}));
        layer_bytes = info.points * sizeof(Point) + info.contours * sizeof(Contour);
        CHECK(slicer.bytes() >= memory.held());
        slicer.reset();
        CHECK(memory.held() == 0);
        return memory.peak();
    };
    std::uint64_t few_bytes = 0;
    std::uint64_t many_bytes = 0;
    const std::size_t few = peak(0.02, few_bytes);
    const std::size_t many = peak(0.002, many_bytes);
    // Some bytes a plane are added, and the room that each thread makes for a layer.
    CHECK(many < few + (many_bytes - few_bytes) / 8);
}

TEST_CASE("what is put aside for an ascending sink ends at its window, and goes when the call ends",
          "[engine][sink][memory][threads]") {
    shapes::Soup needles;  // half a megabyte a layer, most of it contours of three points
    for (int i = 0; i < 5000; ++i) {
        const double x = 3 * (i % 70);
        const double y = 3 * (i / 70);
        shapes::append(needles, shapes::tetrahedron({x, y, 0}, {x + 2, y, 0}, {x, y + 2, 0}, {x, y, needle_layers}));
    }
    const bool ends = GENERATE(false, true);
    const CountingMemory memory;
    OrderNote note;
    std::atomic<bool> ended{false};
    const auto take = [&](const LayerView& view) noexcept {
        if (view.index == 0) {
            // The other thread puts aside what it may: until it has worked no more for a while.
            for (double before = -1; cpu_ms() - before > 1; std::this_thread::sleep_for(std::chrono::milliseconds(300))) {
                before = cpu_ms();
            }
            ended = ends;
        }
        note(view);
    };
    const auto stop = [&]() noexcept { return ended.load(); };
    Slicer slicer;
    const auto info = slice_tuned(slicer, LayerSink{.take = take}, view_of(needles), uniform(1), {.band_planes = 400},
                                  {.threads = 2, .stop = stop, .memory = &memory});
    CHECK(code_of(info) == (ends ? std::optional(ErrorCode::cancelled) : std::nullopt));
    CHECK(note.next == (ends ? 1 : needle_layers));
    CHECK(note.in_order);
    CHECK(memory.peak() < 150'000'000);
}

TEST_CASE("a slow sink gets every layer, an ascending one in plane order by one thread at a time",
          "[engine][sink][threads]") {
    const std::int64_t band = GENERATE(0, 1, 5);
    // Hollow, so that contours have parents, and torn, so that there are stitches.
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    shapes::Soup hollow = shapes::joined({shapes::flipped(shapes::scaled(ball, {0.5, 0.5, 0.5})), ball});
    hollow.resize(hollow.size() - 9 * std::size_t{20});
    const SliceOptions options{.layer_height_mm = 0.1, .stitch_mm = 50};
    const SliceResult expected = sliced(hollow, options);
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
        const SliceInfo info = sliced_to(LayerSink{.take = slow, .order = order}, view_of(hollow), options, {.threads = 4},
                                         {.band_planes = band});
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
            const auto info = Slicer().slice_to(LayerSink{.take = end_at_ten, .order = order}, view_of(ball), uniform(0.02),
                                                {.threads = threads, .stop = stop});
            CHECK(code_of(info) == ErrorCode::cancelled);
            CHECK((order == SinkOrder::any || layers == 11));
            CHECK(layers < 900);
        }
    }
}

TEST_CASE("a sink may slice", "[engine][sink][executor][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const auto one_by_one = [](int workers, Callback<void()> body) noexcept {
        for (int i = 0; i < workers; ++i) {
            body();
        }
    };
    for (const bool has_executor : {false, true}) {
        for (const SinkOrder order : orders) {
            std::atomic<std::uint64_t> contours{0};
            const auto slicing = [&](const LayerView&) noexcept {
                Slicer slicer;
                SliceResult result;
                const auto info =
                    slice_tuned(slicer, result, view_of(box), uniform(0.05), {.band_planes = 3}, {.threads = 3});
                contours += info.ok() ? result.contours.size() : 0;
            };
            Context context{.threads = 4};
            if (has_executor) {
                context.executor = one_by_one;
                context.executor_threads = 4;
            }
            const SliceInfo info = sliced_to(LayerSink{.take = slicing, .order = order}, view_of(ball), uniform(0.25),
                                             context, {.band_planes = 2});
            CHECK(contours == 80 * info.layers);
        }
    }
}

Error refusal_of(const HostArrays& arrays, const Source& mesh, const SliceOptions& options, const Context& context = {}) {
    return error_of(Slicer().slice_to(arrays, mesh, options, context));
}

TEST_CASE("what does not fit is refused, and nothing beyond the capacities is written", "[engine][host][threads]") {
    const SliceOptions options{.layer_height_mm = 0.5, .stitch_mm = 50};
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        const SliceResult result = sliced(mesh, options);
        const ArraySizes enough{result.points.size(), result.contours.size(), result.layers.size(), result.stitches.size()};
        const auto check_refused = [&, &mesh = mesh](std::uint64_t ArraySizes::*array, std::uint64_t fewer,
                                                     const std::string& words) {
            for (const Number type : {Number::i32, Number::i64, Number::f32}) {
                ArraySizes sizes = enough;
                sizes.*array -= fewer;
                const GuardedArrays host(sizes, {.type = type});
                const Error error = refusal_of(host.arrays, view_of(mesh), options, {.threads = 3});
                CHECK(error.code == ErrorCode::result_too_large);
                CHECK_THAT(error.message, Catch::Contains(words));
                CHECK(host.guards_stand());
            }
        };
        INFO(mesh_name);
        for (const std::uint64_t fewer : {std::uint64_t{1}, enough.points / 2, enough.points}) {
            check_refused(&ArraySizes::points, fewer, std::to_string(enough.points));
        }
        check_refused(&ArraySizes::contours, 1, "");
        check_refused(&ArraySizes::layers, 1, "there is memory for " + std::to_string(enough.layers - 1));
        if (enough.stitches > 1) {
            check_refused(&ArraySizes::stitches, 1, "");
        }
        GuardedArrays host(result);
        host.arrays.stitches = {};  // they are only counted
        require_same(sliced_to(host.arrays, view_of(mesh), options), result.info);
        host.require_hold(result);
    }
}

TEST_CASE("a scale that the type cannot take is refused before anything is cut", "[engine][host]") {
    const shapes::Soup box = shapes::box({-1, -1, 0}, {100, 7, 4});
    const SliceOptions options = at_heights({2});  // 200 units at most
    const auto code = [&](Number type, double scale) {
        const GuardedArrays host({8, 1, 1}, {.type = type, .scale = scale});
        const auto code = code_of(Slicer().slice_to(host.arrays, view_of(box), options));
        CHECK(host.guards_stand());
        return std::string(!code ? "fits" : *code == ErrorCode::invalid_argument ? "refused" : "?");
    };
    std::vector<std::tuple<Number, double, const char*>> cases = {
        {Number::i32, 1e7, "fits"},    {Number::i32, 2e7, "refused"},   {Number::i32, 0.5, "refused"},
        {Number::i64, 4e15, "fits"},   {Number::i64, 1e16, "refused"},  // beyond 2^53
        {Number::i64, 1.5, "refused"}, {Number::f32, 1e30, "fits"},     {Number::f32, 1e37, "refused"},
        {Number::f64, 1e300, "fits"},  {Number::f64, 1e307, "refused"}, {static_cast<Number>(7), 1, "refused"}};
    for (const double scale : {0.0, -1.0, HUGE_VAL, std::nan("")}) {
        cases.emplace_back(Number::i32, scale, "refused");
        cases.emplace_back(Number::f64, scale, "refused");
    }
    for (const auto& [type, scale, expected] : cases) {
        CHECK(code(type, scale) == expected);
    }
    SliceOptions offset = options;  // counts, too: 200 units fit, 300 do not
    offset.region.fill_rule = FillRule::non_zero;
    offset.region.offset_mm = 50;
    const GuardedArrays host({8, 1, 1}, {.scale = 1e7});
    CHECK(refusal_of(host.arrays, view_of(box), offset).code == ErrorCode::invalid_argument);
}

TEST_CASE("parts and faces that do not fit are refused before progress shows the end", "[engine][host][parts][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {10, 10, 4});
    Part parts[2];
    parts[0].mesh = parts[1].mesh = view_of(box);
    SliceOptions faces = uniform(1);
    faces.content = LayerContent::upward_faces;
    std::vector<Layer> layers(100);
    double reached = -1;
    const auto note = [&](double done) noexcept { reached = done; };
    for (const HostArrays& arrays : {HostArrays{}, HostArrays{.layers = layers}}) {
        const double most = arrays.layers.empty() ? 0.4 : 1;  // with too few layers, before anything is cut
        CHECK(refusal_of(arrays, parts, uniform(1), {.progress = note}).code == ErrorCode::result_too_large);
        CHECK(std::exchange(reached, -1) < most);
        CHECK(refusal_of(arrays, view_of(box), faces, {.progress = note}).code == ErrorCode::result_too_large);
        CHECK(std::exchange(reached, -1) < most);
    }
}

TEST_CASE("arrays that contradict themselves are refused, and a layer without contours needs none",
          "[engine][host][errors]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const SliceOptions options = at_heights({2});
    using Change = void (*)(HostArrays&);
    for (const Change change : std::initializer_list<Change>{[](HostArrays& it) { it.points = nullptr; },
                                                             [](HostArrays& it) {
                                                                 it.contours = {static_cast<Contour*>(nullptr), 1};
                                                             },
                                                             [](HostArrays& it) {
                                                                 it.layers = {static_cast<Layer*>(nullptr), 1};
                                                             },
                                                             [](HostArrays& it) {
                                                                 it.stitches = {static_cast<Stitch*>(nullptr), 1};
                                                             },
                                                             [](HostArrays& it) { it.point_stride = 15; },
                                                             [](HostArrays& it) { it.point_type = Number::u32; }}) {
        GuardedArrays host({8, 1, 1}, {.type = Number::i64});
        change(host.arrays);
        CHECK(refusal_of(host.arrays, view_of(box), options).code == ErrorCode::invalid_argument);
    }
    CHECK(refusal_of({}, view_of(box), options).code == ErrorCode::result_too_large);
    CHECK(refusal_of({}, MeshView{}, options).code == ErrorCode::empty_mesh);
    CHECK(code_of(Slicer().outline(MeshView{}, options)) == ErrorCode::empty_mesh);
    for (const Number type : {Number::i32, Number::f64}) {
        Layer layer;
        const HostArrays arrays{.point_type = type, .layers = {&layer, 1}};
        CHECK(sliced_to(arrays, view_of(box), at_heights({9})).points == 0);
        CHECK(layer.plane_mm == 9);
    }
}

// So many planes that the output outweighs what two threads hold in their bands, which depends on their pace.
TEST_CASE("a slice into the host's arrays allocates nothing of their size", "[engine][host][memory][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    const SliceOptions options = uniform(0.0005);
    const SliceInfo outline = value_of(Slicer().outline(view_of(ball), options));
    for (const Number type : {Number::i32, Number::f64}) {
        const CountingMemory memory;
        const GuardedArrays host({outline.segments, outline.layers, outline.layers}, {.type = type});
        const SliceInfo info = sliced_to(host.arrays, view_of(ball), options, {.threads = 2, .memory = &memory});
        CHECK(memory.held() == 0);
        CHECK(memory.peak() < info.points * sizeof(Point) / 2);
    }
}

}  // namespace
