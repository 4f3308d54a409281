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

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/parts.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"

namespace lamella::python {

namespace py = pybind11;

/// Throws the exception of lamella._errors that fits, with the evidence.
[[noreturn]] void raise(const Error& error);

/// Bytes that are no UTF-8 stand as \xe4.
py::str text_of(const std::string& text);

/// Where calls of the engine run: oneTBB's threads do not survive a fork, and its locks may stay locked by threads that are
/// gone. In a forked process a call therefore starts threads of its own; elsewhere there is no executor.
Executor executor_here() noexcept;

/// The thread that calls the engine: looks at the interpreter's signals if it is Python's main thread, and reports progress.
/// An exception that a handler or the report raises stays pending and ends the call.
class Caller {
public:
    /// The calling thread holds the interpreter. `progress` says which callable is told the progress, if any: see
    /// progress_of(). It outlives this.
    explicit Caller(const Progress& progress);
    StopCheck check() noexcept;
    Progress progress() noexcept;
    /// True if Python has raised. Precondition: the calling thread has released the interpreter.
    bool look() noexcept;
    /// The call has succeeded. The thread holds the interpreter again.
    void finish();

private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds interval{50};

    bool requested() noexcept;
    bool report() noexcept;

    std::thread::id thread_;
    bool main_thread_;
    PyObject* report_;                // borrowed, or null
    std::atomic<double> reached_{0};  // by the engine, on any thread
    double reported_ = 0;
    Clock::time_point next_look_ = Clock::now() + interval;  // of the calling thread alone
    std::atomic<bool> raised_ = false;
};

/// Names a Python callable where the engine takes a sink: Caller puts one in its place.
Progress progress_of(const py::object& callable);

template <class T>
T taken(Result<T>&& result) {
    return std::move(result).value();
}
inline void taken(Status&&) {}

/// The value of `work(control)`, a Result or Status, which runs without the interpreter. Raises its error.
template <class Work>
auto run(const Control& asked, Work&& work) {
    Caller caller(asked.progress);
    Control control = asked;
    control.stop = caller.check();
    control.progress = caller.progress();
    control.executor = executor_here();
    auto outcome = [&] {
        const py::gil_scoped_release released;
        return work(std::as_const(control));
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

/// Meshes in arrays of Python, which it keeps alive.
class View {
public:
    /// Each mesh is (vertices, faces or None, mm per unit, 3x4 transform or None). Arrays are as _mesh.py leaves them.
    explicit View(const py::list& meshes);

    const std::vector<Part>& parts() const noexcept { return parts_; }
    const MeshView& mesh() const noexcept { return parts_.front().mesh; }
    /// From the only mesh's coordinates to where it is sliced.
    Transform to_planes(const Transform& asked) const noexcept {
        return parts_.front().transform.is_identity() ? asked : asked * parts_.front().transform;
    }

private:
    std::vector<py::object> arrays_;
    std::vector<Part> parts_;
};

/// Memory of calls and results that are over, for those to come: fresh pages cost a slice of a small mesh more than its
/// arithmetic. One result and a few workspaces, none of more than 64 MB. Whoever finds them in use by another thread goes
/// without: nobody waits, and a forked process does not hang where its parent held the lock.
class Spares {
public:
    /// The module's own. It is never destroyed: results may go after everything else.
    static Spares& all() noexcept;

    Workspace take_workspace() noexcept;
    SliceResult take_result() noexcept;
    void give(Workspace&& workspace) noexcept;
    void give(SliceResult&& result) noexcept;

private:
    static constexpr std::size_t most_bytes = std::size_t{64} << 20;
    static constexpr std::size_t most_workspaces = 4;

    std::mutex mutex_;
    std::vector<Workspace> workspaces_;
    SliceResult result_;
};

/// A result that arrays look into.
struct HeldResult {
    HeldResult(SliceResult sliced = SliceResult{}, std::uint64_t first = 0) noexcept
        : result(std::move(sliced)), first_layer(first) {}
    HeldResult(HeldResult&&) noexcept = default;
    HeldResult& operator=(HeldResult&&) noexcept = default;
    ~HeldResult() { Spares::all().give(std::move(result)); }

    SliceResult result;
    std::uint64_t first_layer;  ///< of a chunk of layers: how many are before it
};

Transform transform_of(const py::array_t<double>& matrix);

/// Adds a contour to the counts of a result.
void count(const Contour& contour, SliceSummary& summary) noexcept;

inline py::array read_only(py::array array) {
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

/// The numbers of an Array as a numpy array that owns it.
template <class Number, class Element>
py::array own(Array<Element>&& elements, std::vector<py::ssize_t> shape) {
    auto* const kept = new Array<Element>(std::move(elements));
    const py::capsule owner(kept, [](void* array) { delete static_cast<Array<Element>*>(array); });
    return py::array(py::dtype::of<Number>(), std::move(shape), reinterpret_cast<const Number*>(kept->data()), owner);
}

void define_options(py::module_& module);
void define_meshes(py::module_& module);
void define_slicing(py::module_& module);
void define_stream(py::module_& module);
void define_results(py::module_& module);
void define_checks(py::module_& module);

}  // namespace lamella::python
