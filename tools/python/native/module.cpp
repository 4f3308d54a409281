// The module: errors, signals, forks, progress, and options by name: each that engine/options/options.toml describes is read
// and written here, and named nowhere.
#include <pthread.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <type_traits>

#include "lamella/check.hpp"
#include "lamella/heights.hpp"
#include "lamella/io/check_report.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/lamella.h"
#include "lamella/version.hpp"
#include "lamella/weld.hpp"
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
/// Rows of doubles as structs of as many.
template <class Row>
std::vector<Row> rows_from(const py::handle& given) {
    const auto rows = py::reinterpret_borrow<py::array_t<double, py::array::c_style>>(given);
    std::vector<Row> made(static_cast<std::size_t>(rows.shape(0)));
    std::copy_n(rows.data(), rows.size(), reinterpret_cast<double*>(made.data()));
    return made;
}
void read_value(const py::handle& given, std::vector<Slab>& to) {
    to = given.is_none() ? std::vector<Slab>() : rows_from<Slab>(given);
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
template <class Slabs>
py::array_t<double> rows_of_slabs(const Slabs& slabs) {
    const std::array<py::ssize_t, 2> shape = {static_cast<py::ssize_t>(slabs.size()), 2};
    return py::array_t<double>(shape, reinterpret_cast<const double*>(slabs.data()));
}
py::object value_of(const std::vector<Slab>& slabs) {
    return slabs.empty() ? py::none() : py::object(rows_of_slabs(slabs));
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

// --- meshes: in arrays of Python, from files, welded, turned, checked

Number number_of(const py::array& numbers) {
    const bool wide = numbers.itemsize() == 8;
    if (numbers.dtype().kind() == 'f') {
        return wide ? Number::f64 : Number::f32;
    }
    return wide ? Number::i64 : Number::i32;
}

MeshView mesh_of(const py::array& vertices, const py::object& faces, double mm_per_unit) {
    const auto rows = static_cast<std::size_t>(vertices.shape(0));
    MeshView mesh{.vertices = vertices.data(),
                  .vertex_stride = static_cast<std::size_t>(vertices.strides(0)),
                  .vertex_type = number_of(vertices),
                  .mm_per_unit = mm_per_unit};
    if (faces.is_none()) {
        mesh.triangle_count = rows;
        return mesh;
    }
    const auto indices = py::reinterpret_borrow<py::array>(faces);
    mesh.vertex_count = rows;
    mesh.triangle_count = static_cast<std::size_t>(indices.shape(0));
    mesh.indices = indices.data();
    mesh.index_stride = static_cast<std::size_t>(indices.strides(0));
    mesh.index_type = indices.itemsize() == 4 ? Number::u32 : Number::u64;
    return mesh;
}

py::array rows_of(const void* data, const py::dtype& number, std::size_t rows, std::size_t step, int width,
                  const py::object& owner) {
    return read_only(py::array(number, {static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(width)},
                               {static_cast<py::ssize_t>(step), number.itemsize()}, data, owner));
}

/// A mesh of the engine as arrays, which keep it. Has a view().
template <class Mesh>
py::dict arrays_of(Mesh&& mesh, const py::dict& info) {
    const auto* const kept = new Mesh(std::move(mesh));
    const py::capsule owner(kept, [](void* held) { delete static_cast<Mesh*>(held); });
    const MeshView view = kept->view();
    const bool soup = view.indices == nullptr;
    const py::dtype number = view.vertex_type == Number::f32 ? py::dtype::of<float>() : py::dtype::of<double>();
    const py::array vertices = rows_of(view.vertices, number, soup ? view.triangle_count : view.vertex_count,
                                       view.vertex_step(), soup ? 9 : 3, owner);
    const auto faces = [&] {
        return rows_of(view.indices, py::dtype::of<std::uint32_t>(), view.triangle_count, view.index_step(), 3, owner);
    };
    return py::dict("vertices"_a = vertices, "faces"_a = soup ? py::object(py::none()) : py::object(faces()),
                    "unit"_a = view.mm_per_unit, "info"_a = info);
}

py::dict info_of(const MeshFile& file) {
    py::list parts;
    for (const MeshPart& part : file.parts) {
        parts.append(py::dict("name"_a = text_of(part.name), "role"_a = name_of(part.role),
                              "first_triangle"_a = part.first_triangle, "triangles"_a = part.triangle_count));
    }
    return py::dict("format"_a = name_of(file.format), "text"_a = file.text, "compressed"_a = file.compressed,
                    "states_unit"_a = file.states_unit, "patient_frame"_a = name_of(file.patient_frame),
                    "bytes"_a = file.file_bytes, "parts"_a = parts);
}

/// Values by their names, a row each vertex, and whether they are integers.
py::list scalars_of(const MeshFile& file) {
    py::list made;
    for (const VertexScalars& scalars : file.scalars) {
        const auto rows = static_cast<py::ssize_t>(file.vertex_count);
        const py::array values =
            scalars.components == 1
                ? py::array_t<double>(rows, scalars.values.data())
                : py::array_t<double>({rows, static_cast<py::ssize_t>(scalars.components)}, scalars.values.data());
        made.append(py::make_tuple(text_of(scalars.name), values, scalars.integers));
    }
    return made;
}

py::dict read(const std::string& path, double mm_per_unit, bool scalars, const Asked& asked) {
    MeshFile file = run(asked, [&](const Context& context) {
        return read_mesh(std::filesystem::path(path), {.mm_per_unit = mm_per_unit, .scalars = scalars}, context);
    });
    py::list warnings;
    for (const std::string& warning : file.warnings) {
        warnings.append(text_of(warning));
    }
    const py::dict info = info_of(file);
    const py::list values = scalars_of(file);
    py::dict mesh = arrays_of(std::move(file), info);
    mesh["warnings"] = warnings;
    mesh["scalars"] = values;
    return mesh;
}

py::dict weld_mesh(const View& view, double tolerance_mm, const Asked& asked) {
    WeldedMesh welded = run(asked, [&](const Context& context) { return weld(view.mesh(), tolerance_mm, context); });
    const py::dict info("joined"_a = welded.joined, "largest_move"_a = welded.largest_move_mm,
                        "tolerance"_a = welded.tolerance_mm);
    return arrays_of(std::move(welded), info);
}

py::dict orient_mesh(const View& view, const Asked& asked) {
    OrientedMesh turned = run(asked, [&](const Context& context) { return orient_shells(view.mesh(), 0, context); });
    const py::dict info("shells"_a = turned.shells, "turned"_a = turned.turned_shells, "complete"_a = turned.complete);
    return arrays_of(std::move(turned.mesh), info);
}

py::array shells_of(const MeshCheck& check) {
    return copy_of(check.shells, type_of<MeshShell>({{"triangles", "i8", offsetof(MeshShell, triangles)},
                                                     {"closed", "?", offsetof(MeshShell, closed)},
                                                     {"volume", "f8", offsetof(MeshShell, volume_mm3)},
                                                     {"orientation", "i4", offsetof(MeshShell, orientation)},
                                                     {"depth", "i4", offsetof(MeshShell, depth)},
                                                     {"parent", "i8", offsetof(MeshShell, parent)},
                                                     {"triangle", "i8", offsetof(MeshShell, triangle)},
                                                     {"first", "3f8", offsetof(MeshShell, first_mm)}}));
}

/// By the key of their kind: count, whether it is a lower bound, and places.
py::dict findings_of(const MeshCheck& check) {
    const py::dtype place = type_of<FaultPlace>({{"points", "(3,3)f8", offsetof(FaultPlace, points_mm)},
                                                 {"point_count", "i4", offsetof(FaultPlace, point_count)},
                                                 {"triangles", "2i8", offsetof(FaultPlace, triangles)},
                                                 {"parts", "i8", offsetof(FaultPlace, parts)},
                                                 {"measure", "f8", offsetof(FaultPlace, measure)},
                                                 {"closed", "?", offsetof(FaultPlace, closed)}});
    py::dict made;
    for (std::size_t i = 0; i < fault_count; ++i) {
        const FaultFinding& found = check.findings[i];
        made[py::cast(key_of(static_cast<Fault>(i)))] =
            py::make_tuple(found.count, found.at_least, copy_of(found.places, place));
    }
    return made;
}

py::dict info_of(const MeshCheck& check) {
    return py::dict("triangles"_a = check.triangles, "degenerate"_a = check.degenerate, "min"_a = check.box.min_mm,
                    "max"_a = check.box.max_mm, "volume"_a = check.volume_mm3, "area"_a = check.area_mm2,
                    "edges"_a = check.edges, "boundary_edges"_a = check.boundary_edges,
                    "overfull_edges"_a = check.overfull_edges, "mismatched_edges"_a = check.mismatched_edges,
                    "shells"_a = check.shell_count, "closed"_a = check.closed, "grid"_a = check.grid_mm);
}

py::dict check_mesh(const View& view, const Asked& asked, double tolerance_mm, double sliver_ratio, std::size_t most_places,
                    bool counts_only) {
    const MeshCheck found = run(asked, [&](const Context& context) {
        return check(view.mesh(),
                     {.frame = asked.options.frame,
                      .counts_only = counts_only,
                      .tolerance_mm = tolerance_mm,
                      .sliver_ratio = sliver_ratio,
                      .most_places = most_places},
                     context);
    });
    return py::dict("verdict"_a = run([&](const Context& /*lent*/) { return make_verdict(found); }),
                    "clean"_a = found.clean(), "complete"_a = found.complete(), "info"_a = info_of(found),
                    "shells"_a = shells_of(found), "findings"_a = findings_of(found));
}

/// `mm`: the lengths of AdaptiveOptions, in their order.
py::array adaptive(const View& view, const Asked& asked, const std::array<double, 8>& mm, const py::array& ranges) {
    const std::vector<HeightRange> own = rows_from<HeightRange>(ranges);
    const AdaptiveOptions how{mm[0], mm[1], mm[2], mm[3], mm[4], mm[5], mm[6], mm[7], own, asked.options.frame};
    return rows_of_slabs(run(asked, [&](const Context& context) { return adaptive_layers(view.source(), how, context); }));
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

View::View(const py::list& meshes, bool as_parts) : as_parts_(as_parts) {
    for (const py::handle mesh : meshes) {
        const auto given = py::reinterpret_borrow<py::tuple>(mesh);
        const py::object vertices = given[0];
        const py::object faces = given[1];
        Part& part = parts_.emplace_back();
        part.mesh = mesh_of(py::reinterpret_borrow<py::array>(vertices), faces, py::float_(given[2]));
        if (const py::object placement = given[3]; !placement.is_none()) {
            read_value(placement, part.placement);
        }
        part.role = static_cast<PartRole>(py::cast<int>(given[4]));
        part.object = py::cast<std::uint32_t>(given[5]);
        if (const py::object prepared = given[6]; !prepared.is_none()) {
            part.prepared = &py::cast<const PreparedMesh&>(prepared);
            arrays_.push_back(prepared);
        }
        if (const py::object places = given[7]; !places.is_none()) {
            const auto rows = py::reinterpret_borrow<py::array_t<double>>(places);
            part.at_mm = {reinterpret_cast<const std::array<double, 3>*>(rows.data()),
                          static_cast<std::size_t>(rows.shape(0))};
            arrays_.push_back(places);
        }
        arrays_.push_back(vertices);
        arrays_.push_back(faces);
    }
}

void define_meshes(py::module_& module) {
    py::class_<View>(module, "View").def(py::init<const py::list&, bool>());
    module.def("read", &read);
    module.def("weld", &weld_mesh);
    module.def("orient_shells", &orient_mesh);
    module.def("check", &check_mesh);
    module.def("adaptive_layers", &adaptive);
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
    python::define_overlay(module);
    python::define_tracks(module);
    python::define_measures(module);
    python::define_stream(module);
    python::define_compare(module);
    python::define_sections(module);
    python::define_medical(module);
}
