// All parallelism of the library. oneTBB is included in parallel.cpp and nowhere else; the thread-sanitizer build runs the
// same interface on std::thread, because Debian's oneTBB is not instrumented.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace lamella {

/// A reference to something callable; the callable must outlive it. Calls are as coarse as a task, so the indirection is
/// free.
template <class Signature>
class FunctionRef;

template <class R, class... Args>
class FunctionRef<R(Args...)> {
public:
    // Implicit, as lambdas are passed; the constraint leaves copies to the copy constructor.
    template <class F>
    // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload)
    requires(!std::is_same_v<std::remove_cvref_t<F>, FunctionRef>) FunctionRef(F&& f)
    noexcept
        : object_(const_cast<void*>(static_cast<const void*>(std::addressof(f)))),
          call_([](void* object, Args... args) -> R {
              return (*static_cast<std::remove_reference_t<F>*>(object))(static_cast<Args>(args)...);
          }) {}
    R operator()(Args... args) const { return call_(object_, static_cast<Args>(args)...); }

private:
    void* object_;
    R (*call_)(void*, Args...);
};

/// Runs tasks on at most `threads()` threads. Holds no threads of its own.
class Parallel {
public:
    /// 0 stands for as many as the calling thread's task arena has.
    static int count_for(int threads);
    explicit Parallel(int threads = 0);
    ~Parallel();
    Parallel(const Parallel&) = delete;
    Parallel& operator=(const Parallel&) = delete;

    int threads() const noexcept { return threads_; }

    /// Calls task(index, worker) once for each index in [0, count), worker < threads() being distinct among calls that run
    /// at the same time. Indices are handed out in ascending order. Returns when all are done; rethrows the first exception,
    /// after which indices not yet begun are skipped.
    void run(std::size_t count, FunctionRef<void(std::size_t index, int worker)> task) const;

    /// run() over the half-open ranges into which [0, count) is cut, each of about `grain` items or more.
    void run_ranges(std::size_t count, std::size_t grain,
                    FunctionRef<void(std::size_t begin, std::size_t end, int worker)> task) const;

private:
    struct Arena;
    std::unique_ptr<Arena> arena_;
    int threads_;
};

}  // namespace lamella
