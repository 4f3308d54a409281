// The host's threads: whatever they do within what context.hpp asks of them, every call ends with the same answer.
#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/everywhere.hpp"
#include "lamella/io/check_report.hpp"

using lamella::Context;

namespace {

/// Shells that overlap and a hole, in enough planes for several bands.
const shapes::Soup& parts() {
    static const shapes::Soup soup = [] {
        shapes::Soup all = shapes::joined({shapes::octasphere({0, 0, 0}, 10, 5), shapes::box({5, 5, -9}, {15, 15, 9}),
                                           shapes::random_tetrahedra(7, 40, 9)});
        all.erase(all.end() - 9 * 3, all.end());
        return all;
    }();
    return soup;
}

/// The answers of every call that takes threads, as text.
std::string answers(const Context& context) {
    const lamella::SliceOptions options = uniform(0.05);
    const Way way{context, {.band_planes = 7}};
    const lamella::MeshView mesh = view_of(parts());
    const lamella::SliceResult result = sliced(mesh, options, way.context, way.tuning);
    require_at_every_destination(result, mesh, options, way);
    const lamella::Audit audited = value_of(audit(result, mesh, {}, context));
    const lamella::MeshCheck counts = value_of(check(mesh, {.counts_only = true}, context));
    return std::to_string(result.hash()) + " " + std::to_string(audited.ledger->between) + " " +
           std::to_string(audited.volume->mesh_mm3) + " " + std::to_string(audited.crossings->count) + " " +
           std::to_string(counts.boundary_edges) + " " + std::to_string(counts.shell_count) + "\n" +
           make_check_json(value_of(check(mesh, {}, context))).value();
}

/// The same by one thread.
const std::string& expected() {
    static const std::string text = answers({.threads = 1});
    return text;
}

/// Calls body() on so many threads of its own.
template <class Body>
void run_threads(int count, const Body& body) noexcept {
    std::vector<std::thread> threads;
    for (int i = 0; i < count; ++i) {
        threads.emplace_back([&] { body(); });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
}

/// Any object that calls bodies, as an executor of so many threads.
template <class Pool>
void require_same(Pool pool, int threads) {
    REQUIRE(answers({.executor = pool, .executor_threads = threads}) == expected());
}

}  // namespace

TEST_CASE("an executor of std::thread may run as many bodies as asked for, or fewer, or more",
          "[engine][executor][threads]") {
    const int change = GENERATE(-3, -1, 0, 1, 9);
    require_same([change](int workers, const auto& body) noexcept { run_threads(workers + change, body); }, 4);
}

TEST_CASE("an executor may run bodies one after the other, or none", "[engine][executor]") {
    const int bodies = GENERATE(0, 4);
    require_same(
        [bodies](int, const auto& body) noexcept {
            for (int i = 0; i < bodies; ++i) {
                body();
            }
        },
        4);
}

TEST_CASE("an executor whose threads begin late gives the same answers", "[engine][executor][threads]") {
    require_same(
        [](int workers, const auto& body) noexcept {
            std::thread late([&] {
                std::this_thread::sleep_for(std::chrono::microseconds(200));
                body();
            });
            for (int i = 1; i < workers; ++i) {
                body();
            }
            late.join();
        },
        3);
}

TEST_CASE("the number of threads may differ from the executor's", "[engine][executor]") {
    int most = 0;
    auto pool = [&most](int workers, const auto& body) noexcept {
        most = std::max(most, workers);
        body();
    };
    CHECK(answers({.threads = 5, .executor = pool, .executor_threads = GENERATE(-1, 0, 1, 2, 64)}) == expected());
    CHECK(most == 5);
}

TEST_CASE("a call may be made from within a task of another one's executor", "[engine][executor][threads]") {
    std::atomic<int> nested = 0;
    std::string inner;
    auto pool = [&](int, const auto& body) noexcept {
        if (nested++ == 0) {
            inner = answers({});
        }
        body();
    };
    CHECK(answers({.executor = pool, .executor_threads = 2}) == expected());
    CHECK(inner == expected());
}
