#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>

#ifdef LAMELLA_PARALLEL_STD
#include "base/thread_pool.hpp"
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace lamella {

namespace {

/// One call of run(): hands out worker numbers and indices, both in order, and keeps the first exception.
struct Dispenser {
    std::size_t count;
    int workers;
    FunctionRef<void(std::size_t, int)> task;
    const StopCheck& stop;
    std::atomic<int> next_worker{0};
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stopped{false};
    std::mutex mutex{};
    std::exception_ptr failure{};

    /// A worker's whole life.
    void join() noexcept {
        const int worker = next_worker.fetch_add(1, std::memory_order_relaxed);
        if (worker < workers) {
            work(worker);
        }
    }

    void work(int worker) noexcept {
        while (step(worker)) {
        }
    }

    /// One task, if there is one left.
    bool step(int worker) noexcept {
        try {
            const std::size_t i = claim();
            if (i < count) {
                task(i, worker);
            }
            return i < count;
        } catch (...) {
            next.store(count, std::memory_order_relaxed);
            const std::lock_guard lock(mutex);
            if (!failure) {
                failure = std::current_exception();
            }
            return false;
        }
    }

    bool has_work() const noexcept { return left() > 0 && !stopped.load(std::memory_order_relaxed); }
    /// Tasks that nobody has begun.
    std::size_t left() const noexcept {
        const std::size_t begun = next.load(std::memory_order_relaxed);
        return begun < count ? count - begun : 0;
    }

private:
    /// Relaxed: the join orders results, and any other order among tasks would hide their races from the thread sanitizer.
    std::size_t claim() noexcept {
        if (has_work() && stop_requested(stop)) {
            stopped.store(true, std::memory_order_relaxed);
        }
        return stopped.load(std::memory_order_relaxed) ? count : next.fetch_add(1, std::memory_order_relaxed);
    }
};

}  // namespace

#ifdef LAMELLA_PARALLEL_STD

/// Starts threads once a run has taken so long that they pay, and keeps them.
struct Parallel::Arena {
    explicit Arena(int /*threads*/) {}
    static int available() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }
    static int most() { return std::numeric_limits<int>::max(); }

    void execute(Dispenser& dispenser) noexcept {
        auto join = [&]() noexcept { dispenser.join(); };
        const int others = dispenser.workers - 1;
        ThreadPool::Job job{join, others};
        ThreadPool* pool = kept.pool();
        const bool was_there = pool != nullptr;
        if (was_there) {
            pool->open(job);
        }
        const int worker = dispenser.next_worker.fetch_add(1, std::memory_order_relaxed);
        if ((!was_there || !pool->has(others)) && is_long(dispenser, worker)) {
            pool = was_there ? pool : kept.make();
            if (pool != nullptr && !was_there) {
                pool->open(job);
            }
            if (pool != nullptr) {
                pool->start(static_cast<int>(std::min(dispenser.left(), static_cast<std::size_t>(others))));
            }
        }
        dispenser.work(worker);
        if (pool != nullptr) {
            pool->close(job);
        }
    }

    /// Works alone until threads pay, or to the end.
    static bool is_long(Dispenser& dispenser, int worker) noexcept {
        constexpr std::chrono::microseconds worth_a_thread{200};  // about twice what it takes to start and to end one
        const Clock::time_point begin = Clock::now();
        while (dispenser.step(worker)) {
            if (Clock::now() - begin > worth_a_thread) {
                return true;
            }
        }
        return false;
    }

    KeptPool kept;
};

#else

struct Parallel::Arena {
    explicit Arena(int threads) : arena(threads) {}
    static int available() { return tbb::this_task_arena::max_concurrency(); }
    /// oneTBB would give no more, and say so on stderr.
    static int most() {
        return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    }
    tbb::task_arena arena;

    /// simple_partitioner keeps one worker per task; the arena isolates from the host's own tasks.
    void execute(Dispenser& dispenser) {
        arena.execute([&] {
            tbb::parallel_for(
                0, dispenser.workers, 1, [&](int) { dispenser.join(); }, tbb::simple_partitioner{});
        });
    }
};

#endif

int Parallel::count_for(const Context& context) {
    const int asked = context.threads;
    if (context.executor) {
        return asked > 0 ? asked : std::max(1, context.executor_threads);
    }
    return asked > 0 ? std::min(asked, Arena::most()) : Arena::available();
}

Parallel::Parallel(const Context& context)
    : arena_(context.executor ? nullptr : std::make_unique<Arena>(count_for(context))),
      memory_(context.memory),
      executor_(context.executor),
      stop_(context.stop),
      stages_(context.progress),
      threads_(count_for(context)) {}

Parallel::~Parallel() = default;

void Parallel::Stages::begin(double fraction, std::size_t runs) noexcept {
    from_ = to_ = end_;  // where the stage before ends, whether or not it had as many runs
    end_ = fraction;
    runs_left_ = runs;
    shown_ = true;
    reach(0, 1);
}

void Parallel::Stages::begin_run() noexcept {
    from_ = to_;
    if (runs_left_ > 0) {
        to_ = from_ + (end_ - from_) / static_cast<double>(runs_left_--);
    }
}

bool Parallel::serves(const Context& context) const {
    return threads_ == count_for(context) && executor_ == context.executor;
}

void Parallel::run(std::size_t count, FunctionRef<void(std::size_t, int)> task) const {
    const int workers = static_cast<int>(std::min<std::size_t>(count, static_cast<std::size_t>(threads_)));
    const auto shown = [&](std::size_t index, int worker) {
        stages_.reach(index, count);
        task(index, worker);
    };
    stages_.begin_run();
    Dispenser dispenser{count, workers, shown, stop()};
    if (workers > 1 && executor_) {
        auto join = [&]() noexcept { dispenser.join(); };
        executor_(workers, join);
    } else if (workers > 1) {
        try {
            arena_->execute(dispenser);
        } catch (const std::exception&) {
            // The dispenser keeps what tasks throw: this is a thread that the system would not start.
            throw std::bad_alloc();
        }
    }
    if (dispenser.has_work()) {  // one thread, or an executor that ran no worker
        dispenser.work(0);
    }
    if (dispenser.failure) {
        std::rethrow_exception(dispenser.failure);
    }
    if (dispenser.stopped.load(std::memory_order_relaxed)) {
        throw Stopped();
    }
}

void Parallel::run_ranges(std::size_t count, std::size_t grain,
                          FunctionRef<void(std::size_t, std::size_t, int)> task) const {
    constexpr std::size_t most_grains = 16;  // so that a range ends soon after a stop is asked for
    const std::size_t grains = std::max<std::size_t>(count / std::max<std::size_t>(grain, 1), 1);
    const std::size_t enough = std::max(static_cast<std::size_t>(threads_) * 8, grains / most_grains);
    const std::size_t ranges = std::min(grains, enough);
    run(ranges, [&](std::size_t i, int worker) { task(count * i / ranges, count * (i + 1) / ranges, worker); });
}

}  // namespace lamella
