// The threads of builds without oneTBB: jobs from several callers and from within jobs, and a forked child.
#include <atomic>
#include <thread>
#include <vector>

#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

#include <catch2/catch.hpp>

#include "base/thread_pool.hpp"

using lamella::KeptPool;
using lamella::ThreadPool;

namespace {

/// Does `task` so many times with up to `others` threads of the pool. Gives how many threads came, 0 where not all is done.
template <class Task>
int work_together(ThreadPool& pool, int tasks, int others, const Task& task) {
    std::atomic<int> next = 0;
    std::atomic<int> done = 0;
    std::atomic<int> came = 0;
    auto work = [&]() noexcept {
        for (++came; next++ < tasks; ++done) {
            task();
        }
    };
    ThreadPool::Job job{work, others};
    pool.open(job);
    work();
    pool.close(job);
    return done == tasks ? came.load() : 0;
}

}  // namespace

TEST_CASE("a job gets the threads that it wants, and no more, and waits for all of them", "[engine][pool][threads]") {
    ThreadPool pool;
    CHECK(work_together(pool, 10, 3, [] {}) == 1);
    pool.start(3);
    CHECK((pool.has(3) && !pool.has(4)));
    for (int round = 0; round < 200; ++round) {
        const int came = work_together(pool, 10, round % 3, [] { std::this_thread::yield(); });
        CHECK((came >= 1 && came <= 1 + round % 3));
    }
    // Each waits for all others.
    for (const int others : {1, 3}) {
        std::atomic<int> present = 0;
        const auto meet = [&] {
            for (++present; present <= others;) {
                std::this_thread::yield();
            }
        };
        CHECK(work_together(pool, others + 1, others, meet) == others + 1);
    }
}

TEST_CASE("several callers, whose jobs have jobs, share the threads of a pool", "[engine][pool][threads]") {
    ThreadPool pool;
    pool.start(2);
    std::atomic<int> wrong = 0;
    const auto inner = [&] { wrong += work_together(pool, 4, 2, [] {}) == 0 ? 1 : 0; };
    const auto call = [&] {
        for (int round = 0; round < 20; ++round) {
            wrong += work_together(pool, 5, 2, inner) == 0 ? 1 : 0;
        }
    };
    std::vector<std::thread> callers;
    for (int i = 0; i < 3; ++i) {
        callers.emplace_back(call);
    }
    for (std::thread& caller : callers) {
        caller.join();
    }
    CHECK(wrong == 0);
}

#if !defined(_WIN32) && !defined(LAMELLA_TESTS_SANITIZED)  // the thread sanitizer lets no forked child start threads

TEST_CASE("a forked child has a pool of its own, and ends without its parent's threads", "[engine][pool]") {
    KeptPool kept;
    CHECK(kept.pool() == nullptr);
    ThreadPool* const pool = kept.make();
    REQUIRE((pool != nullptr && kept.make() == pool));
    pool->start(2);
    const pid_t child = ::fork();
    if (child == 0) {
        ::alarm(60);  // ends a child that waits for threads which it has not
        const bool was_none = kept.pool() == nullptr;
        ThreadPool* const own = kept.make();
        own->start(1);
        const bool works = work_together(*own, 100, 1, [] { std::this_thread::yield(); }) > 0;
        const bool is_own = own != pool && own == kept.pool() && own->has(1);
        kept.~KeptPool();  // ends its own threads
        ::_exit(was_none && is_own && works ? 0 : 1);
    }
    int status = -1;
    REQUIRE((child > 0 && ::waitpid(child, &status, 0) == child));
    CHECK(status == 0);
    CHECK(work_together(*pool, 100, 2, [] {}) > 0);
}

#endif
