// Shared by the files of the native module: engine calls, meshes, options and results as Python holds them.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "lamella/source.hpp"

namespace lamella::python {

namespace py = pybind11;
using namespace py::literals;

/// Throws the exception of lamella._errors that fits, with the evidence.
[[noreturn]] void raise(const Error& error);

/// Bytes that are no UTF-8 stand as \xe4.
py::str text_of(const std::string& text);

/// Python's keywords of a call: what is asked for, and what it may use.
struct Asked {
    SliceOptions options{};
    int threads = 0;
    std::uint64_t memory_limit_bytes = 0;
    py::object progress{};  ///< a callable, or null
};

/// Options by the names of their C++ members, both ways.
void read_options(const py::dict& given, SliceOptions& options);
py::dict dict_of(const SliceOptions& options);

/// The thread that calls the engine: looks at the interpreter's signals if it is Python's main thread, and reports progress.
/// An exception that a handler or the report raises stays pending and ends the call.
class Caller {
public:
    /// The calling thread holds the interpreter. `report` is a callable or null, and outlives this.
    explicit Caller(PyObject* report);
    /// What the engine asks, on any thread.
    bool wants_to_stop() noexcept;
    void reach(double fraction) noexcept { reached_.store(fraction, std::memory_order_relaxed); }
    /// The call has succeeded. The thread holds the interpreter again.
    void finish();

private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds interval{50};

    bool report() noexcept;

    std::thread::id thread_;
    bool main_thread_;
    PyObject* report_;                // borrowed, or null
    std::atomic<double> reached_{0};  // by the engine, on any thread
    double reported_ = 0;
    Clock::time_point next_look_ = Clock::now() + interval;  // of the calling thread alone
    std::atomic<bool> raised_ = false;
};

/// oneTBB's threads do not survive a fork, and its locks may stay locked by threads that are gone: in a forked process a
/// call starts threads of its own.
extern std::atomic<bool> is_forked;
void lend_threads(Context& context) noexcept;

template <class T>
T taken(Result<T>&& result) {
    return std::move(result).value();
}
inline void taken(Status&&) {}

/// The value of `work(context)`, a Result or Status, which runs without the interpreter. Raises its error.
template <class Work>
auto run(const Asked& asked, Work&& work) {
    Caller caller(asked.progress.ptr());
    auto stop = [&caller]() noexcept { return caller.wants_to_stop(); };
    auto progress = [&caller](double fraction) noexcept { caller.reach(fraction); };
    Context context{.threads = asked.threads, .stop = stop, .memory_limit_bytes = asked.memory_limit_bytes};
    if (asked.progress) {
        context.progress = progress;
    }
    lend_threads(context);
    auto outcome = [&] {
        const py::gil_scoped_release released;
        return work(std::as_const(context));
    }();
    if (!outcome) {
        if (PyErr_Occurred() != nullptr) {
            throw py::error_already_set();
        }
        raise(outcome.error());
    }
    caller.finish();
    return taken(std::move(outcome));
}
template <class Work>
auto run(Work&& work) {
    return run(Asked{}, std::forward<Work>(work));
}

/// Meshes in arrays of Python, which it keeps alive.
class View {
public:
    /// Each mesh is (vertices, faces or None, mm per unit, 3x4 placement or None, role, object, Prepared or None, places or
    /// None). Arrays are as _mesh.py leaves them.
    View(const py::list& meshes, bool as_parts);

    Source source() const noexcept { return as_parts_ ? Source(parts_) : Source(mesh()); }
    /// Precondition: it has one.
    const MeshView& mesh() const noexcept { return parts_.front().mesh; }
    std::size_t size() const noexcept { return parts_.size(); }

private:
    std::vector<py::object> arrays_;
    std::vector<Part> parts_;
    bool as_parts_;
};

/// Memory of calls and results that are over, for those to come: fresh pages cost a slice of a small mesh more than its
/// arithmetic. Whoever finds it in use by another thread goes without: nobody waits, and a forked process does not hang
/// where its parent held the lock.
template <class T>
class Spares {
public:
    explicit Spares(std::size_t most) { kept_.reserve(most); }

    T take() noexcept {
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock || kept_.empty()) {
            return T();
        }
        T taken = std::move(kept_.back());
        kept_.pop_back();
        return taken;
    }
    void give(T&& used, std::size_t bytes) noexcept {
        constexpr std::size_t most_bytes = std::size_t{64} << 20;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock && bytes != 0 && bytes <= most_bytes && kept_.size() < kept_.capacity()) {
            kept_.push_back(std::move(used));
        }
    }

private:
    std::mutex mutex_;
    std::vector<T> kept_;
};

/// A result that arrays look into.
class HeldResult {
public:
    explicit HeldResult(SliceResult sliced) noexcept : result(std::move(sliced)) {}
    HeldResult(HeldResult&&) noexcept = default;
    HeldResult& operator=(HeldResult&&) = delete;
    ~HeldResult();

    SliceResult result;
};

inline py::array read_only(py::array array) {
    array.attr("setflags")("write"_a = false);
    return array;
}

/// A copy of a range's elements.
template <class Range>
py::array copy_of(const Range& range, const py::dtype& type) {
    return py::array(type, {static_cast<py::ssize_t>(range.size())}, range.data());
}
/// The elements where they lie, in memory that `owner` has and the array keeps.
template <class Range>
py::array view_of(const Range& range, const py::dtype& type, const py::object& owner) {
    return read_only(py::array(type, {static_cast<py::ssize_t>(range.size())}, range.data(), owner));
}

struct Field {
    const char* name;
    const char* format;
    std::size_t offset;
};

/// A structured type of some members of `T`.
template <class T>
py::dtype type_of(const std::vector<Field>& fields) {
    py::list names;
    py::list formats;
    py::list offsets;
    for (const Field& field : fields) {
        names.append(field.name);
        formats.append(field.format);
        offsets.append(field.offset);
    }
    return py::dtype(names, formats, offsets, sizeof(T));
}

void define_tracks(py::module_& module);
void define_measures(py::module_& module);
void define_stream(py::module_& module);
void define_compare(py::module_& module);
void define_sections(py::module_& module);
void define_medical(py::module_& module);
void define_options(py::module_& module);
void define_meshes(py::module_& module);
void define_slicing(py::module_& module);
void define_results(py::module_& module);
void define_overlay(py::module_& module);

}  // namespace lamella::python
