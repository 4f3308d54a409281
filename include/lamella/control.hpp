// What a call may use of its host, and how the host follows and ends it. Every long function of the library takes one.
//
//     std::atomic<bool> cancelled = false;
//     const auto show = [](double fraction) noexcept { std::printf("%.0f %%\n", 100 * fraction); };
//     lamella::Control control;
//     control.threads = 4;
//     control.stop = lamella::StopCheck::when(cancelled);
//     control.progress = lamella::Progress::to(show);
//
// All members are plain function pointers with a context, so that any language and any host can fill them in. The functions
// must not throw, which their types say. What a context points to must outlive the call.
//
// Which call uses what:
//
//     call                                           threads, executor  stop                progress  memory
//     slice(), slice_parts()                         yes                yes                 yes       result and scratch
//     prepare(), slice_slabs()                       yes                yes                 yes       result and scratch
//     slice_to(), slice_into()                       yes                yes                 yes       scratch
//     bound_output()                                 yes                yes                 -         scratch
//     assemble()                                     calling thread     yes                 yes       result and scratch
//     region_of()                                    calling thread     yes                 -         result and scratch
//     read_mesh()                                    yes                yes                 yes       mesh and scratch
//     weld()                                         yes                yes                 yes       mesh and scratch
//     inspect(), check()                             yes                yes                 yes       -
//     make_ledger(), certify_volume(),
//     find_crossings()                               yes                yes                 yes       -
//     write_svg()                                    calling thread     yes                 yes       -
//
// Every call asks for a stop when it begins, and then every two milliseconds or a little more, whatever the mesh and the
// rules: on the thread that made the call while that one works, and on one of the others. It asks after each layer that a
// sink has taken, too, so that a sink which ends the call gets no layer more. A call that is over before the host is asked
// again succeeds.
//
// Calls may be made from several threads at once, and from within the tasks and loops of oneTBB, OpenMP or the host's own
// pool: each uses at most its own number of threads, and none waits for another. What takes some 20 us is done by the
// calling thread alone.
//
// A negative number of threads is invalid_argument in all of them.
#pragma once

#include <atomic>
#include <type_traits>

#include "lamella/memory.hpp"

namespace lamella {

/// The host's threads. Without one, oneTBB's are used, within the task arena of the calling thread.
struct Executor {
    /// Calls body(argument) up to `workers` times and returns when every call that has begun has returned. The calls may run
    /// at once, on any threads, or one after the other. The library hands out the work within them, and a worker never waits
    /// for one that has not begun: fewer calls, or none, only mean fewer threads, and further ones return at once.
    void (*run)(void* context, int workers, void (*body)(void* argument) noexcept, void* argument) noexcept = nullptr;
    void* context = nullptr;
    int threads = 1;  ///< how many calls it can run at once: the workers asked for where Control::threads is 0

    /// `pool(workers, body)` calls body() as above; `pool` must outlive the Executor.
    template <class Pool>
    static Executor on(Pool& pool, int threads) noexcept {
        return {[](void* context, int workers, void (*body)(void*) noexcept, void* argument) noexcept {
                    (*static_cast<Pool*>(context))(workers, [body, argument]() noexcept { body(argument); });
                },
                &pool, threads};
    }
};

/// Whether the host wants the call to end. Asked by two threads at once, and by more where a sink is.
struct StopCheck {
    bool (*requested)(void* context) noexcept = nullptr;
    void* context = nullptr;

    bool stop_requested() const noexcept { return requested != nullptr && requested(context); }

    /// Ends the call once `flag` is true.
    static StopCheck when(std::atomic<bool>& flag) noexcept {
        return {
            [](void* context) noexcept { return static_cast<std::atomic<bool>*>(context)->load(std::memory_order_relaxed); },
            &flag};
    }
};

/// Where the call says how far it is.
struct Progress {
    /// `fraction` rises from one call to the next and is 1 in the last, which a call that succeeds makes before it returns.
    /// Called on any of the working threads, never on two at once, and while none of the library's locks is held that work
    /// waits for: a slow sink slows only the thread that it is called on.
    void (*report)(void* context, double fraction) noexcept = nullptr;
    void* context = nullptr;

    /// `sink(fraction)`, which must be noexcept.
    template <class Sink>
    static Progress to(Sink& sink) noexcept {
        static_assert(std::is_nothrow_invocable_v<Sink&, double>, "an exception could not pass through the library");
        return {[](void* context, double fraction) noexcept { (*static_cast<Sink*>(context))(fraction); },
                const_cast<std::remove_const_t<Sink>*>(&sink)};
    }
};

struct Control {
    int threads = 0;                 ///< at most this many; 0: all that the executor has
    Executor executor{};             ///< without one: oneTBB
    const Memory* memory = nullptr;  ///< null: operator new
    StopCheck stop{};                ///< ends the call with ErrorCode::cancelled
    Progress progress{};
};

}  // namespace lamella
