// Many calls at once, from the host's own loops: oneTBB's and plain threads. All slice one prepared
// mesh. Every call ends with the right answer and uses no more threads than it may.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "engine/slicing.hpp"

using lamella::Callback;

namespace {

/// Asked for a stop, it says no, and counts the threads that ask at the same time: each stays for a while.
class Crowd {
public:
    bool operator()() noexcept {
        const int inside = ++inside_;
        int most = most_;
        while (inside > most && !most_.compare_exchange_weak(most, inside)) {
        }
        if (asked_++ % 16 == 0) {
            std::this_thread::sleep_for(std::chrono::microseconds(20));
        }
        --inside_;
        return false;
    }
    int most() const { return most_; }

private:
    std::atomic<int> inside_{0};
    std::atomic<int> most_{0};
    std::atomic<int> asked_{0};
};

constexpr int calls = 14;
using Call = std::function<void(int)>;

/// Calls call(0) to call(calls - 1), some at once.
using Loop = std::function<void(const Call& call)>;

void on_threads(const Call& call) {
    std::vector<std::thread> hosts;
    for (int i = 0; i < calls; ++i) {
        hosts.emplace_back(call, i);
    }
    for (std::thread& host : hosts) {
        host.join();
    }
}

Loop by_onetbb(int arena_threads) {
    return [arena_threads](const Call& call) {
        tbb::task_arena(arena_threads).execute([&] { tbb::parallel_for(0, calls, call); });
    };
}

}  // namespace

TEST_CASE("a prepared mesh is sliced within a host's loops, by its executor, on no more threads than allowed",
          "[engine][prepare][executor]") {
    auto onetbb = [](int workers, const auto& body) noexcept {
        tbb::parallel_for(
            0, workers, 1, [&](int) { body(); }, tbb::simple_partitioner{});
    };
    struct Host {
        const char* name;
        Loop loop;
        Callback<void(int, Callback<void()>)> executor{};  // has four threads
    };
    const Host hosts[] = {{"threads", on_threads},
                          {"oneTBB on one thread", by_onetbb(1)},
                          {"oneTBB", by_onetbb(4)},
                          {"an executor over oneTBB, called by threads", on_threads, onetbb},
                          {"an executor over oneTBB, called by its own threads", by_onetbb(4), onetbb}};
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
    const lamella::PreparedMesh ball = value_of(prepare(view_of(soup)));
    const auto layers = [](int call) { return uniform(0.05 + 0.01 * (call % 7)); };
    std::vector<std::uint64_t> expected;
    for (int call = 0; call < calls; ++call) {
        expected.push_back(sliced(ball, layers(call), {.threads = 1}).hash());
    }
    for (const Host& host : hosts) {
        for (const int threads : {1, 2, 4}) {
            std::atomic<int> good{0};
            const auto slice_well = [&](int call) {
                Crowd crowd;
                const auto result = slice(ball, layers(call),
                                          {.threads = threads,
                                           .stop = crowd,
                                           .executor = host.executor,
                                           .executor_threads = host.executor ? 4 : 1});
                good += result.ok() && result->hash() == expected[static_cast<std::size_t>(call)] &&
                        crowd.most() <= threads && crowd.most() > 0;
            };
            INFO(host.name << ", threads " << threads);
            slice_well(0);
            host.loop(slice_well);
            CHECK(good == 1 + calls);
        }
    }
}
