// The module: errors, signals, forks, progress and options.
#include <pthread.h>

#include <algorithm>
#include <array>
#include <exception>

#include "lamella/version.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

/// By ErrorCode.
constexpr std::array names = {"invalid_argument", "unreadable_file",  "malformed_mesh", "empty_mesh", "bad_coordinate",
                              "bad_planes",       "result_too_large", "out_of_memory",  "cancelled",  "unwritable_file"};
static_assert(names.size() == static_cast<std::size_t>(ErrorCode::unwritable_file) + 1);

std::atomic<bool> is_forked = false;

void run_on_threads(void* /*context*/, int workers, void (*body)(void*) noexcept, void* argument) noexcept {
    std::vector<std::thread> threads;
    try {
        for (int worker = 1; worker < workers; ++worker) {
            threads.emplace_back(body, argument);
        }
    } catch (const std::exception&) {
        // Those that there are do the work.
    }
    body(argument);
    for (std::thread& thread : threads) {
        thread.join();
    }
}

py::object index_or_none(std::int64_t index) {
    return index < 0 ? py::object(py::none()) : py::object(py::int_(index));
}

bool is_main_thread() {
    const py::object main = py::module_::import("threading").attr("main_thread")().attr("ident");
    return main.cast<unsigned long>() == PyThread_get_thread_ident();
}

/// Python's defaults, which are the tool's.
SliceOptions default_options() {
    SliceOptions options;
    options.region.fill_rule = FillRule::non_zero;
    return options;
}

void set_heights(SliceOptions& options, const py::array_t<double, py::array::c_style>& heights) {
    options.plan.spacing = ExplicitPlanes{{heights.data(), heights.data() + heights.size()}};
}

void set_layers(SliceOptions& options, double height_mm, const py::object& first_height_mm, bool from_zero) {
    UniformLayers layers{.layer_height_mm = height_mm, .datum = from_zero ? Datum::zero : Datum::mesh_min};
    if (!first_height_mm.is_none()) {
        layers.first_height_mm = first_height_mm.cast<double>();
    }
    options.plan.spacing = layers;
}

void set_fill_from(SliceOptions& options, const py::list& changes) {
    options.region.fill_from.clear();
    for (const py::handle change : changes) {
        const auto [layer, rule] = change.cast<std::pair<std::uint64_t, int>>();
        options.region.fill_from.push_back({layer, static_cast<FillRule>(rule)});
    }
}

void set_threads(SliceOptions& options, std::int64_t threads) {
    if (threads > 4096) {
        raise({ErrorCode::invalid_argument, "threads must be at most 4096, and are " + std::to_string(threads)});
    }
    options.control.threads = static_cast<int>(threads);
}

/// Writes one number of a SliceOptions.
template <class Get>
auto number(Get get) {
    return [get](SliceOptions& options, double value) { get(options) = value; };
}

template <class Get>
auto flag(Get get) {
    return [get](SliceOptions& options, bool value) { get(options) = value; };
}

/// The index of a choice, which _options.py has checked.
template <class Get>
auto choice(Get get) {
    return [get](SliceOptions& options, int value) {
        auto& place = get(options);
        place = static_cast<std::remove_reference_t<decltype(place)>>(value);
    };
}

py::array_t<double> from_normal(double x, double y, double z) {
    const Transform turn = Transform::from_normal(x, y, z);
    return py::array_t<double>({3, 4}, turn.m.data());
}

}  // namespace

py::str text_of(const std::string& text) {
    return py::reinterpret_steal<py::str>(
        PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace"));
}

void raise(const Error& error) {
    const py::object kinds = py::module_::import("lamella._errors").attr("BY_CODE");
    const py::object kind = kinds[names.at(static_cast<std::size_t>(error.code))];
    const py::object exception =
        kind(text_of(error.message), py::arg("triangle") = index_or_none(error.triangle),
             py::arg("layer") = index_or_none(error.plane), py::arg("byte_offset") = index_or_none(error.byte_offset));
    PyErr_SetObject(kind.ptr(), exception.ptr());
    throw py::error_already_set();
}

Executor executor_here() noexcept {
    if (!is_forked.load()) {
        return {};
    }
    return {&run_on_threads, nullptr, std::max(1, static_cast<int>(std::thread::hardware_concurrency()))};
}

Progress progress_of(const py::object& callable) {
    return {[](void*, double) noexcept {}, callable.ptr()};
}

Caller::Caller(const Progress& progress)
    : thread_(std::this_thread::get_id()),
      main_thread_(is_main_thread()),
      report_(static_cast<PyObject*>(progress.context)) {}

StopCheck Caller::check() noexcept {
    return {[](void* context) noexcept { return static_cast<Caller*>(context)->requested(); }, this};
}

Progress Caller::progress() noexcept {
    if (report_ == nullptr) {
        return {};
    }
    return {[](void* context, double fraction) noexcept {
                static_cast<Caller*>(context)->reached_.store(fraction, std::memory_order_relaxed);
            },
            this};
}

bool Caller::requested() noexcept {
    if (raised_.load(std::memory_order_relaxed)) {
        return true;
    }
    if (std::this_thread::get_id() != thread_ || Clock::now() < next_look_) {
        return false;
    }
    const bool raised = look();
    next_look_ = Clock::now() + interval;  // after a slow report the engine gets its turn
    return raised;
}

bool Caller::look() noexcept {
    if (main_thread_ || report_ != nullptr) {
        const py::gil_scoped_acquire acquired;
        if ((main_thread_ && PyErr_CheckSignals() != 0) || !report()) {
            raised_.store(true, std::memory_order_relaxed);
        }
    }
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
    if (raised_.load(std::memory_order_relaxed)) {  // as the last stop was looked for
        throw py::error_already_set();
    }
    reached_.store(1, std::memory_order_relaxed);
    if (!report()) {
        throw py::error_already_set();
    }
}

void define_options(py::module_& module) {
    const auto set = [](auto& options, const char* name, auto setter) {
        options.def_property(name, py::cpp_function(), py::cpp_function(setter, py::is_method(options)));
    };
    py::class_<SliceOptions> options(module, "Options");
    options.def(py::init(&default_options)).def("set_heights", &set_heights).def("set_layers", &set_layers);
    set(options, "fill_from", &set_fill_from);
    set(options, "threads", &set_threads);
    options.def(
        "set_progress", [](SliceOptions& o, const py::object& callable) { o.control.progress = progress_of(callable); },
        py::keep_alive<1, 2>());
    set(options, "transform",
        [](SliceOptions& o, const py::array_t<double>& matrix) { o.transform = transform_of(matrix); });
    set(options, "memory_limit", [](SliceOptions& o, std::uint64_t bytes) { o.memory_limit_bytes = bytes; });
    set(options, "side", choice([](SliceOptions & o) -> auto& { return o.plan.side; }));
    set(options, "fill_rule", choice([](SliceOptions & o) -> auto& { return o.region.fill_rule; }));
    set(options, "gap_sense", choice([](SliceOptions & o) -> auto& { return o.gap_sense; }));
    set(options, "unit_mm", number([](SliceOptions & o) -> auto& { return o.unit_mm; }));
    set(options, "close_mm", number([](SliceOptions & o) -> auto& { return o.region.close_mm; }));
    set(options, "offset_mm", number([](SliceOptions & o) -> auto& { return o.region.offset_mm; }));
    set(options, "miter_limit", number([](SliceOptions & o) -> auto& { return o.region.miter_limit; }));
    set(options, "simplify_mm", number([](SliceOptions & o) -> auto& { return o.region.simplify_mm; }));
    set(options, "mark_near_mm", number([](SliceOptions & o) -> auto& { return o.region.mark_near_mm; }));
    set(options, "close_gaps_mm", number([](SliceOptions & o) -> auto& { return o.close_gaps_mm; }));
    set(options, "largest_only", flag([](SliceOptions & o) -> auto& { return o.region.largest_only; }));
    set(options, "drop_collinear", flag([](SliceOptions & o) -> auto& { return o.region.drop_collinear; }));
    set(options, "origins", flag([](SliceOptions & o) -> auto& { return o.origins; }));
    set(options, "allow_empty", flag([](SliceOptions & o) -> auto& { return o.allow_empty; }));
    module.attr("UNIT_BY_BOX") = unit_by_box;
    module.attr("GAPS_BY_MESH") = gaps_by_mesh;
    module.def("from_normal", &from_normal);
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
    python::define_stream(module);
    python::define_checks(module);
}
