// All parallelism of the library. oneTBB is included in parallel.cpp and nowhere else; the thread-sanitizer build runs the
// same interface on std::thread, because Debian's oneTBB is not instrumented.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

#include "base/function_ref.hpp"
#include "base/paced_stop.hpp"
#include "base/progress_meter.hpp"
#include "lamella/control.hpp"

namespace lamella {

/// Runs tasks on at most `threads()` threads of the host's executor or of oneTBB. Holds no threads of its own.
class Parallel {
public:
    /// The threads that `control` stands for: where it names none, all that its executor or the calling thread's task arena
    /// has.
    static int count_for(const Control& control);
    explicit Parallel(const Control& control = {});
    ~Parallel();
    Parallel(const Parallel&) = delete;
    Parallel& operator=(const Parallel&) = delete;

    int threads() const noexcept { return threads_; }
    /// Whether it runs tasks as one made for `control` would.
    bool serves(const Control& control) const;
    /// A call begins, on this thread, that ends when `stop` says so.
    void follow(const StopCheck& stop) noexcept { stop_.follow(stop); }
    /// The host's stop request, paced by time: for whatever works within the call.
    const StopCheck& stop() const noexcept { return stop_.check(); }

    /// For a call within the call that `control` is of: it ends with this one, and reports no progress of its own.
    Control within(Control control) const noexcept {
        control.stop = stop();
        control.progress = {};
        return control;
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
        explicit Stages(const Progress& sink) noexcept : meter_(sink) {}
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
    Executor executor_;
    PacedStop stop_;
    mutable Stages stages_;
    int threads_;
};

}  // namespace lamella
