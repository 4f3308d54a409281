// Many calls at once, from the host's own loops: oneTBB's, OpenMP's and plain threads. Each has a workspace of its own, and
// all slice one prepared mesh. Every call ends with the right answer and uses no more threads than it may.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include <omp.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>

#include "engine/calls.hpp"

using lamella::Executor;
using lamella::PreparedMesh;
using lamella::SliceOptions;

namespace {

const PreparedMesh& ball() {
    static const PreparedMesh made = [] {
        const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
        return std::move(prepare(view_of(soup))).value();
    }();
    return made;
}

SliceOptions layers(int call) {
    return uniform(0.05 + 0.01 * (call % 7));
}

const std::vector<std::uint64_t>& expected() {
    static const std::vector<std::uint64_t> hashes = [] {
        std::vector<std::uint64_t> found;
        for (int call = 0; call < 7; ++call) {
            SliceOptions options = layers(call);
            options.control.threads = 1;
            found.push_back(hash_result(*slice(ball(), options)));
        }
        return found;
    }();
    return hashes;
}

/// Asked for a stop, it says no, and counts the threads that ask at the same time: each stays for a while.
class Crowd {
public:
    bool operator()() {
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

/// One call, of several that may run at once. True if all is as it should be.
bool slices_well(int call, int threads, const Executor& executor = {}) {
    Crowd crowd;
    lamella::Workspace workspace;
    lamella::SliceResult result;
    SliceOptions options = layers(call);
    options.control.threads = threads;
    options.control.executor = executor;
    options.control.stop = asking(crowd);
    return slice(ball(), options, workspace, result).ok() &&
           hash_result(result) == expected()[static_cast<std::size_t>(call) % 7] && crowd.most() <= threads &&
           crowd.most() > 0;
}

/// A host's pool: threads that wait for work.
class Pool {
public:
    explicit Pool(int threads) {
        for (int i = 0; i < threads; ++i) {
            threads_.emplace_back([this] { serve(); });
        }
    }
    ~Pool() {
        {
            const std::lock_guard lock(mutex_);
            ends_ = true;
        }
        wake_.notify_all();
        for (std::thread& thread : threads_) {
            thread.join();
        }
    }

    /// As Executor::run, with the caller as one of the workers.
    template <class Body>
    void operator()(int workers, const Body& body) noexcept {
        std::atomic<int> begun{1};
        std::atomic<int> ended{1};
        {
            const std::lock_guard lock(mutex_);
            for (int i = 1; i < workers; ++i, ++begun) {
                work_.emplace_back([&] {
                    body();
                    ++ended;
                });
            }
        }
        wake_.notify_all();
        body();
        while (ended < begun) {  // helps the pool meanwhile, so that nested calls cannot wait for each other
            if (!take_one()) {
                std::this_thread::yield();
            }
        }
    }

private:
    bool take_one() {
        std::function<void()> work;
        {
            const std::lock_guard lock(mutex_);
            if (work_.empty()) {
                return false;
            }
            work = std::move(work_.front());
            work_.pop_front();
        }
        work();
        return true;
    }
    void serve() {
        for (;;) {
            {
                std::unique_lock lock(mutex_);
                wake_.wait(lock, [this] { return ends_ || !work_.empty(); });
                if (ends_) {
                    return;
                }
            }
            take_one();
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> work_;
    bool ends_ = false;
    std::vector<std::thread> threads_;
};

constexpr int calls = 14;

}  // namespace

TEST_CASE("many threads slice one prepared mesh", "[engine][prepare][executor]") {
    const int threads = GENERATE(1, 2, 3);
    REQUIRE(expected().size() == 7);
    std::atomic<int> good{0};
    std::vector<std::thread> hosts;
    for (int call = 0; call < calls; ++call) {
        hosts.emplace_back([&, call] { good += slices_well(call, threads) ? 1 : 0; });
    }
    for (std::thread& host : hosts) {
        host.join();
    }
    CHECK(good == calls);
}

TEST_CASE("a prepared mesh is sliced within a host's oneTBB loop", "[engine][prepare][executor]") {
    const int threads = GENERATE(1, 2, 3);
    REQUIRE(expected().size() == 7);
    tbb::task_arena arena(GENERATE(1, 4));
    std::atomic<int> good{0};
    arena.execute([&] { tbb::parallel_for(0, calls, [&](int call) { good += slices_well(call, threads) ? 1 : 0; }); });
    CHECK(good == calls);
}

TEST_CASE("a prepared mesh is sliced within a host's OpenMP loop", "[engine][prepare][executor]") {
    const int threads = GENERATE(1, 2, 3);
    REQUIRE(expected().size() == 7);
    int good = 0;
#pragma omp parallel for num_threads(4) schedule(dynamic) reduction(+ : good)
    for (int call = 0; call < calls; ++call) {
        good += slices_well(call, threads) ? 1 : 0;
    }
    CHECK(good == calls);
}

TEST_CASE("an executor over OpenMP uses no more threads than allowed", "[engine][prepare][executor]") {
    const int threads = GENERATE(1, 2, 4);
    auto openmp = [](int workers, const auto& body) noexcept {
#pragma omp parallel num_threads(workers)
        body();
    };
    CHECK(slices_well(0, threads, Executor::on(openmp, 4)));
    int good = 0;
#pragma omp parallel for num_threads(3) reduction(+ : good)
    for (int call = 0; call < calls; ++call) {
        good += slices_well(call, threads, Executor::on(openmp, 4)) ? 1 : 0;
    }
    CHECK(good == calls);
}

TEST_CASE("an executor over a pool of threads uses no more threads than allowed", "[engine][prepare][executor]") {
    const int threads = GENERATE(1, 2, 4);
    Pool pool(3);
    CHECK(slices_well(0, threads, Executor::on(pool, 4)));
    // And nested: the pool's own threads call.
    std::atomic<int> next{0};
    std::atomic<int> good{0};
    pool(4, [&] {
        for (int call = next++; call < calls; call = next++) {
            good += slices_well(call, threads, Executor::on(pool, 4)) ? 1 : 0;
        }
    });
    CHECK(good == calls);
}

TEST_CASE("an executor over oneTBB uses no more threads than allowed", "[engine][prepare][executor]") {
    const int threads = GENERATE(1, 2, 4);
    auto onetbb = [](int workers, const auto& body) noexcept {
        tbb::parallel_for(
            0, workers, 1, [&](int) { body(); }, tbb::simple_partitioner{});
    };
    CHECK(slices_well(0, threads, Executor::on(onetbb, 4)));
    std::atomic<int> good{0};
    tbb::parallel_for(0, calls, [&](int call) { good += slices_well(call, threads, Executor::on(onetbb, 4)) ? 1 : 0; });
    CHECK(good == calls);
}
