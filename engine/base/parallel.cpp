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

/// One call of run(): hands out indices in order and keeps the first exception.
struct Dispenser {
    std::size_t count;
    FunctionRef<void(std::size_t, int)> task;
    std::atomic<std::size_t> next{0};
    std::mutex mutex{};
    std::exception_ptr failure{};

    /// Relaxed: the join orders results, and any other order among tasks would hide their races from the thread sanitizer.
    std::size_t claim() noexcept { return next.fetch_add(1, std::memory_order_relaxed); }

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
};

}  // namespace

#ifdef LAMELLA_PARALLEL_STD

struct Parallel::Arena {
    template <class Work>
    static void execute(int workers, const Work& work) {
        std::vector<std::jthread> threads;
        for (int worker = 1; worker < workers; ++worker) {
            threads.emplace_back([&work, worker] { work(worker); });
        }
        work(0);
    }
};

int Parallel::count_for(int threads) {
    return threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

Parallel::Parallel(int threads) : threads_(count_for(threads)) {}

#else

struct Parallel::Arena {
    /// No more than there are: oneTBB would give no more, and say so on stderr.
    explicit Arena(int threads) : arena(std::min(threads, available())) {}
    static int available() {
        return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    }
    tbb::task_arena arena;

    /// Workers are tasks that each claim indices until none is left: fewer threads than workers only means that some find
    /// nothing to do. simple_partitioner keeps one worker per task; the arena isolates from the host's own tasks.
    template <class Work>
    void execute(int workers, const Work& work) {
        arena.execute([&] {
            tbb::parallel_for(
                0, workers, 1, [&](int worker) { work(worker); }, tbb::simple_partitioner{});
        });
    }
};

int Parallel::count_for(int threads) {
    return threads > 0 ? threads : tbb::this_task_arena::max_concurrency();
}

Parallel::Parallel(int threads) : threads_(count_for(threads)) {
    arena_ = std::make_unique<Arena>(threads_);
}

#endif

Parallel::~Parallel() = default;

void Parallel::run(std::size_t count, FunctionRef<void(std::size_t, int)> task) const {
    Dispenser dispenser{count, task};
    const int workers = static_cast<int>(std::min<std::size_t>(count, static_cast<std::size_t>(threads_)));
    if (workers <= 1) {
        dispenser.work(0);
    } else {
        try {
            arena_->execute(workers, [&](int worker) { dispenser.work(worker); });
        } catch (const std::exception&) {
            // What tasks throw, the dispenser keeps: this is a thread that the system would not start.
            throw std::bad_alloc();
        }
    }
    if (dispenser.failure) {
        std::rethrow_exception(dispenser.failure);
    }
}

void Parallel::run_ranges(std::size_t count, std::size_t grain,
                          FunctionRef<void(std::size_t, std::size_t, int)> task) const {
    const std::size_t most = static_cast<std::size_t>(threads_) * 8;
    const std::size_t ranges = std::clamp<std::size_t>(count / std::max<std::size_t>(grain, 1), 1, most);
    run(ranges, [&](std::size_t i, int worker) { task(count * i / ranges, count * (i + 1) / ranges, worker); });
}

}  // namespace lamella
