// Hosts that use oneTBB themselves: calls from within their arenas and tasks end, with the same answer.
#include <atomic>
#include <cstdint>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"

namespace {

std::uint64_t hash_in(const shapes::Soup& soup, int threads) {
    lamella::SliceOptions options = uniform(0.05);
    options.control.threads = threads;
    const lamella::Result<lamella::SliceResult> result = slice(view_of(soup), options);
    return result.ok() ? hash_result(*result) : 0;
}

}  // namespace

TEST_CASE("a slice within a host's task arena gives the same answer", "[engine][executor]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 4);
    const std::uint64_t expected = hash_in(soup, 1);
    tbb::task_arena arena(GENERATE(1, 2, 5));
    const int threads = GENERATE(0, 1, 4);
    std::uint64_t found = 0;
    arena.execute([&] { found = hash_in(soup, threads); });
    CHECK(found == expected);
}

TEST_CASE("slices in many tasks of a host at once give the same answer", "[engine][executor]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 4);
    const std::uint64_t expected = hash_in(soup, 1);
    std::atomic<int> equal = 0;
    tbb::task_arena arena(3);
    arena.execute([&] { tbb::parallel_for(0, 12, [&](int task) { equal += hash_in(soup, task % 4) == expected; }); });
    CHECK(equal == 12);
}
