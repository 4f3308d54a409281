// What control.hpp promises: threads, memory, stop and progress.
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
#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"
#include "input/files.hpp"
#include "lamella/io.hpp"

using lamella::Control;
using lamella::ErrorCode;

namespace {

/// Every call that takes a Control, by name: what it fails with, or nothing.
using Code = std::optional<ErrorCode>;
struct ControlledCall {
    const char* name;
    std::function<Code(const Control&)> run;
};

template <class Outcome>
Code code_of(const Outcome& outcome) {
    return outcome.ok() ? Code() : outcome.error().code;
}

class Calls {
public:
    Calls()
        : soup_(shapes::octasphere({0, 0, 0}, 5, 4)),
          result_(sliced(soup_, uniform(0.1))),
          prepared_(prepare(view_of(soup_)).value()),
          file_(folder_.write("a.stl", lamella::input_test::binary_stl(lamella::input_test::numbered_facets(5000)))) {}

    std::vector<ControlledCall> all() const {
        const lamella::MeshView mesh = view_of(soup_);
        return {
            {"slice", [=](const Control& c) { return code_of(slice(mesh, with(c, uniform(0.1)))); }},
            {"prepare", [=](const Control& c) { return code_of(prepare(mesh, with(c, lamella::PrepareOptions{}))); }},
            {"slice of a prepared mesh",
             [=, this](const Control& c) { return code_of(slice(prepared_, with(c, uniform(0.1)))); }},
            {"assemble", [](const Control& c) { return code_of(lamella::assemble({}, c)); }},
            {"inspect",
             [=](const Control& c) { return code_of(lamella::inspect(mesh, with(c, lamella::InspectOptions{}))); }},
            {"check", [=](const Control& c) { return code_of(lamella::check(mesh, with(c, lamella::CheckOptions{}))); }},
            {"weld", [=](const Control& c) { return code_of(lamella::weld(mesh, with(c, lamella::WeldOptions{}))); }},
            {"make_ledger", [=, this](const Control& c) { return code_of(make_ledger(mesh, result_, c)); }},
            {"certify_volume", [=, this](const Control& c) { return code_of(certify_volume(mesh, result_, c)); }},
            {"find_crossings", [this](const Control& c) { return code_of(find_crossings(result_, c)); }},
            {"read_mesh", [this](const Control& c) { return code_of(read_mesh(file_, with(c, lamella::ReadOptions{}))); }},
            {"write_svg",
             [this](const Control& c) {
                 return code_of(write_svg(result_, folder_ / "a.svg", with(c, lamella::SvgOptions{})));
             }},
        };
    }

private:
    template <class Options>
    static Options with(const Control& control, Options options) {
        options.control = control;
        return options;
    }

    TempFolder folder_;
    shapes::Soup soup_;
    lamella::SliceResult result_;
    lamella::PreparedMesh prepared_;
    std::filesystem::path file_;
};

/// Says yes from the ask number `from` on.
struct LateStop {
    std::uint64_t from;
    std::atomic<std::uint64_t> asked{0};

    lamella::StopCheck check() {
        return {[](void* context) noexcept {
                    auto* self = static_cast<LateStop*>(context);
                    return ++self->asked >= self->from;
                },
                this};
    }
};

}  // namespace

TEST_CASE("negative threads are an invalid argument in every call", "[engine][control]") {
    const Calls calls;
    for (const ControlledCall& call : calls.all()) {
        INFO(call.name);
        CHECK(call.run({.threads = -1}) == ErrorCode::invalid_argument);
        CHECK(call.run({.threads = 1}) == Code());
    }
}

TEST_CASE("every call ends when it is asked to", "[engine][control]") {
    const Calls calls;
    for (const ControlledCall& call : calls.all()) {
        LateStop at_once{1};
        INFO(call.name);
        CHECK(call.run({.threads = 2, .stop = at_once.check()}) == ErrorCode::cancelled);
        CHECK(at_once.asked <= 2);
    }
}

TEST_CASE("a host is asked once in an interval, and one yes of its is one for all threads", "[engine][control][threads]") {
    LateStop host{2};
    lamella::PacedStop paced(host.check());
    CHECK_FALSE(paced.check().stop_requested());
    bool answered = false;
    std::thread([&] { answered = paced.check().stop_requested(); }).join();  // another thread's first look
    CHECK(answered);
    CHECK(host.asked == 2);
    for (int look = 0; look < 3; ++look) {
        CHECK(paced.check().stop_requested());
    }
    CHECK(host.asked == 2);
    host.from = 9;
    const auto until = std::chrono::steady_clock::now() + lamella::PacedStop::interval;
    paced.follow(host.check());
    CHECK_FALSE(paced.check().stop_requested());
    CHECK_FALSE(paced.check().stop_requested());
    CHECK((host.asked == 3 || std::chrono::steady_clock::now() > until));
}

TEST_CASE("the first yes ends a slice, whenever it comes", "[engine][control][cancel][threads]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 5, 5);
    lamella::SliceOptions options = uniform(0.001);
    options.control.threads = 1;
    LateStop never{~std::uint64_t{0}};
    options.control.stop = never.check();
    (void)sliced(soup, options);
    REQUIRE(never.asked >= 4);
    for (std::uint64_t from = 1; from <= std::min<std::uint64_t>(never.asked / 2, 40); ++from) {
        LateStop stop{from};
        options.control.stop = stop.check();
        REQUIRE(failure_of(view_of(soup), options).code == ErrorCode::cancelled);
        REQUIRE(stop.asked == from);
    }
}

TEST_CASE("progress never falls, comes from one thread at a time and ends at 1", "[engine][control][threads]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    lamella::SliceOptions options = uniform(0.01);
    options.control.threads = GENERATE(1, 4);
    options.tuning.band_planes = GENERATE(0, 3);
    options.plan.spacing = GENERATE(lamella::UniformLayers{0.01}, lamella::UniformLayers{100, 1000.0});  // planes, and none
    std::atomic<int> inside = 0;
    std::atomic<bool> together = false;
    std::vector<double> seen;
    const auto note = [&](double fraction) noexcept {
        together = together || ++inside > 1;
        seen.push_back(fraction);
        std::this_thread::yield();
        --inside;
    };
    options.control.progress = lamella::Progress::to(note);
    (void)sliced(soup, options);
    CHECK_FALSE(together);
    REQUIRE_FALSE(seen.empty());
    CHECK(std::adjacent_find(seen.begin(), seen.end(), std::greater_equal<>()) == seen.end());
    CHECK(seen.front() >= 0);
    CHECK(seen.back() == 1);
}

TEST_CASE("a call that fails does not report 1", "[engine][control]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    lamella::SliceOptions options = uniform(0.001);  // tens of milliseconds, which is long enough to be asked
    double last = 0;
    std::atomic<bool> stop = false;
    const auto note = [&](double fraction) noexcept {
        last = fraction;
        stop = fraction > 0.5;
    };
    options.control.threads = 1;
    options.tuning.band_planes = 1;
    options.control.progress = lamella::Progress::to(note);
    options.control.stop = lamella::StopCheck::when(stop);
    CHECK(failure_of(view_of(soup), options).code == ErrorCode::cancelled);
    CHECK((last > 0.5 && last < 1));
}

TEST_CASE("a slow progress sink holds up no other thread", "[engine][control][threads]") {
    // The sink returns only once all planes but those of its own band are through: a lock that it held would end in a hang.
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    lamella::SliceOptions options = uniform(0.01);
    options.control.threads = 2;
    options.tuning.band_planes = 20;
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
    options.control.progress = lamella::Progress::to(wait);
    REQUIRE(slice_to(lamella::LayerSink::to(count, lamella::SinkOrder::any), view_of(soup), options).ok());
    CHECK(meanwhile >= 40);
}

TEST_CASE("a result's arrays and its scratch come from the host's memory and go back", "[engine][control][memory]") {
    CountingMemory memory;
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    {
        lamella::SliceOptions options = uniform(0.01);
        options.control.memory = &memory;
        const lamella::SliceResult result = sliced(soup, options);
        const std::size_t bytes = result.points.size() * sizeof(lamella::Point) +
                                  result.contours.size() * sizeof(lamella::Contour) +
                                  result.layers.size() * sizeof(lamella::Layer);
        CHECK(memory.held() >= bytes);
        CHECK(memory.peak() > memory.held());
    }
    CHECK(memory.held() == 0);
    {
        const auto welded = lamella::weld(view_of(soup), {.control = {.memory = &memory}});
        REQUIRE(welded.ok());
        CHECK(memory.held() >= welded->coordinates.size() + 4 * welded->indices.size());
    }
    CHECK(memory.held() == 0);
    {
        lamella::Workspace workspace;
        lamella::SliceResult result(&memory);
        lamella::SliceOptions options = uniform(0.1);
        options.control.memory = &memory;
        REQUIRE(slice(view_of(soup), options, workspace, result).ok());
        const std::size_t with_scratch = memory.held();
        workspace.reset();
        CHECK(memory.held() < with_scratch);
        REQUIRE(slice(view_of(soup), options, workspace, result).ok());
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
    STATIC_REQUIRE(noexcept(validate(result)));
    STATIC_REQUIRE(noexcept(make_verdict(check)));
    STATIC_REQUIRE(noexcept(make_report_json(result)));
    STATIC_REQUIRE(noexcept(lamella::format_names()));
    STATIC_REQUIRE(noexcept(lamella::Workspace()));
    STATIC_REQUIRE_FALSE(noexcept(std::declval<lamella::Array<int>&>().resize_discarding(1)));
}
