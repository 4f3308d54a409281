// Slicing into results.
#include <algorithm>
#include <cmath>

#include "lamella/assemble.hpp"
#include "lamella/prepare.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

std::size_t bytes_of(const SliceResult& result) noexcept {
    return result.points.capacity() * sizeof(Point) + result.origins.capacity() * sizeof(PointOrigin) +
           result.contours.capacity() * sizeof(Contour) + result.layers.capacity() * sizeof(Layer);
}

/// Results live as long as arrays look into them: what a small one has of a large one's memory would be wasted.
template <class T>
void give_back_waste(Array<T>& array) {
    constexpr std::size_t little = std::size_t{1} << 20;
    if ((array.capacity() / 2 - std::min(array.size(), array.capacity() / 2)) * sizeof(T) > little) {
        Array<T> whole;
        whole.resize_discarding(array.size());
        std::copy(array.begin(), array.end(), whole.begin());
        array = std::move(whole);
    }
}

/// `mesh` is a MeshView or a PreparedMesh.
template <class Mesh>
HeldResult slice_with_spares(const Mesh& mesh, SliceOptions& options) {
    HeldResult held(Spares::all().take_result());
    Workspace workspace = Spares::all().take_workspace();
    run(options.control, [&](const Control& control) {
        options.control = control;
        return slice(mesh, options, workspace, held.result);
    });
    Spares::all().give(std::move(workspace));
    give_back_waste(held.result.layers);
    give_back_waste(held.result.contours);
    give_back_waste(held.result.points);
    give_back_waste(held.result.origins);
    return held;
}

HeldResult slice_mesh(const View& view, SliceOptions options) {
    options.transform = view.to_planes(options.transform);
    return slice_with_spares(view.mesh(), options);
}

HeldResult slice_meshes(const View& view, SliceOptions options, bool united) {
    return {run(options.control, [&](const Control& control) {
        options.control = control;
        return slice_parts(view.parts(), options, united ? PartRegions::united : PartRegions::separate);
    })};
}

PreparedMesh prepare_mesh(const View& view, const SliceOptions& options) {
    return run(options.control, [&](const Control& control) {
        return prepare(view.mesh(),
                       {.unit_mm = options.unit_mm, .transform = view.to_planes(options.transform), .control = control});
    });
}

HeldResult slice_prepared(const View&, SliceOptions options, const PreparedMesh& mesh) {
    return slice_with_spares(mesh, options);
}

/// On the grid of `unit_mm`.
Point round_to_grid(const double* xy, double unit_mm, py::ssize_t segment) {
    const auto round = [&](double mm) {
        const double units = std::nearbyint(mm / unit_mm);
        if (!(std::fabs(units) <= grid_limit)) {
            raise({ErrorCode::bad_coordinate, "segments[" + std::to_string(segment) +
                                                  "] has a coordinate that is not finite or beyond 2^30 grid units"});
        }
        return static_cast<std::int32_t>(units);
    };
    return {round(xy[0]), round(xy[1])};
}

EndKey key_of(Point point) {
    return {static_cast<std::uint32_t>(point.x), static_cast<std::uint32_t>(point.y), 1};
}

/// Made of rows (x, y, x, y) in mm and of pairs of keys, or none.
std::vector<Segment> segments_of(const py::array_t<double>& rows, const py::object& keys, double unit_mm) {
    std::vector<Segment> segments(static_cast<std::size_t>(rows.shape(0)));
    const bool keyed = !keys.is_none();
    const auto pairs = keyed ? py::reinterpret_borrow<py::array_t<std::int64_t>>(keys) : py::array_t<std::int64_t>();
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
        Segment& segment = segments[static_cast<std::size_t>(i)];
        segment.from = round_to_grid(rows.data(i, 0), unit_mm, i);
        segment.to = round_to_grid(rows.data(i, 2), unit_mm, i);
        segment.from_key = keyed ? EndKey{static_cast<std::uint64_t>(pairs.at(i, 0))} : key_of(segment.from);
        segment.to_key = keyed ? EndKey{static_cast<std::uint64_t>(pairs.at(i, 1))} : key_of(segment.to);
    }
    return segments;
}

HeldResult assemble_segments(const py::array_t<double, py::array::c_style>& rows, const py::object& keys, double unit_mm) {
    const std::vector<Segment> segments = segments_of(rows, keys, unit_mm);
    LayerContours made = run(Control{}, [&](const Control& control) { return assemble(segments, control); });
    HeldResult held{SliceResult{}};
    SliceResult& result = held.result;
    result.contours = std::move(made.contours);
    result.points = std::move(made.points);
    result.unit_mm = unit_mm;
    result.layers.resize_discarding(1);
    result.layers[0] = {};
    result.layers[0].contour_count = result.contours.size();
    result.layers[0].segments = segments.size();
    result.summary.segments = segments.size();
    for (const Contour& contour : result.contours) {
        count(contour, result.summary);
    }
    return held;
}

}  // namespace

Spares& Spares::all() noexcept {
    static Spares& spares = []() -> Spares& {
        auto* const made = new Spares;
        made->workspaces_.reserve(most_workspaces);
        return *made;
    }();
    return spares;
}

Workspace Spares::take_workspace() noexcept {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || workspaces_.empty()) {
        return {};
    }
    Workspace taken = std::move(workspaces_.back());
    workspaces_.pop_back();
    return taken;
}

SliceResult Spares::take_result() noexcept {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    return lock ? std::exchange(result_, SliceResult{}) : SliceResult{};
}

void Spares::give(Workspace&& workspace) noexcept {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && workspaces_.size() < most_workspaces && workspace.bytes() <= most_bytes) {
        workspaces_.push_back(std::move(workspace));
    }
}

void Spares::give(SliceResult&& result) noexcept {
    const std::size_t bytes = bytes_of(result);
    if (bytes == 0 || bytes > most_bytes) {
        return;
    }
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && bytes > bytes_of(result_)) {
        result_ = std::move(result);
    }
}

void count(const Contour& contour, SliceSummary& summary) noexcept {
    summary.holes += contour.role == Role::hole ? 1 : 0;
    summary.open_contours += contour.role == Role::open ? 1 : 0;
    summary.flat_contours += contour.role == Role::flat ? 1 : 0;
    summary.overruled_contours += (contour.flags & orientation_overruled) != 0 ? 1 : 0;
    summary.near_contours += (contour.flags & near_contour) != 0 ? 1 : 0;
}

void define_slicing(py::module_& module) {
    py::class_<PreparedMesh>(module, "Prepared")
        .def_property_readonly("nbytes", &PreparedMesh::bytes)
        .def_property_readonly("unit_mm", &PreparedMesh::unit_mm);
    module.def("slice", &slice_mesh);
    module.def("slice_parts", &slice_meshes);
    module.def("prepare", &prepare_mesh);
    module.def("slice_prepared", &slice_prepared);
    module.def("assemble", &assemble_segments);
}

}  // namespace lamella::python
