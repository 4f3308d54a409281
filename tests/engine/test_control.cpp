// The promises of context.hpp: threads, memory, stop and progress.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "base/parallel.hpp"
#include "engine/calls.hpp"
#include "engine/counting_memory.hpp"
#include "input/files.hpp"
#include "lamella/io.hpp"

using lamella::ErrorCode;

namespace {

/// Says yes from the ask number `from` on.
struct LateStop {
    std::uint64_t from;
    std::atomic<std::uint64_t> asked{0};

    bool operator()() noexcept { return ++asked >= from; }
};

}  // namespace

TEST_CASE("every call refuses negative threads, ends when it is asked to, and shows progress up to 1", "[engine][control]") {
    const TempFolder folder;
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 5, 4);
    using namespace lamella::input_test;
    ContextCalls calls(view_of(soup), folder.write("a.stl", binary_stl(numbered_facets(5000))), 0.1);
    for (const ContextCall& call : calls.all()) {
        INFO(call.name);
        CHECK(call.run({.threads = -1}) == ErrorCode::invalid_argument);
        double last = 0;
        const auto note = [&last](double fraction) noexcept { last = fraction > last ? fraction : -1; };
        CHECK(call.run({.threads = 1, .progress = note}) == std::nullopt);
        CHECK(last == (call.shows_progress ? 1 : 0));
        LateStop at_once{1};
        CHECK(call.run({.threads = 2, .stop = at_once}) == ErrorCode::cancelled);
        CHECK(at_once.asked <= 2);
    }
    CHECK(code_of(lamella::assemble({}, {.threads = -1})) == ErrorCode::invalid_argument);
    LateStop at_once{1};
    CHECK(code_of(lamella::assemble({}, {.stop = at_once})) == ErrorCode::cancelled);
}

TEST_CASE("a host is asked once in an interval, and one yes of its is one for all threads", "[engine][control][threads]") {
    LateStop host{2};
    lamella::PacedStop paced(host);
    CHECK_FALSE(paced.check()());
    bool answered = false;
    std::thread([&] { answered = paced.check()(); }).join();  // another thread's first look
    CHECK(answered);
    CHECK(host.asked == 2);
    for (int look = 0; look < 3; ++look) {
        CHECK(paced.check()());
    }
    CHECK(host.asked == 2);
    host.from = 9;
    const auto until = std::chrono::steady_clock::now() + lamella::PacedStop::interval;
    paced.follow(host);
    CHECK_FALSE(paced.check()());
    CHECK_FALSE(paced.check()());
    CHECK((host.asked == 3 || std::chrono::steady_clock::now() > until));
}

TEST_CASE("the first yes ends a slice, whenever it comes", "[engine][control][cancel][threads]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 5, 5);
    const lamella::SliceOptions options = uniform(0.001);
    LateStop never{~std::uint64_t{0}};
    (void)sliced(soup, options, {.threads = 1, .stop = never});
    REQUIRE(never.asked >= 4);
    for (std::uint64_t from = 1; from <= std::min<std::uint64_t>(never.asked / 2, 40); ++from) {
        LateStop stop{from};
        REQUIRE(failure_of(view_of(soup), options, {.threads = 1, .stop = stop}).code == ErrorCode::cancelled);
        REQUIRE(stop.asked == from);
    }
}

TEST_CASE("progress never falls, comes from one thread at a time and ends at 1", "[engine][control][threads]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
    lamella::SliceOptions options = uniform(0.01);
    const int threads = GENERATE(1, 3);
    const std::int64_t band_planes = GENERATE(0, 20);
    if (GENERATE(false, true)) {  // no planes
        options.layer_height_mm = 100;
        options.planes.first_height_mm = 1000;
    }
    std::atomic<int> inside = 0;
    std::atomic<bool> together = false;
    std::vector<double> seen;
    const auto note = [&](double fraction) noexcept {
        together = together || ++inside > 1;
        seen.push_back(fraction);
        std::this_thread::yield();
        --inside;
    };
    const lamella::SliceResult result =
        sliced(soup, options, {.threads = threads, .progress = note}, {.band_planes = band_planes});
    CHECK_FALSE(together);
    REQUIRE_FALSE(seen.empty());
    CHECK(std::adjacent_find(seen.begin(), seen.end(), std::greater_equal<>()) == seen.end());
    CHECK(seen.front() >= 0);
    CHECK(seen.back() == 1);
    // Bands that finish out of order are reported together; at most two a thread run ahead, which bounds their number.
    const bool many_bands = band_planes == 20 && result.layers.size() > 1000;
    CHECK((!many_bands || seen.size() >= 100 / (2 * static_cast<std::size_t>(threads) + 1)));
}

TEST_CASE("a call that fails does not report 1", "[engine][control]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    const lamella::SliceOptions options = uniform(0.001);  // tens of milliseconds, which is long enough to be asked
    double last = 0;
    std::atomic<bool> stop = false;
    const auto note = [&](double fraction) noexcept {
        last = fraction;
        stop = fraction > 0.5;
    };
    const auto ask = [&]() noexcept { return stop.load(); };
    lamella::Slicer slicer;
    lamella::SliceResult result;
    const auto info = slice_tuned(slicer, result, view_of(soup), options, {.band_planes = 1},
                                  {.threads = 1, .stop = ask, .progress = note});
    CHECK(code_of(info) == ErrorCode::cancelled);
    CHECK((last > 0.5 && last < 1));
}

TEST_CASE("a slow progress sink holds up no other thread", "[engine][control][threads]") {
    // The sink returns only once all planes but those of its own band are through: a lock that it held would end in a hang.
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    std::atomic<std::uint64_t> layers = 0;
    const auto count = [&](const lamella::LayerView&) noexcept { ++layers; };
    std::atomic<bool> first = true;
    std::uint64_t meanwhile = 0;
    const auto wait = [&](double) noexcept {
        if (!first.exchange(false)) {
            return;
        }
        const std::uint64_t before = layers;
        for (int i = 0; i < 2000 && layers < before + 40; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        meanwhile = layers - before;
    };
    sliced_to(lamella::LayerSink{.take = count, .order = lamella::SinkOrder::any}, view_of(soup), uniform(0.01),
              {.threads = 2, .progress = wait}, {.band_planes = 20});
    CHECK(meanwhile >= 40);
}

TEST_CASE("a result's arrays and its scratch come from the host's memory and go back", "[engine][control][memory]") {
    CountingMemory memory;
    {
        const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
        const lamella::SliceResult result = sliced(soup, uniform(0.01), {.memory = &memory});
        const std::size_t bytes = result.points.size() * sizeof(lamella::Point) +
                                  result.contours.size() * sizeof(lamella::Contour) +
                                  result.layers.size() * sizeof(lamella::Layer);
        CHECK(memory.held() >= bytes);
        CHECK(memory.peak() > memory.held());
    }
    CHECK(memory.held() == 0);
}

TEST_CASE("a size that memory does not hold leaves an array as it was", "[engine][control][memory]") {
    CountingMemory memory(1000);
    lamella::Array<int> array(&memory);
    array.resize_discarding(10);
    array[9] = 7;
    CHECK_THROWS_AS(array.resize_discarding(1000), std::bad_alloc);
    CHECK(array.size() == 10);
    CHECK(array[9] == 7);
}

TEST_CASE("what is documented as noexcept is", "[engine][control]") {
    const lamella::MeshView mesh;
    const lamella::SliceResult result;
    const lamella::MeshCheck check;
    STATIC_REQUIRE(noexcept(slice(mesh)));
    STATIC_REQUIRE(noexcept(lamella::assemble({})));
    STATIC_REQUIRE(noexcept(audit(result)));
    STATIC_REQUIRE(noexcept(lamella::make_verdict(check)));
    STATIC_REQUIRE(noexcept(lamella::make_report_json(result)));
    STATIC_REQUIRE(noexcept(lamella::format_names()));
    STATIC_REQUIRE(noexcept(lamella::Slicer()));
    STATIC_REQUIRE_FALSE(noexcept(std::declval<lamella::Array<int>&>().resize_discarding(1)));
}
