// The host's threads: whatever they do within what context.hpp asks of them, every call ends with the same answer.
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/everywhere.hpp"
#include "lamella/io.hpp"

using lamella::Callback;
using lamella::Context;

namespace {

using Body = Callback<void()>;

/// Shells that overlap, in enough planes for several bands.
const shapes::Soup& closed() {
    static const shapes::Soup soup =
        shapes::joined({shapes::octasphere({0, 0, 0}, 10, 5), shapes::octasphere({1, 2, 3}, 9, 5),
                        shapes::box({5, 5, -9}, {15, 15, 9}), shapes::random_tetrahedra(7, 40, 9)});
    return soup;
}

/// The answers of every call that takes threads, as text. Audits do not depend on the order of triangles.
std::string answers(const Context& context, const shapes::Soup& audited = closed()) {
    static const shapes::Soup open = shapes::without(closed(), 100, 3);
    static const lamella::SliceResult of_closed = sliced(closed(), uniform(0.05), {.threads = 1});
    static const lamella::SliceResult of_open = sliced(open, uniform(0.05), {.threads = 1});
    require_at_every_destination(of_open, view_of(open), uniform(0.05), {context, {.band_planes = 7}});
    const lamella::Audit found = value_of(audit(of_closed, view_of(audited), {}, context));
    CHECK(found.volume->verdict == lamella::VolumeVerdict::holds);
    const lamella::MeshCheck counts = value_of(check(view_of(open), {.counts_only = true}, context));
    std::string report = value_of(make_report_json(of_closed, {.audit = &found}));
    const std::size_t time = report.find("\"report\": ");  // that writing it took
    report.erase(time, report.find('\n', time) - time);
    return report + std::to_string(counts.boundary_edges) + " " + std::to_string(counts.shell_count) +
           value_of(make_check_json(value_of(check(view_of(open), {}, context))));
}

/// The same by one thread.
const std::string& expected() {
    static const std::string text = answers({.threads = 1});
    return text;
}

/// Calls body() on so many threads of its own.
void run_threads(int count, const Body& body) noexcept {
    std::vector<std::thread> threads;
    for (int i = 0; i < count; ++i) {
        threads.emplace_back([&] { body(); });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
}

}  // namespace

TEST_CASE("answers do not depend on the number of threads, nor audits on the order of triangles",
          "[engine][executor][threads]") {
    const int threads = GENERATE(0, 2, 3);
    CHECK(answers({.threads = threads}) == expected());
    CHECK(answers({.threads = threads}, shapes::shuffled(closed(), 5)) == expected());
}

TEST_CASE("an executor may run as many bodies as asked for, or fewer, or more, on threads or one by one, some of them late",
          "[engine][executor][threads]") {
    int change = 0;
    const auto on_threads = [&](int workers, const Body& body) noexcept { run_threads(workers + change, body); };
    for (const int other : {-3, -1, 0, 1, 9}) {
        change = other;
        CHECK(answers({.executor = on_threads, .executor_threads = 4}) == expected());
    }
    int bodies = 0;
    const auto one_by_one = [&](int, const Body& body) noexcept {
        for (int i = 0; i < bodies; ++i) {
            body();
        }
    };
    for (const int other : {0, 4}) {
        bodies = other;
        CHECK(answers({.executor = one_by_one, .executor_threads = 4}) == expected());
    }
    const auto one_late = [](int workers, const Body& body) noexcept {
        std::thread late([&] {
            std::this_thread::sleep_for(std::chrono::microseconds(200));
            body();
        });
        for (int i = 1; i < workers; ++i) {
            body();
        }
        late.join();
    };
    CHECK(answers({.executor = one_late, .executor_threads = 3}) == expected());
}

TEST_CASE("the number of threads may differ from the executor's", "[engine][executor]") {
    int most = 0;
    const auto pool = [&most](int workers, const Body& body) noexcept {
        most = std::max(most, workers);
        body();
    };
    CHECK(answers({.threads = 5, .executor = pool, .executor_threads = GENERATE(-1, 0, 1, 2, 64)}) == expected());
    CHECK(most == 5);
}

TEST_CASE("a call may be made from within a task of another one's executor", "[engine][executor][threads]") {
    std::atomic<int> nested = 0;
    std::string inner;
    const auto pool = [&](int, const Body& body) noexcept {
        if (nested++ == 0) {
            inner = answers({});
        }
        body();
    };
    CHECK(answers({.executor = pool, .executor_threads = 2}) == expected());
    CHECK(inner == expected());
}
