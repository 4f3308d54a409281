// The host's part in a call: threads, stop requests and progress. oneTBB is included in parallel.cpp and nowhere else.
// Without it threads come from thread_pool.hpp, as in the thread-sanitizer build: Debian's oneTBB is not instrumented.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "base/function_ref.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// Of what stands in one array for each worker: two lines of the cache, which processors fetch in pairs, so that no worker
/// writes into lines that another one reads.
inline constexpr std::size_t worker_alignment = 128;

/// True where the host wants the call to end.
using StopCheck = Callback<bool()>;

inline bool stop_requested(const StopCheck& check) noexcept {
    return check && check();
}

/// Thrown where the host wants the call to end.
struct Stopped {};

/// Asks the host at the first look, and then at most once in `interval` on the thread that made the call and once on the
/// others together. The calling thread has an interval of its own because some hosts, such as Python, answer only there.
/// Once the host has said yes, every look says so: of many threads each would else wait until it is its turn to ask.
class PacedStop {
public:
    static constexpr std::chrono::milliseconds interval{2};

    explicit PacedStop(const StopCheck& host = {}) noexcept { follow(host); }
    PacedStop(const PacedStop&) = delete;
    PacedStop& operator=(const PacedStop&) = delete;

    /// A call begins, on this thread.
    void follow(const StopCheck& host) noexcept {
        host_ = host;
        caller_ = std::this_thread::get_id();
        next_[0] = next_[1] = 0;
        const auto look = [](void* self) noexcept { return static_cast<PacedStop*>(self)->look(); };
        check_ = host ? StopCheck{this, look} : StopCheck{};
    }

    /// For any thread. A look that does not ask the host costs a look at the clock.
    const StopCheck& check() const noexcept { return check_; }
    void stop_if_asked() const { stop_if(check_); }
    /// Asks the host whatever the time: one of its own functions has just run, and may have found a reason to stop.
    void ask_host() const { stop_if(host_); }

private:
    static void stop_if(const StopCheck& check) {
        if (stop_requested(check)) {
            throw Stopped();
        }
    }
    static Clock::rep now() noexcept { return Clock::now().time_since_epoch().count(); }

    bool look() noexcept {
        constexpr Clock::rep while_asking = std::numeric_limits<Clock::rep>::max();
        constexpr Clock::rep said_yes = -1;
        std::atomic<Clock::rep>& next = next_[std::this_thread::get_id() == caller_ ? 0 : 1];
        Clock::rep due = next.load(std::memory_order_relaxed);
        if (due == said_yes) {
            return true;
        }
        if (now() < due || !next.compare_exchange_strong(due, while_asking, std::memory_order_relaxed)) {
            return false;
        }
        if (!stop_requested(host_)) {
            next.store(now() + Clock::duration(interval).count(), std::memory_order_relaxed);
            return false;
        }
        next_[0] = next_[1] = said_yes;
        return true;
    }

    StopCheck host_;
    StopCheck check_;
    std::thread::id caller_;
    std::array<std::atomic<Clock::rep>, 2> next_{};  ///< when the host is asked again: on the calling thread, on others
};

/// Progress reported to the host: by one thread at a time, and never falling.
class ProgressMeter {
public:
    explicit ProgressMeter(const Callback<void(double)>& sink) noexcept : sink_(sink) {}

    /// From any thread, which does not wait: while another one reports, this is left out. So is what is not below 1, since
    /// the call may still fail.
    void reach(double fraction) noexcept {
        if (!sink_) {
            return;
        }
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock.owns_lock() && fraction > reported_ && fraction < 1) {
            reported_ = fraction;
            sink_(fraction);
        }
    }

    /// The call has succeeded, and no thread works on it any more.
    void finish() noexcept {
        if (sink_) {
            sink_(1);
        }
    }

private:
    Callback<void(double)> sink_;
    std::mutex mutex_;
    double reported_ = -1;
};

/// Runs tasks on at most `threads()` threads of the host's executor or of oneTBB. Built without oneTBB, it has its own,
/// which are started by the first run of some length and end with it. One thread or several may call run(), and tasks may.
class Parallel {
public:
    /// The threads that `context` stands for: where it names none, all that its executor or the calling thread's task arena
    /// has.
    static int count_for(const Context& context);
    explicit Parallel(const Context& context = {});
    ~Parallel();
    Parallel(const Parallel&) = delete;
    Parallel& operator=(const Parallel&) = delete;

    int threads() const noexcept { return threads_; }
    /// The host's; null for operator new.
    const Memory* memory() const noexcept { return memory_; }
    /// True if it runs tasks as one made for `context` would.
    bool serves(const Context& context) const;
    /// A call begins, on this thread, that ends when `stop` says so.
    void follow(const StopCheck& stop) noexcept { stop_.follow(stop); }
    /// The host's stop request, paced by time: for whatever works within the call.
    const StopCheck& stop() const noexcept { return stop_.check(); }

    /// For a call within the call that `context` is of: it ends with this one, and reports no progress of its own.
    Context within(Context context) const noexcept {
        context.stop = stop();
        context.progress = {};
        return context;
    }

    /// How many workers run() may have for so many indices; at least one.
    std::size_t workers_for(std::size_t count) const noexcept {
        return std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(threads_));
    }

    /// Calls task(index, worker) once for each index in [0, count), worker < threads() being distinct among calls that run
    /// at the same time. Indices are handed out in ascending order. Returns when all are done; rethrows the first exception,
    /// after which indices not yet begun are skipped. So they are where the host wants the call to end, and Stopped is
    /// thrown.
    void run(std::size_t count, FunctionRef<void(std::size_t index, int worker)> task) const;

    /// run() over the half-open ranges into which [0, count) is cut, each of about `grain` items or more, up to 16 times as
    /// many.
    void run_ranges(std::size_t count, std::size_t grain,
                    FunctionRef<void(std::size_t begin, std::size_t end, int worker)> task) const;

    /// From here on calls of run() lead the progress on to `fraction`, each by an equal share of the way: `runs` are
    /// expected, and further ones add nothing. Before the first stage nothing is reported.
    void begin_stage(double fraction, std::size_t runs = 1) const noexcept { stages_.begin(fraction, runs); }
    /// For what is done on the calling thread within a stage.
    void reach(double fraction) const noexcept { stages_.reach(fraction); }
    /// The call has succeeded.
    void finish() const noexcept { stages_.finish(); }

    /// For what one thread does, between two of its steps: throws Stopped where the host wants the call to end.
    void stop_if_asked() const { stop_.stop_if_asked(); }
    /// The same after a function of the host's: see PacedStop.
    void ask_host() const { stop_.ask_host(); }

private:
    /// How far the stages have led.
    class Stages {
    public:
        explicit Stages(const Callback<void(double)>& sink) noexcept : meter_(sink) {}
        void begin(double fraction, std::size_t runs) noexcept;
        void begin_run() noexcept;
        void reach(std::size_t index, std::size_t count) noexcept {
            if (shown_) {
                meter_.reach(from_ + (to_ - from_) * static_cast<double>(index) / static_cast<double>(count));
            }
        }
        void reach(double fraction) noexcept { meter_.reach(fraction); }
        void finish() noexcept { meter_.finish(); }

    private:
        ProgressMeter meter_;
        bool shown_ = false;  ///< a stage has begun
        std::size_t runs_left_ = 0;
        double from_ = 0;  ///< of the run
        double to_ = 0;
        double end_ = 0;  ///< of the stage
    };

    struct Arena;
    std::unique_ptr<Arena> arena_;
    const Memory* memory_;
    Callback<void(int, Callback<void()>)> executor_;
    PacedStop stop_;
    mutable Stages stages_;
    int threads_;
};

/// A value for each worker of a run, of which the first needs no memory: small work has one worker.
template <class T>
class PerWorker {
public:
    /// `workers` values, at least one. Throws std::bad_alloc.
    explicit PerWorker(std::size_t workers) : rest_(workers > 1 ? workers - 1 : 0) {}

    T& operator[](std::size_t worker) noexcept { return worker == 0 ? first_ : rest_[worker - 1]; }

    /// Calls use(value) for each.
    template <class Use>
    void for_each(Use&& use) const {
        use(first_);
        for (const T& value : rest_) {
            use(value);
        }
    }

private:
    T first_{};
    std::vector<T> rest_;
};

/// Stop requests within work that one thread does by itself, such as a plane of a slice: the host is asked by the work done,
/// so that small pieces of work cost next to nothing and long ones end soon. A unit of work is one of the steps that are
/// done for every point or edge: 1 to 10 ns where memory is read in order. Steps that wait for memory count for several.
class StopPace {
public:
    /// From here on the host is asked.
    void follow(const StopCheck& host) noexcept {
        host_ = host;
        left_ = work_between_asks;
    }

    /// After `work` units: throws Stopped where the host wants the call to end.
    void spend(std::size_t work) {
        if (work < left_) {
            left_ -= work;
        } else {
            ask();
        }
    }

    /// Calls body(begin, end) for one stretch of [begin, end) after another; an index costs `work` units.
    template <class Body>
    void in_stretches(std::size_t begin, std::size_t end, std::size_t work, Body body) {
        const std::size_t most = work_between_asks / work;
        while (begin < end) {
            const std::size_t next = begin + std::min(most, end - begin);
            body(begin, next);
            spend(work * (next - begin));
            begin = next;
        }
    }

    /// At once.
    void ask() {
        left_ = work_between_asks;
        if (stop_requested(host_)) {
            throw Stopped();
        }
    }

private:
    static constexpr std::size_t work_between_asks = std::size_t{1} << 17;

    StopCheck host_{};
    std::size_t left_ = work_between_asks;
};

}  // namespace lamella
