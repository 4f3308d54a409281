#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>

#ifdef LAMELLA_PARALLEL_STD
#include <thread>
#include <vector>
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
        try {
            for (std::size_t i = claim(); i < count; i = claim()) {
                task(i, worker);
            }
        } catch (...) {
            next.store(count, std::memory_order_relaxed);
            const std::lock_guard lock(mutex);
            if (!failure) {
                failure = std::current_exception();
            }
        }
    }

    bool has_work() const noexcept {
        return next.load(std::memory_order_relaxed) < count && !stopped.load(std::memory_order_relaxed);
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

struct Parallel::Arena {
    explicit Arena(int /*threads*/) {}
    static int available() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

    template <class Body>
    static void execute(int workers, const Body& body) {
        std::vector<std::thread> threads;
        try {
            threads.reserve(static_cast<std::size_t>(workers - 1));
            while (threads.size() + 1 < static_cast<std::size_t>(workers)) {
                threads.emplace_back(body);
            }
        } catch (const std::exception&) {
            // No memory or no thread is left for more workers: those that there are do the work, and are joined below.
        }
        body();
        for (std::thread& thread : threads) {
            thread.join();
        }
    }
};

#else

struct Parallel::Arena {
    /// No more than there are: oneTBB would give no more, and say so on stderr.
    explicit Arena(int threads)
        : arena(std::min(
              threads, static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism)))) {}
    static int available() { return tbb::this_task_arena::max_concurrency(); }
    tbb::task_arena arena;

    /// simple_partitioner keeps one worker per task; the arena isolates from the host's own tasks.
    template <class Body>
    void execute(int workers, const Body& body) {
        arena.execute([&] {
            tbb::parallel_for(
                0, workers, 1, [&](int) { body(); }, tbb::simple_partitioner{});
        });
    }
};

#endif

int Parallel::count_for(const Context& context) {
    if (context.threads > 0) {
        return context.threads;
    }
    return std::max(1, context.executor ? context.executor_threads : Arena::available());
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
            arena_->execute(workers, [&] { dispenser.join(); });
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
