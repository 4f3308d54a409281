// Results: slicing into them, views of their arrays, numbers computed of them, audits, and files written; and contours of
// segments and of other contours.
#include <pybind11/stl.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <span>
#include <type_traits>

#include "lamella/audit.hpp"
#include "lamella/check.hpp"
#include "lamella/io/layer_file.hpp"
#include "lamella/io/report.hpp"
#include "lamella/io/text_file.hpp"
#include "lamella/layers.hpp"
#include "lamella/version.hpp"
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

/// `value` of each, computed without the interpreter.
template <class Range, class Value>
py::array_t<double> numbers_of(const Range& range, Value value) {
    py::array_t<double> numbers(static_cast<py::ssize_t>(range.size()));
    double* out = numbers.mutable_data();
    const py::gil_scoped_release released;
    for (auto&& each : range) {
        *out++ = value(each);
    }
    return numbers;
}

double length_mm(const SliceResult& result, const Contour& contour) {
    const auto points = result.points_of(contour);
    const auto distance = [](Point a, Point b) {
        const double dx = static_cast<double>(a.x) - b.x;
        const double dy = static_cast<double>(a.y) - b.y;
        return std::sqrt(dx * dx + dy * dy);
    };
    double length = contour.role == Role::open || points.empty() ? 0 : distance(points.back(), points.front());
    for (std::size_t i = 1; i < points.size(); ++i) {
        length += distance(points[i - 1], points[i]);
    }
    return length * result.info.grid_mm;
}

py::array_t<double> areas(const HeldResult& held) {
    return numbers_of(held.result, [](const LayerView& layer) { return layer.area_mm2(); });
}
py::array_t<double> contour_areas(const HeldResult& held) {
    LayerView any;
    any.grid_mm = held.result.info.grid_mm;
    return numbers_of(held.result.contours, [&](const Contour& contour) { return any.area_mm2(contour); });
}
py::array_t<double> contour_lengths(const HeldResult& held) {
    return numbers_of(held.result.contours, [&](const Contour& contour) { return length_mm(held.result, contour); });
}

OpenLayers open_layers(const HeldResult& held) {
    const Audit found = run([&](const Context& context) {
        return audit(held.result, MeshView{}, {.volume = false, .ledger = false, .crossings = false}, context);
    });
    return *found.open;
}

/// What a result states beside its options, by the names of Python.
template <class Info, class Visit>
void each_figure(Info& info, Visit visit) {
#define COUNTER(name) visit(#name, info.name);
#include "options/counters.inc"
    visit("grid", info.grid_mm);
    visit("grid_doublings", info.grid_doublings);
    visit("min", info.box.min_mm);
    visit("max", info.box.max_mm);
    visit("threads", info.threads);
    visit("bucket_ms", info.ms.bucket);
    visit("sweep_ms", info.ms.sweep);
    visit("contours_ms", info.ms.contours);
    visit("nesting_ms", info.ms.nesting);
    visit("fill_ms", info.ms.fill);
}

py::dict figures_of(const SliceInfo& info) {
    py::dict made;
    each_figure(info, [&](const char* name, const auto& figure) { made[name] = figure; });
    return made;
}

py::dict info(const HeldResult& held) {
    py::dict made = figures_of(held.result.info);
    const OpenLayers open = open_layers(held);
    made["open_layers"] = open.layers;
    made["crossed_layers"] = open.crossed;
    made["open_height_share"] = open.share();
    made["closing_stitch"] = open.layers > open.stuck ? py::cast(open.reach_mm) : py::none();
    return made;
}

/// Step of the grid, the mesh's diagonal and the finest step for it, in mm, where the grid is coarse for the mesh; else
/// None.
py::object coarse_grid(const HeldResult& held, const View& view) {
    const SliceInfo& info = held.result.info;
    if (info.triangles == 0) {
        return py::none();
    }
    const MeshScale scale = judge_scale(info.box, view.mesh().vertex_type, info.grid_mm);
    return scale.coarse_grid ? py::make_tuple(info.grid_mm, scale.diagonal_mm, scale.finest_grid_mm)
                             : py::object(py::none());
}

/// The arrays that pickle keeps, in their order.
template <class Held, class Visit>
void each_array(Held& result, Visit visit) {
    visit(result.layers);
    visit(result.contours);
    visit(result.points);
    visit(result.origins);
    visit(result.stitches);
}

py::dtype copy_type() {
    return type_of<PartCopy>({{"part", "u4", offsetof(PartCopy, part)},
                              {"first", "u4", offsetof(PartCopy, first)},
                              {"move_grid", "2i4", offsetof(PartCopy, move)}});
}

py::tuple state(const py::object& self) {
    const SliceResult& result = self.cast<const HeldResult&>().result;
    py::list arrays;
    each_array(result, [&](const auto& array) {
        arrays.append(view_of(std::as_bytes(std::span(array)), py::dtype::of<std::uint8_t>(), self));
    });
    return py::make_tuple(version, arrays, dict_of(result.info.options), figures_of(result.info), result.info.layer_of,
                          copy_of(result.info.copies, copy_type()));
}

HeldResult restore(const py::tuple& state) {
    if (state.size() != 6 || state[0].cast<std::string>() != version) {
        raise({ErrorCode::invalid_argument, "the result was pickled by another version of lamella"});
    }
    SliceResult result;
    const auto arrays = py::reinterpret_borrow<py::list>(state[1]);
    each_array(result, [&, next = std::size_t{0}](auto& array) mutable {
        const auto bytes = arrays[next++].template cast<py::array_t<std::uint8_t, py::array::c_style>>();
        array.resize_discarding(static_cast<std::size_t>(bytes.size()) / sizeof(*array.data()));
        if (!array.empty()) {
            std::memcpy(static_cast<void*>(array.data()), bytes.data(), array.size() * sizeof(*array.data()));
        }
    });
    read_options(state[2], result.info.options);
    const py::dict figures = state[3];
    each_figure(result.info, [&](const char* name, auto& figure) {
        figure = figures[name].template cast<std::remove_reference_t<decltype(figure)>>();
    });
    result.info.layer_of = state[4].cast<std::vector<std::uint64_t>>();
    const auto copies = state[5].cast<py::array>();
    const auto* const rows = static_cast<const PartCopy*>(copies.data());
    result.info.copies.assign(rows, rows + copies.size());
    return HeldResult(std::move(result));
}

py::dict certify(const HeldResult& held, const View& view) {
    const Audit found = run([&](const Context& context) {
        return audit(held.result, view.mesh(), {.open = false, .ledger = false, .crossings = false}, context);
    });
    const VolumeCertificate& certificate = *found.volume;
    return py::dict("verdict"_a = name_of(certificate.verdict), "mesh_volume"_a = certificate.mesh_mm3,
                    "slab_volumes"_a = copy_of(certificate.slab_mm3, py::dtype::of<double>()),
                    "worst_layer"_a = certificate.worst_layer, "worst_difference"_a = certificate.worst_difference_mm2,
                    "worst_allowed"_a = certificate.worst_allowed_mm2, "differing_layers"_a = certificate.differing_layers,
                    "differing_signed"_a = certificate.differing_signed_mm2,
                    "differing_solid"_a = certificate.differing_solid_mm2);
}

/// Ledger and certificate compare with one mesh.
void write_report(const HeldResult& held, const View& view, const std::string& path) {
    const Source mesh = view.size() == 1 ? view.mesh() : MeshView{};
    const Audit found = run([&](const Context& context) { return audit(held.result, mesh, {}, context); });
    const std::string text = run([&](const Context& /*lent*/) { return make_report_json(held.result, {.audit = &found}); });
    run([&](const Context& /*lent*/) { return write_text_file(std::filesystem::path(path), text); });
}

void write_layer_file(const HeldResult& held, const std::string& path) {
    run([&](const Context& context) { return write_layers(held.result, std::filesystem::path(path), {}, context); });
}

}  // namespace

void define_results(py::module_& module) {
    py::class_<OpenLayers>(module, "OpenLayers")
        .def(py::init<>())
        .def("add", &OpenLayers::add)
        .def_readonly("layers", &OpenLayers::layers)
        .def("describe", &describe);
    py::class_<HeldResult> held(module, "Result");
    const auto view = [&held](const char* name, auto array, const py::dtype& type) {
        held.def_property_readonly(name, [array, type](const py::object& self) {
            return view_of(self.cast<const HeldResult&>().result.*array, type, self);
        });
    };
    // Counts and rows are below 2^63. As signed numbers they stay whole: numpy makes a float of the sum of an uint64 and an
    // int.
    view("layers", &SliceResult::layers,
         type_of<Layer>({{"bottom", "f8", offsetof(Layer, bottom_mm)},
                         {"z", "f8", offsetof(Layer, plane_mm)},
                         {"top", "f8", offsetof(Layer, top_mm)},
                         {"first_contour", "i8", offsetof(Layer, first_contour)},
                         {"contour_count", "i8", offsetof(Layer, contour_count)},
                         {"segments", "i8", offsetof(Layer, segments)},
                         {"z_grid", "i4", offsetof(Layer, plane)}}));
    view("contours", &SliceResult::contours,
         type_of<Contour>({{"first_point", "i8", offsetof(Contour, first_point)},
                           {"twice_area_low", "u8", offsetof(Contour, twice_area)},
                           {"twice_area_high", "i8", offsetof(Contour, twice_area) + 8},
                           {"parent", "i8", offsetof(Contour, parent)},
                           {"point_count", "u4", offsetof(Contour, point_count)},
                           {"segments", "u4", offsetof(Contour, segments)},
                           {"role", "u1", offsetof(Contour, role)},
                           {"orientation", "i1", offsetof(Contour, orientation)},
                           {"flags", "u2", offsetof(Contour, flags)},
                           {"part", "u4", offsetof(Contour, part)}}));
    view("origins", &SliceResult::origins,
         type_of<PointOrigin>({{"triangle", "u4", offsetof(PointOrigin, triangle)},
                               {"part", "u2", offsetof(PointOrigin, part)},
                               {"edge", "u1", offsetof(PointOrigin, edge)},
                               {"end_edge", "u1", offsetof(PointOrigin, end_edge)}}));
    view("stitches", &SliceResult::stitches,
         type_of<Stitch>({{"layer", "i8", offsetof(Stitch, layer)},
                          {"from_grid", "2i4", offsetof(Stitch, from)},
                          {"to_grid", "2i4", offsetof(Stitch, to)}}));
    view("points_grid", &SliceResult::points, py::dtype("(2,)i4"));
    held.def_property_readonly(
            "layer_of", [](const HeldResult& h) { return copy_of(h.result.info.layer_of, py::dtype::of<std::int64_t>()); })
        .def_property_readonly("copies", [](const HeldResult& h) { return copy_of(h.result.info.copies, copy_type()); })
        .def("areas", &areas)
        .def("contour_areas", &contour_areas)
        .def("contour_lengths", &contour_lengths)
        .def_property_readonly("options", [](const HeldResult& h) { return dict_of(h.result.info.options); })
        .def_property_readonly("info", &info)
        .def_property_readonly("grid", [](const HeldResult& h) { return h.result.info.grid_mm; })
        .def_property_readonly("first_layer", [](const HeldResult& h) { return h.result.info.first_layer; })
        .def_property_readonly("cancelled_layers", [](const HeldResult& h) { return h.result.info.cancelled_layers; })
        .def("__len__", [](const HeldResult& h) { return h.result.size(); })
        .def("open_layers", &open_layers)
        .def(
            "hash", [](const HeldResult& h) { return h.result.hash(); }, py::call_guard<py::gil_scoped_release>())
        .def("coarse_grid", &coarse_grid)
        .def("state", &state);
    module.def("restore", &restore);
    module.def("certify", &certify);
    module.def("write_report", &write_report);
    module.def("write_layers", &write_layer_file);
}

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
