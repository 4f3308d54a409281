// What a call may use of its host, and how the host follows and ends it. The last argument of every long call of the
// library; nothing in it changes a byte of the answer.
//
//     std::atomic<bool> cancelled = false;
//     auto stop = [&]() noexcept { return cancelled.load(std::memory_order_relaxed); };
//     auto show = [](double fraction) noexcept { std::printf("%.0f %%\n", 100 * fraction); };
//     const lamella::Context context{.threads = 4, .stop = stop, .progress = show};
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(mesh, {.layer_height_mm = 0.1}, context);
//
// Which call uses what:
//
//     call                                       threads, executor   stop   progress   memory
//     slice(), Slicer::slice_to(), prepare()     yes                 yes    yes        result and scratch
//     Slicer::outline(), make_ready()            yes                 yes    -          scratch
//     assemble(), region_of()                    calling thread      yes    -          result and scratch
//     read_mesh(), weld(), orient_shells()       yes                 yes    yes        mesh and scratch
//     Overlay, adaptive_layers()                 yes                 yes    yes        result and scratch
//     slice_sections()                           yes                 yes    yes        result and scratch
//     find_tracks(), measure(), compare()        yes                 yes    yes        result and scratch
//     check(), audit()                           yes                 yes    yes        -
//     write_layers() for a Screen                yes                 yes    yes        -
//     other writers                              calling thread      yes    yes        -
//
// Every call asks for a stop when it begins, and then every two milliseconds or a little more, whatever the mesh and the
// rules: on the thread that made the call while that one works, and on one of the others. It asks after each layer that a
// sink has taken, too, so that a sink which ends the call gets no layer more. A call that is over before the host is asked
// again succeeds.
//
// Calls may be made from several threads at once, and from within the tasks and loops of oneTBB, OpenMP or the host's own
// pool: each uses at most its own number of threads, and none waits for another. What takes some 20 us is done by the
// calling thread alone. A negative number of threads is invalid_argument in all of them.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace lamella {

template <class Signature>
class Callback;

/// The host's function: two words, that refer to the function object it is made of. That must outlive the call. It cannot be
/// made of a temporary, nor of a function that may throw: an exception could not pass through the library.
template <class R, class... A>
class Callback<R(A...)> {
public:
    constexpr Callback() noexcept = default;
    /// For other languages: `call(object, ...)`.
    constexpr Callback(void* object, R (*call)(void*, A...) noexcept) noexcept : object_(object), call_(call) {}
    // NOLINTBEGIN(google-explicit-constructor): converted where it is passed
    template <class F>
    requires(!std::same_as<std::remove_cv_t<F>, Callback>) && std::is_nothrow_invocable_r_v<R, F&, A...> Callback(
                                                                  F& function) noexcept
        : object_(const_cast<void*>(static_cast<const void*>(&function))),
    call_([](void* object, A... a) noexcept -> R { return (*static_cast<F*>(object))(std::forward<A>(a)...); }) {}
    // NOLINTEND(google-explicit-constructor)
    template <class F>
    requires(!std::same_as<std::remove_cv_t<F>, Callback>) Callback(const F&& temporary)
    = delete;

    explicit operator bool() const noexcept { return call_ != nullptr; }
    friend bool operator==(const Callback&, const Callback&) = default;
    /// Precondition: there is a function.
    R operator()(A... a) const noexcept { return call_(object_, std::forward<A>(a)...); }

private:
    void* object_ = nullptr;
    R (*call_)(void*, A...) noexcept = nullptr;
};

/// The host's memory. Its functions are called from several threads at once. It must outlive every call that it is passed to
/// and every result whose arrays come from it. These take operator new though: the list of contours in a plane that all
/// threads work on together; heights, slabs and fill rules that options and results hold; of several parts 8 bytes a layer
/// and about 500 a part; the texts of errors and warnings; and objects of a fixed size, some a call, a thread and a band.
struct Memory {
    /// `bytes` > 0 at a multiple of `alignment`, a power of two; null where there are none.
    Callback<void*(std::size_t bytes, std::size_t alignment)> allocate{};
    /// Takes back what allocate() gave for the same `bytes` and `alignment`.
    Callback<void(void* memory, std::size_t bytes, std::size_t alignment)> release{};
};

/// Memory from an object with allocate(bytes, alignment), which may throw, and deallocate(memory, bytes, alignment), such as
/// a std::pmr::memory_resource. The object must outlive the Memory.
template <class Resource>
Memory memory_of(Resource& resource) noexcept {
    return {{&resource,
             [](void* object, std::size_t bytes, std::size_t alignment) noexcept -> void* {
                 try {
                     return static_cast<Resource*>(object)->allocate(bytes, alignment);
                 } catch (...) {
                     return nullptr;
                 }
             }},
            {&resource, [](void* object, void* memory, std::size_t bytes, std::size_t alignment) noexcept {
                 static_cast<Resource*>(object)->deallocate(memory, bytes, alignment);
             }}};
}

struct Context {
    int threads = 0;          ///< at most so many; 0: all that the executor has
    Callback<bool()> stop{};  ///< true ends the call with ErrorCode::cancelled; asked by two threads at once, and by more
                              ///< where a sink is
    Callback<void(double)> progress{};  ///< told a fraction that rises to 1, on any working thread, one call at a time
    const Memory* memory = nullptr;     ///< null: operator new
    std::uint64_t memory_limit_bytes =
        0;  ///< of a result: larger ones are refused before allocation; 0: half of physical memory
    /// The host's threads; without it oneTBB's, within the task arena of the calling thread. Calls body() up to `workers`
    /// times and returns when every call that has begun has returned. The calls may run at once, on any threads, or one
    /// after the other: a worker never waits for one that has not begun, so that fewer calls only mean fewer threads.
    Callback<void(int workers, Callback<void()> body)> executor{};
    int executor_threads = 1;  ///< how many calls it can run at once: the workers asked for where `threads` is 0
};

}  // namespace lamella
