// Threads that are started once and wait for work, for builds without oneTBB.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "base/function_ref.hpp"
#include "base/system/machine.hpp"

namespace lamella {

/// For any number of callers at once, and from within jobs. Who opens a job works on it too, and waits only for threads that
/// have begun.
class ThreadPool {
public:
    /// What threads do beside the caller, from open() to close().
    struct Job {
        FunctionRef<void()> work;     ///< throws nothing
        int wanted;                   ///< threads that may still begin
        std::atomic<int> running{0};  ///< threads that have begun and not ended
        Job* next = nullptr;
    };

    ThreadPool() = default;
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;
    ~ThreadPool() {
        std::unique_lock lock(mutex_);
        ending_ = true;
        ++opened_;  // who looks for jobs sees it
        lock.unlock();
        wake_.notify_all();
        for (std::thread& thread : threads_) {
            thread.join();
        }
    }

    /// False in a forked child, which has none of the threads.
    bool is_of_this_process() const noexcept { return process_ == process_number(); }

    bool has(int threads) const noexcept { return started_ >= threads; }

    /// Until there are so many, or the system gives no more.
    void start(int threads) noexcept {
        const std::lock_guard lock(mutex_);
        try {
            for (; started_ < threads; ++started_) {
                threads_.emplace_back([this] { serve(); });
            }
        } catch (const std::exception&) {
            started_ = std::numeric_limits<int>::max();  // those that there are do the work
        }
    }

    void open(Job& job) noexcept {
        std::unique_lock lock(mutex_);
        job.next = jobs_;
        jobs_ = &job;
        ++opened_;
        const int called = std::min(asleep_, job.wanted);
        lock.unlock();
        for (int i = 0; i < called; ++i) {
            wake_.notify_one();
        }
    }

    /// No thread works on it any more.
    void close(Job& job) noexcept {
        const auto is_done = [&] { return job.running.load(std::memory_order_acquire) == 0; };
        std::unique_lock lock(mutex_);
        Job** at = &jobs_;
        while (*at != &job) {
            at = &(*at)->next;
        }
        *at = job.next;
        if (!is_done() && !soon(lock, is_done)) {
            ended_.wait(lock, is_done);
        }
    }

private:
    /// Looks for a while, unlocked, and leaves the processor to others meanwhile: stages follow one another as fast as a
    /// thread wakes up.
    template <class Holds>
    static bool soon(std::unique_lock<std::mutex>& lock, const Holds& holds) noexcept {
        constexpr std::chrono::microseconds awake{50};
        lock.unlock();
        for (const Clock::time_point begin = Clock::now(); !holds() && Clock::now() - begin < awake;) {
            std::this_thread::yield();
        }
        lock.lock();
        return holds();
    }

    /// A thread's whole life.
    void serve() noexcept {
        std::unique_lock lock(mutex_);
        while (!ending_) {
            const auto is_news = [this, before = opened_.load()] { return opened_ != before; };
            Job* job = jobs_;
            while (job != nullptr && job->wanted == 0) {
                job = job->next;
            }
            if (job != nullptr) {
                --job->wanted;
                ++job->running;
                lock.unlock();
                job->work();
                lock.lock();
                if (job->running.fetch_sub(1) == 1) {  // from here on the job may be gone
                    ended_.notify_all();
                }
            } else if (!soon(lock, is_news)) {
                ++asleep_;
                wake_.wait(lock, is_news);
                --asleep_;
            }
        }
    }

    const std::uint64_t process_ = process_number();
    std::mutex mutex_;  ///< of all below, and of jobs
    std::condition_variable wake_;
    std::condition_variable ended_;
    std::vector<std::thread> threads_;
    std::atomic<int> started_{0};
    std::atomic<unsigned> opened_{0};  ///< jobs so far
    Job* jobs_ = nullptr;
    int asleep_ = 0;
    bool ending_ = false;
};

/// The pool of one owner, made by the first of its callers that needs it. A forked child makes another, and leaves its
/// parent's as it is: to end that would be to wait for threads that the child has not.
class KeptPool {
public:
    KeptPool() = default;
    KeptPool(const KeptPool&) = delete;
    KeptPool& operator=(const KeptPool&) = delete;
    ~KeptPool() { const std::unique_ptr<ThreadPool> ended(pool()); }

    /// Null where this process has made none.
    ThreadPool* pool() const noexcept {
        ThreadPool* const pool = pool_;
        return pool != nullptr && pool->is_of_this_process() ? pool : nullptr;
    }

    /// Null without memory.
    ThreadPool* make() noexcept {
        std::unique_ptr<ThreadPool> made(new (std::nothrow) ThreadPool);
        ThreadPool* before = pool_;
        while (made != nullptr && (before == nullptr || !before->is_of_this_process())) {
            if (pool_.compare_exchange_strong(before, made.get())) {
                return made.release();
            }
        }
        return pool();
    }

private:
    std::atomic<ThreadPool*> pool_{nullptr};
};

}  // namespace lamella
