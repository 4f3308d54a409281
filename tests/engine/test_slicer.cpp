// Slicers and prepared meshes: what they hold, what they give back, and what they refuse. That they slice as a mesh alone is
// sliced: test_sources.cpp. And the bounds of options, and the counters of C.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "base/scratch_memory.hpp"
#include "base/words.hpp"
#include "c/call.hpp"
#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"
#include "engine/slicing.hpp"
#include "options/option_words.hpp"
#include "slicing/buckets/prepared_source.hpp"

using namespace lamella;

namespace {

void slice_with(Slicer& slicer, const shapes::Soup& soup, const SliceOptions& options, const Context& context) {
    REQUIRE(slicer.slice(view_of(soup), options, context).ok());
}

template <class Result>
concept reaches_into_temporaries = requires(Result result) {
    std::move(result)->layers;
};

shapes::Soup plate() {
    return shapes::box({0, 0, 0}, {20, 20, 2});
}

shapes::Soup large() {
    return shapes::octasphere({0, 0, 0}, 10, 7);
}

TEST_CASE("a result made in the head of a loop lives as long as the loop", "[engine][slicer]") {
    const shapes::Soup soup = plate();
    Slicer slicer;
    double volume = 0;
    for (const LayerView layer : *slicer.slice(view_of(soup), uniform(0.5))) {
        volume += 0.5 * layer.area_mm2();
    }
    CHECK(volume == 800);
    static_assert(std::is_same_v<decltype(*slicer.slice(view_of(soup))), SliceResult>);
    static_assert(std::is_same_v<decltype(slicer.slice(view_of(soup)).value()), SliceResult>);
    static_assert(!reaches_into_temporaries<Result<SliceResult>>);
}

TEST_CASE("options are held to the bounds and choices of their descriptions, and refused by name", "[engine][errors]") {
    const shapes::Soup soup = plate();
    std::string bounds;
    const auto check = [&]<class Option>(const std::string& name, auto set, Option, double least, bool exclusive,
                                         double special) {
        const auto is_refused = [&](auto value) {
            SliceOptions options{.region = {.fill_rule = FillRule::non_zero}};
            set(options, value);
            const auto sliced = slice(view_of(soup), options);
            return code_of(sliced) == ErrorCode::invalid_argument && sliced.error().message.starts_with(name + " ");
        };
        INFO(name);
        if constexpr (std::is_enum_v<Option>) {
            const auto end = detail::words_of(Option{}).size();
            CHECK((!is_refused(static_cast<Option>(end - 1)) && is_refused(static_cast<Option>(end))));
        } else if constexpr (std::is_same_v<Option, double> || std::is_same_v<Option, std::optional<double>>) {
            CHECK((is_refused(no_limit) && is_refused(-no_limit) && is_refused(std::nan(""))));
            CHECK((special == 0 || !is_refused(special)));
            if (least > -no_limit) {
                bounds += name + (exclusive ? " > " : " >= ") + exact_text(least) + "; ";
                CHECK(is_refused(least) == exclusive);
                CHECK((is_refused(std::nextafter(least, -no_limit)) && !is_refused(std::nextafter(least, no_limit))));
            } else {
                CHECK(!is_refused(-1.0));
            }
        }
    };
#define OPTION(kind, name, path, python, flag, least, exclusive, word, special, ...) \
    check(                                                                           \
        #name, [](SliceOptions& it, auto value) { it.path = value; }, SliceOptions().path, least, exclusive, special);
#include "options/options.inc"
    CHECK(bounds ==
          "layer_height_mm > 0; stitch_mm >= 0; grid_mm >= 0; closing_mm >= 0; miter_limit >= 1; "
          "simplify_mm >= 0; flag_closing_mm >= 0; ");
}

TEST_CASE("each counter of a slice has its own field of C's info, and none is left out", "[c]") {
    SliceInfo info;
    info.options.stitch_mm = 0.5;
    info.grid_doublings = 1;
    info.box = {{1, 2, 3}, {4, 5, 6}};
    info.layer_of = {7};
    info.copies = {{1, 0, {2, 2}}};
    std::uint64_t next = 1000;
#define COUNTER(name) info.name = ++next;
#include "options/counters.inc"
    CHECK(counters_of(info).size() == 3 + (&info.bands - &info.triangles));  // those of the plan and those in a row
    const lamella_info found = c::info_of(info);
    CHECK(counters_of(found) == counters_of(info));
    std::array<std::uint64_t, sizeof found / sizeof next> words{};
    std::memcpy(words.data(), &found, sizeof found);
    CHECK(std::count(words.begin(), words.end(), 0U) == 0);  // a field that is forgotten stays 0
}

TEST_CASE("a slicer says what it holds of the host's memory", "[engine][slicer]") {
    CountingMemory memory;
    Slicer slicer;
    CHECK(slicer.bytes() == 0);
    slice_with(slicer, large(), uniform(0.1), {.threads = GENERATE(1, 3), .memory = &memory});
    for (int trims = 0; trims < 2; ++trims) {
        CHECK(slicer.bytes() >= memory.held());
        CHECK(slicer.bytes() <= memory.held() + 65536);
        slicer.trim();
    }
    slicer.reset();
    CHECK(slicer.bytes() == 0);
    CHECK(memory.held() == 0);
}

TEST_CASE("a slicer gives back what the last call did not need", "[engine][slicer]") {
    const Context context{.threads = GENERATE(1, 3)};
    const RegionRules rules = GENERATE(RegionRules{}, RegionRules{.fill_rule = FillRule::non_zero, .closing_mm = 0.1});
    Slicer fresh;
    slice_with(fresh, plate(), uniform(1), context);
    Slicer kept;
    slice_with(kept, large(), {.layer_height_mm = 0.02, .region = rules}, context);
    const std::size_t large_bytes = kept.bytes();
    kept.trim();
    CHECK(kept.bytes() > large_bytes / 2);  // all of it may be needed again
    slice_with(kept, plate(), uniform(1), context);
    CHECK(kept.bytes() > large_bytes / 2);
    kept.trim();
    CHECK(kept.bytes() < 2 * fresh.bytes() + 32768);
    CHECK(kept.bytes() < large_bytes / 8);
}

TEST_CASE("scratch is there before the first slice where it was made ready", "[engine][slicer][threads]") {
    const std::uint64_t triangles = GENERATE(0U, 1U, 30'000U, 2'000'000U);
    const CountingMemory memory;
    const Context context{.threads = 2, .memory = GENERATE_REF(static_cast<const Memory*>(nullptr), &memory)};
    Slicer ready;
    require_ok(ready.make_ready(triangles, context));
    CHECK(ready.bytes() >= 48 * std::min<std::uint64_t>(triangles, 666'666));
    CHECK(memory.held() >= (context.memory == nullptr ? 0 : 48 * std::min<std::uint64_t>(triangles, 666'666)));
    const std::size_t before = ready.bytes();
    Slicer fresh;
    slice_with(fresh, plate(), uniform(1), context);
    slice_with(ready, plate(), uniform(1), context);
    CHECK(ready.bytes() - before <= fresh.bytes() + fresh.bytes() / 8);  // small blocks are rounded up
    CHECK(code_of(ready.make_ready(~std::uint64_t{0}, context)) == ErrorCode::out_of_memory);
}

TEST_CASE("small blocks of scratch share pages, serve again and are given back", "[engine][slicer]") {
    const auto take_all = [](ScratchMemory& scratch) {
        struct Block {
            std::byte* begin;
            std::size_t bytes;
        };
        constexpr std::size_t threads = 4;
        std::array<std::vector<Block>, threads> taken;
        std::vector<std::thread> pool;
        for (std::size_t t = 0; t < threads; ++t) {
            pool.emplace_back([&scratch, &own = taken[t], t] {
                std::mt19937_64 random(t);
                for (int i = 0; i < 600; ++i) {
                    const std::size_t bytes = std::size_t{1} << random() % 18;
                    own.push_back({static_cast<std::byte*>(scratch.allocate(bytes, 64)), bytes});
                    std::memset(own.back().begin, static_cast<int>(own.size() % 251), bytes);
                }
            });
        }
        std::for_each(pool.begin(), pool.end(), [](std::thread& thread) { thread.join(); });
        const std::size_t most = scratch.bytes();
        for (const auto& own : taken) {
            for (std::size_t i = 0; i < own.size(); ++i) {
                const auto mark = static_cast<std::byte>((i + 1) % 251);
                REQUIRE(std::all_of(own[i].begin, own[i].begin + own[i].bytes, [mark](std::byte b) { return b == mark; }));
                scratch.deallocate(own[i].begin, own[i].bytes, 64);
            }
        }
        return most;
    };
    CountingMemory host;
    ScratchMemory of_host(&host);
    const std::size_t taken = take_all(of_host);
    CHECK(taken == host.peak());
    CHECK((of_host.bytes() == 0 && host.held() == 0));
    ScratchMemory scratch(nullptr);
    void* const large = scratch.allocate(std::size_t{1} << 23, 64);  // from here on blocks are shared
    void* const small = scratch.allocate(64, 64);
    const std::size_t most = take_all(scratch);
    CHECK(take_all(scratch) < most + most / 4);
    scratch.deallocate(small, 64, 64);
    scratch.deallocate(large, std::size_t{1} << 23, 64);
    CHECK(scratch.bytes() == 0);
}

TEST_CASE("a slicer gives back the scratch of regions after a call that made none", "[engine][slicer]") {
    const Context context{.threads = 1};  // of several threads not all need come to work
    const SliceOptions regions{.layer_height_mm = 0.1, .region = {.fill_rule = FillRule::non_zero, .closing_mm = 0.1}};
    Slicer fresh;
    slice_with(fresh, large(), uniform(0.1), context);
    Slicer kept;
    slice_with(kept, large(), regions, context);
    slice_with(kept, large(), uniform(0.1), context);
    CHECK(kept.bytes() > fresh.bytes() + 65536);
    kept.trim();
    CHECK(kept.bytes() < fresh.bytes());
}

TEST_CASE("a small slice is done by the calling thread alone", "[engine][slicer][executor]") {
    int runs = 0;
    const auto pool = [&runs](int, Callback<void()> body) noexcept {
        ++runs;
        body();
    };
    const SliceOptions options = uniform(GENERATE(2.0, 0.1));
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 1, 2);
    const SliceResult pooled = sliced(soup, options, {.executor = pool, .executor_threads = 8});
    CHECK(pooled.hash() == sliced(soup, options).hash());
    CHECK(runs == 0);
}

TEST_CASE("a prepared mesh is sliced on its own grid and in its own frame", "[engine][prepare]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 6, 8});
    SliceOptions options = at_heights({1, 3});
    options.frame.transform = Transform::from_normal(1, 0, 0);
    const PreparedMesh made = value_of(prepare(view_of(soup), options.frame));
    CHECK(made.frame() == options.frame);
    SliceOptions left_out = options;
    left_out.frame = {};
    require_same(sliced(made, left_out), sliced(soup, options));

    SliceOptions other = options;
    other.frame.grid_mm = 0.25;
    CHECK(failure_of(made, other).code == ErrorCode::invalid_argument);
    other = options;
    other.frame.transform = Transform::scale(2);
    CHECK(failure_of(made, other).code == ErrorCode::invalid_argument);
}

TEST_CASE("a mesh that no grid holds cannot be prepared; of one that is empty slicing says so", "[engine][prepare]") {
    const auto failure = [](const MeshView& mesh, const Frame& frame = {}, const Context& context = {}) {
        return error_of(prepare(mesh, frame, context));
    };
    shapes::Soup soup = shapes::box({0, 0, 0}, {4, 6, 8});
    for (const Frame& frame : {Frame{}, Frame{.grid_mm = 1e3}}) {  // on the coarse grid the box collapses
        const MeshView mesh = frame.grid_mm == 0 ? MeshView{} : view_of(soup);
        CHECK(failure_of(value_of(prepare(mesh, frame)), {.frame = frame}).message ==
              failure_of(mesh, {.frame = frame}).message);
    }
    CHECK(failure(view_of(soup), {.grid_mm = 1e-12}).code == ErrorCode::bad_coordinate);
    CHECK(failure(view_of(soup), {}, {.threads = -1}).code == ErrorCode::invalid_argument);
    soup[5 * 9 + 4] = std::numeric_limits<double>::quiet_NaN();
    CHECK(failure(view_of(soup)).triangle == 5);
    shapes::Indexed indexed = shapes::indexed(shapes::box({0, 0, 0}, {4, 6, 8}));
    indexed.indices[7] = 1000;
    CHECK(failure(indexed.view()).triangle == 2);
}

TEST_CASE("a prepared mesh takes 13 bytes a triangle of the host's memory", "[engine][prepare]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
    const std::size_t triangles = soup.size() / 9;
    CountingMemory memory;
    {
        const PreparedMesh made = value_of(prepare(view_of(soup), {}, {.memory = &memory}));
        CHECK(memory.held() >= 12 * triangles);
        CHECK(memory.held() <= 13 * triangles);
        CHECK(made.bytes() >= memory.held());
        CHECK(made.bytes() <= memory.held() + 4096);
    }
    CHECK(memory.held() == 0);
}

TEST_CASE("a plane reads little more than the triangles that it cuts", "[engine][prepare][bucket]") {
    // Small triangles everywhere, and among every hundred of them one taller than half the mesh, in any order.
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(0, 100);
    std::vector<float> soup;
    for (int t = 0; t < 200'000; ++t) {
        const float x = place(random);
        const float z = place(random) / (t % 100 == 0 ? 2 : 1);
        soup.insert(soup.end(), {x, 0, z, x + 1, 0, z, x, 1, z + (t % 100 == 0 ? 100.5F : 0.05F)});
    }
    const PreparedMesh made = value_of(prepare(view_of(soup)));
    const detail::PreparedImpl& prepared = *Source(made).prepared();
    PlaneSet planes(nullptr);
    planes.build({.heights_mm = {{50.1}}}, {}, prepared.frame, 1 << 20);
    Buckets buckets(nullptr);
    const Parallel parallel({.threads = 1});
    PreparedSource(prepared, {parallel, planes, buckets, instruction_set()}).count(prepared.frame.unit.mm);
    CHECK(buckets.segment_count >= 2000);
    CHECK(buckets.touched.size() * 64 <= 2 * buckets.segment_count);
}

}  // namespace
