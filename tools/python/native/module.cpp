// The module: errors, signals, forks, progress, and options by name: each that engine/options/options.toml describes is read
// and written here, and named nowhere.
#include <pthread.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <exception>
#include <type_traits>

#include "lamella/lamella.h"
#include "lamella/version.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

void run_on_threads(void* /*object*/, int workers, Callback<void()> body) noexcept {
    std::vector<std::thread> threads;
    try {
        for (int worker = 1; worker < workers; ++worker) {
            threads.emplace_back(body);
        }
    } catch (const std::exception&) {
        // Those that there are do the work.
    }
    body();
    for (std::thread& thread : threads) {
        thread.join();
    }
}

bool is_main_thread() {
    const py::object main = py::module_::import("threading").attr("main_thread")().attr("ident");
    return main.cast<unsigned long>() == PyThread_get_thread_ident();
}

/// Choices by their index, which _options.py has checked.
template <class T>
void read_value(const py::handle& given, T& to) {
    using Read = std::conditional_t<std::is_enum_v<T>, int, T>;
    to = static_cast<T>(given.cast<Read>());
}
void read_value(const py::handle& given, std::optional<std::vector<double>>& to) {
    to.reset();
    if (!given.is_none()) {
        const auto heights = py::reinterpret_borrow<py::array_t<double, py::array::c_style>>(given);
        to.emplace(heights.data(), heights.data() + heights.size());
    }
}
void read_value(const py::handle& given, Transform& to) {
    const auto rows = py::reinterpret_borrow<py::array_t<double, py::array::c_style>>(given);
    std::copy_n(rows.data(), to.m.size(), to.m.begin());
}
void read_value(const py::handle& given, std::vector<FillFrom>& to) {
    to.clear();
    for (const py::handle change : given) {
        const auto [layer, rule] = change.cast<std::pair<std::uint64_t, int>>();
        to.push_back({layer, static_cast<FillRule>(rule)});
    }
}

template <class T>
py::object value_of(const T& value) {
    using Made = std::conditional_t<std::is_enum_v<T>, int, T>;
    return py::cast(static_cast<Made>(value));
}
py::object value_of(const std::optional<std::vector<double>>& heights) {
    return heights ? py::object(copy_of(*heights, py::dtype::of<double>())) : py::none();
}
py::object value_of(const Transform& transform) {
    return py::array_t<double>({3, 4}, transform.m.data());
}
py::object value_of(const std::vector<FillFrom>& changes) {
    py::list made;
    for (const FillFrom& change : changes) {
        made.append(py::make_tuple(change.first_layer, static_cast<int>(change.rule)));
    }
    return made;
}

}  // namespace

std::atomic<bool> is_forked = false;

py::str text_of(const std::string& text) {
    return py::reinterpret_steal<py::str>(
        PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace"));
}

void raise(const Error& error) {
    const py::object kinds = py::module_::import("lamella._errors").attr("BY_CODE");
    const py::object kind = kinds[lamella_status_name(static_cast<std::int32_t>(error.code) + 1)];
    py::dict evidence("triangle"_a = error.triangle, "layer"_a = error.plane, "byte_offset"_a = error.byte_offset);
    const py::object exception = kind(text_of(error.message), **evidence);
    PyErr_SetObject(kind.ptr(), exception.ptr());
    throw py::error_already_set();
}

void lend_threads(Context& context) noexcept {
    if (is_forked.load()) {
        context.executor = {nullptr, &run_on_threads};
        context.executor_threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    }
}

Caller::Caller(PyObject* report) : thread_(std::this_thread::get_id()), main_thread_(is_main_thread()), report_(report) {}

bool Caller::wants_to_stop() noexcept {
    if (raised_.load(std::memory_order_relaxed)) {
        return true;
    }
    if (std::this_thread::get_id() != thread_ || Clock::now() < next_look_) {
        return false;
    }
    if (main_thread_ || report_ != nullptr) {
        const py::gil_scoped_acquire acquired;
        raised_.store((main_thread_ && PyErr_CheckSignals() != 0) || !report(), std::memory_order_relaxed);
    }
    next_look_ = Clock::now() + interval;  // after a slow report the engine gets its turn
    return raised_.load(std::memory_order_relaxed);
}

/// False if the callable raises.
bool Caller::report() noexcept {
    const double reached = reached_.load(std::memory_order_relaxed);
    if (report_ == nullptr || reached <= reported_) {
        return true;
    }
    reported_ = reached;
    PyObject* const fraction = PyFloat_FromDouble(reached);
    PyObject* const answer = fraction != nullptr ? PyObject_CallFunctionObjArgs(report_, fraction, nullptr) : nullptr;
    Py_XDECREF(fraction);
    Py_XDECREF(answer);
    return answer != nullptr;
}

void Caller::finish() {
    if (!raised_.load(std::memory_order_relaxed)) {  // as the last stop was looked for
        reach(1);
        if (report()) {
            return;
        }
    }
    throw py::error_already_set();
}

void read_options(const py::dict& given, SliceOptions& options) {
#define OPTION(kind, name, path, ...)           \
    if (given.contains(#name)) {                \
        read_value(given[#name], options.path); \
    }
#include "options/options.inc"
}

py::dict dict_of(const SliceOptions& options) {
    py::dict made;
#define OPTION(kind, name, path, ...) made[#name] = value_of(options.path);
#include "options/options.inc"
    return made;
}

void define_options(py::module_& module) {
    py::class_<Asked>(module, "Options")
        .def(py::init([](const py::dict& options, int threads, std::uint64_t memory_limit, const py::object& progress) {
            Asked asked{.threads = threads, .memory_limit_bytes = memory_limit};
            read_options(options, asked.options);
            if (!progress.is_none()) {
                asked.progress = progress;
            }
            return asked;
        }));
    module.def("from_normal", [](double x, double y, double z) { return value_of(Transform::from_normal(x, y, z)); });
}

}  // namespace lamella::python

PYBIND11_MODULE(_native, module) {
    namespace python = lamella::python;
    module.doc() = "The engine, as the modules of lamella use it.";
    module.attr("version") = lamella::version;
    ::pthread_atfork(nullptr, nullptr, [] { python::is_forked.store(true); });
    python::define_options(module);
    python::define_meshes(module);
    python::define_results(module);
    python::define_slicing(module);
}
