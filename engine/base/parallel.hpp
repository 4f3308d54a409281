// All parallelism of the library. oneTBB is included in parallel.cpp and nowhere else; the thread-sanitizer build runs the
// same interface on std::thread, because Debian's oneTBB is not instrumented.
#pragma once

#include <cstddef>
#include <memory>

#include "base/function_ref.hpp"
#include "lamella/control.hpp"

namespace lamella {

/// Thrown out of Parallel::run() where the host wants the call to end.
struct Stopped {};

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
    /// From here on calls end when `stop` says so.
    void follow(const StopCheck& stop) noexcept { stop_ = stop; }

    /// Calls task(index, worker) once for each index in [0, count), worker < threads() being distinct among calls that run
    /// at the same time. Indices are handed out in ascending order. Returns when all are done; rethrows the first exception,
    /// after which indices not yet begun are skipped. So they are where the host wants the call to end, and Stopped is
    /// thrown.
    void run(std::size_t count, FunctionRef<void(std::size_t index, int worker)> task) const;

    /// run() over the half-open ranges into which [0, count) is cut, each of about `grain` items or more.
    void run_ranges(std::size_t count, std::size_t grain,
                    FunctionRef<void(std::size_t begin, std::size_t end, int worker)> task) const;

private:
    struct Arena;
    std::unique_ptr<Arena> arena_;
    Executor executor_;
    StopCheck stop_;
    int threads_;
};

}  // namespace lamella
