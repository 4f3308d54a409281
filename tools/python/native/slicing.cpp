// Slicing into results; contours of segments and of other contours.
#include "lamella/layers.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

// Never destroyed: results may go after everything else. A forked process leaves its parent's slicers alone: to give up
// oneTBB's threads, which they hold, may wait for one that is gone.
Spares<Slicer>& spare_slicers() noexcept {
    static auto& spares = *new Spares<Slicer>(4);
    static auto& spares_of_forked = *new Spares<Slicer>(4);
    return is_forked.load() ? spares_of_forked : spares;
}
Spares<SliceResult>& spare_results() noexcept {
    static auto& spares = *new Spares<SliceResult>(1);
    return spares;
}

/// The memory that it holds, or of that what it uses.
std::size_t bytes_of(const SliceResult& result, bool used) noexcept {
    const auto bytes = [used](const auto& array) {
        return (used ? array.size() : array.capacity()) * sizeof(*array.data());
    };
    return bytes(result.points) + bytes(result.origins) + bytes(result.contours) + bytes(result.layers);
}

HeldResult slice_source(const Source& source, const Asked& asked) {
    Slicer slicer = spare_slicers().take();
    SliceResult result = spare_results().take();
    run(asked, [&](const Context& context) { return slicer.slice_to(result, source, asked.options, context); });
    const std::size_t kept = slicer.bytes();
    spare_slicers().give(std::move(slicer), kept);
    // Results live as long as arrays look into them: what a small one has of a large one's memory would be wasted.
    const std::size_t used = bytes_of(result, true);
    if (bytes_of(result, false) > 2 * used + (std::size_t{1} << 20)) {
        result = run([&](const Context& /*lent*/) { return result.copy(); });
    }
    return HeldResult(std::move(result));
}

/// The step of the grid, the first layer and the number of layers.
py::tuple outline(const View& view, const Asked& asked) {
    const SliceInfo info =
        run(asked, [&](const Context& context) { return Slicer().outline(view.source(), asked.options, context); });
    return py::make_tuple(info.grid_mm, info.first_layer, info.layers);
}

PreparedMesh prepare_mesh(const View& view, const Asked& asked) {
    return run(asked, [&](const Context& context) { return prepare(view.mesh(), asked.options.frame, context); });
}

using Rows = py::array_t<std::int32_t, py::array::c_style>;
using Keys = py::array_t<std::int64_t, py::array::c_style>;

/// Of rows (x, y, x, y) in grid units, and of pairs of keys; without keys equal points meet.
HeldResult assemble_segments(const Rows& rows, const py::object& keys, double grid_mm) {
    const auto key_of = [](Point point) {
        return EndKey{static_cast<std::uint32_t>(point.x), static_cast<std::uint32_t>(point.y), 1};
    };
    std::vector<Segment> segments(static_cast<std::size_t>(rows.shape(0)));
    const Keys pairs = keys.is_none() ? Keys() : py::reinterpret_borrow<Keys>(keys);
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const std::int32_t* const row = rows.data() + 4 * i;
        Segment& segment = segments[i];
        segment.from = {row[0], row[1]};
        segment.to = {row[2], row[3]};
        segment.from_key = keys.is_none() ? key_of(segment.from) : EndKey{static_cast<std::uint64_t>(pairs.data()[2 * i])};
        segment.to_key = keys.is_none() ? key_of(segment.to) : EndKey{static_cast<std::uint64_t>(pairs.data()[2 * i + 1])};
    }
    HeldResult held(run([&](const Context& context) { return assemble(segments, context); }));
    held.result.info.grid_mm = grid_mm;
    return held;
}

/// Of contours (n, 2) in grid units.
HeldResult region_of_contours(const py::list& contours, const Asked& asked, double grid_mm) {
    static_assert(sizeof(Point) == 2 * sizeof(std::int32_t));
    std::vector<std::span<const Point>> paths;
    for (const py::handle contour : contours) {
        const auto rows = py::reinterpret_borrow<Rows>(contour);
        paths.emplace_back(reinterpret_cast<const Point*>(rows.data()), static_cast<std::size_t>(rows.shape(0)));
    }
    return HeldResult(
        run(asked, [&](const Context& context) { return region_of(paths, asked.options.region, grid_mm, context); }));
}

}  // namespace

HeldResult::~HeldResult() {
    const std::size_t bytes = bytes_of(result, false);
    spare_results().give(std::move(result), bytes);
}

void define_slicing(py::module_& module) {
    py::class_<PreparedMesh>(module, "Prepared")
        .def_property_readonly("nbytes", &PreparedMesh::bytes)
        .def_property_readonly("grid", [](const PreparedMesh& mesh) { return mesh.frame().grid_mm; });
    module.def("slice", [](const View& view, const Asked& asked) { return slice_source(view.source(), asked); });
    module.def("slice_prepared", [](const View& /*named in errors*/, const Asked& asked, const PreparedMesh& mesh) {
        return slice_source(mesh, asked);
    });
    module.def("outline", &outline);
    module.def("prepare", &prepare_mesh);
    module.def("assemble", &assemble_segments);
    module.def("region_of", &region_of_contours);
}

}  // namespace lamella::python
