// Results: views of their arrays, and numbers computed of them.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <type_traits>

#include "lamella/audit/open_layers.hpp"
#include "lamella/mesh/scale.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

struct Field {
    const char* name;
    const char* format;
    std::size_t offset;
};

/// A type that lives as long as the process: numpy's types must not go after the interpreter.
const py::dtype& lasting_type(std::initializer_list<Field> fields, std::size_t size) {
    py::list names;
    py::list formats;
    py::list offsets;
    for (const Field& field : fields) {
        names.append(field.name);
        formats.append(field.format);
        offsets.append(field.offset);
    }
    return *new py::dtype(names, formats, offsets, static_cast<py::ssize_t>(size));
}

// Counts and rows are below 2^63. As signed numbers they stay whole: numpy makes a float of the sum of an uint64 and an int.
const py::dtype& origin_type() {
    static const py::dtype& type = lasting_type({{"triangle", "u4", offsetof(PointOrigin, triangle)},
                                                 {"part", "u2", offsetof(PointOrigin, part)},
                                                 {"edge", "u1", offsetof(PointOrigin, edge)},
                                                 {"end_edge", "u1", offsetof(PointOrigin, end_edge)}},
                                                sizeof(PointOrigin));
    return type;
}

const py::dtype& gap_type() {
    static const py::dtype& type = lasting_type({{"layer", "i8", offsetof(ClosedGap, layer)},
                                                 {"from_grid", "2i4", offsetof(ClosedGap, from)},
                                                 {"to_grid", "2i4", offsetof(ClosedGap, to)}},
                                                sizeof(ClosedGap));
    return type;
}

const py::dtype& contour_type() {
    static const py::dtype& type = lasting_type({{"first_point", "i8", offsetof(Contour, first_point)},
                                                 {"twice_area_low", "u8", offsetof(Contour, twice_area)},
                                                 {"twice_area_high", "i8", offsetof(Contour, twice_area) + 8},
                                                 {"parent", "i8", offsetof(Contour, parent)},
                                                 {"point_count", "u4", offsetof(Contour, point_count)},
                                                 {"segments", "u4", offsetof(Contour, segments)},
                                                 {"role", "u1", offsetof(Contour, role)},
                                                 {"orientation", "i1", offsetof(Contour, orientation)},
                                                 {"flags", "u2", offsetof(Contour, flags)},
                                                 {"part", "u4", offsetof(Contour, part)}},
                                                sizeof(Contour));
    return type;
}

const py::dtype& layer_type() {
    static const py::dtype& type = lasting_type({{"bottom", "f8", offsetof(Layer, bottom_mm)},
                                                 {"z", "f8", offsetof(Layer, plane_mm)},
                                                 {"top", "f8", offsetof(Layer, top_mm)},
                                                 {"first_contour", "i8", offsetof(Layer, first_contour)},
                                                 {"contour_count", "i8", offsetof(Layer, contour_count)},
                                                 {"segments", "i8", offsetof(Layer, segments)},
                                                 {"z_grid", "i4", offsetof(Layer, plane)}},
                                                sizeof(Layer));
    return type;
}

const SliceResult& result_of(const py::object& self) {
    return self.cast<const HeldResult&>().result;
}

py::array points_grid(const py::object& self) {
    const SliceResult& result = result_of(self);
    return read_only(py::array(py::dtype::of<std::int32_t>(),
                               {static_cast<py::ssize_t>(result.points.size()), py::ssize_t{2}},
                               reinterpret_cast<const std::int32_t*>(result.points.data()), self));
}

py::array points_mm(const HeldResult& held) {
    static_assert(sizeof(PointMm) == 2 * sizeof(double));
    const SliceResult& result = held.result;
    Array<PointMm> points;
    {
        const py::gil_scoped_release released;
        points.resize_discarding(result.points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i] = result.to_mm(result.points[i]);
        }
    }
    return read_only(own<double>(std::move(points), {static_cast<py::ssize_t>(result.points.size()), 2}));
}

/// `value` of each element, computed without the interpreter.
template <class Element, class Value>
py::array_t<double> numbers_of(const Array<Element>& elements, Value value) {
    py::array_t<double> numbers(static_cast<py::ssize_t>(elements.size()));
    double* const out = numbers.mutable_data();
    const py::gil_scoped_release released;
    for (std::size_t i = 0; i < elements.size(); ++i) {
        out[i] = value(elements[i]);
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
    return length * result.unit_mm;
}

/// As LayerTable does: NaN where a contour is open.
double perimeter_mm(const SliceResult& result, const Layer& layer) {
    double perimeter = 0;
    for (const Contour& contour : result.contours_of(layer)) {
        perimeter += contour.role == Role::open ? std::numeric_limits<double>::quiet_NaN() : length_mm(result, contour);
    }
    return perimeter;
}

py::array_t<double> frame(const HeldResult& held) {
    py::array_t<double> matrix({4, 4});
    std::copy(held.result.frame.m.begin(), held.result.frame.m.end(), matrix.mutable_data());
    constexpr double last[4] = {0, 0, 0, 1};
    std::copy(last, last + 4, matrix.mutable_data() + 12);
    return matrix;
}

py::tuple triple(const double (&numbers)[3]) {
    return py::make_tuple(numbers[0], numbers[1], numbers[2]);
}

OpenLayers open_layers(const HeldResult& held) {
    return run(Control{}, [&](const Control& control) { return find_open_layers(held.result, control); });
}

py::dict summary(const HeldResult& held) {
    const SliceSummary& summary = held.result.summary;
    py::dict made;
    made["triangles"] = summary.triangles;
    made["degenerate"] = summary.degenerate;
    made["crossed"] = summary.crossed;
    made["segments"] = summary.segments;
    made["holes"] = summary.holes;
    made["open_contours"] = summary.open_contours;
    const OpenLayers open = open_layers(held);
    made["open_layers"] = open.layers;
    made["crossed_layers"] = open.crossed;
    made["open_height_share"] = open.share();
    made["closing_gap"] = open.layers > open.stuck ? py::cast(open.reach_mm) : py::none();
    made["flat_contours"] = summary.flat_contours;
    made["overruled_contours"] = summary.overruled_contours;
    made["near_contours"] = summary.near_contours;
    made["emptied_layers"] = summary.emptied_layers;
    made["cancelled_layers"] = summary.cancelled_layers;
    made["threads"] = summary.threads;
    made["min"] = triple(summary.min_mm);
    made["max"] = triple(summary.max_mm);
    py::dict ms;
    ms["bucket"] = summary.ms.bucket;
    ms["sweep"] = summary.ms.sweep;
    ms["contours"] = summary.ms.contours;
    ms["nesting"] = summary.ms.nesting;
    ms["fill"] = summary.ms.fill;
    made["ms"] = ms;
    return made;
}

/// Unit, the mesh's diagonal and the finest unit for it, in mm, where the grid is coarse for the mesh; else None.
py::object coarse_grid(const HeldResult& held, const View& view) {
    const SliceSummary& summary = held.result.summary;
    const MeshScale scale = judge_scale(summary.min_mm, summary.max_mm, view.mesh().coordinate_type, held.result.unit_mm);
    if (!scale.coarse_grid || summary.triangles == 0) {
        return py::none();
    }
    return py::make_tuple(held.result.unit_mm, scale.diagonal_mm, scale.finest_unit_mm);
}

/// The fields that pickle keeps beside the arrays.
struct Rest {
    SliceSummary summary;
    Transform frame;
    double unit_mm;
    double close_gaps_mm;
    std::uint64_t first_layer;
    std::uint32_t part_count;
    PartRegions part_regions;
};
static_assert(std::is_trivially_copyable_v<Rest>);

/// The arrays that it keeps, in their order.
template <class Arrays, class Visit>
void each_array(Arrays& result, Visit visit) {
    visit(result.layers);
    visit(result.contours);
    visit(result.points);
    visit(result.origins);
    visit(result.closed_gaps);
    visit(result.layer_of);
}

py::tuple state(const py::object& self) {
    const HeldResult& held = self.cast<const HeldResult&>();
    const SliceResult& result = held.result;
    const Rest rest{result.summary,   result.frame,      result.unit_mm,     result.close_gaps_mm,
                    held.first_layer, result.part_count, result.part_regions};
    py::list arrays;
    each_array(result, [&](const auto& array) {
        using Element = std::remove_cv_t<std::remove_reference_t<decltype(array[0])>>;
        arrays.append(py::array(py::dtype::of<std::uint8_t>(), {static_cast<py::ssize_t>(array.size() * sizeof(Element))},
                                reinterpret_cast<const std::uint8_t*>(array.data()), self));
    });
    return py::make_tuple(arrays, py::bytes(reinterpret_cast<const char*>(&rest), sizeof rest));
}

template <class Element>
void restore_array(Array<Element>& array, const py::handle& bytes) {
    const auto given = py::reinterpret_borrow<py::array_t<std::uint8_t, py::array::c_style>>(bytes);
    array.resize_discarding(static_cast<std::size_t>(given.size()) / sizeof(Element));
    if (!array.empty()) {
        std::memcpy(static_cast<void*>(array.data()), given.data(), array.size() * sizeof(Element));
    }
}

HeldResult restore(const SliceOptions& options, const py::tuple& state) {
    HeldResult held;
    SliceResult& result = held.result;
    const std::string bytes = state.size() == 2 ? std::string(py::reinterpret_borrow<py::bytes>(state[1])) : std::string();
    Rest rest;
    if (bytes.size() != sizeof rest) {
        raise({ErrorCode::invalid_argument, "the result was pickled by another version of lamella"});
    }
    std::memcpy(static_cast<void*>(&rest), bytes.data(), sizeof rest);
    const auto arrays = py::reinterpret_borrow<py::list>(state[0]);
    each_array(result, [&, next = std::size_t{0}](auto& array) mutable { restore_array(array, arrays[next++]); });
    result.summary = rest.summary;
    result.frame = rest.frame;
    result.unit_mm = rest.unit_mm;
    result.close_gaps_mm = rest.close_gaps_mm;
    held.first_layer = rest.first_layer;
    result.part_count = rest.part_count;
    result.part_regions = rest.part_regions;
    result.region = options.region;
    result.plan = options.plan;
    result.gap_sense = options.gap_sense;
    return held;
}

}  // namespace

void define_results(py::module_& module) {
    // Made now: what imports numpy may let other threads run, which must not wait for a static that is being made.
    for (const auto type : {&layer_type, &contour_type, &origin_type, &gap_type}) {
        type();
    }
    py::class_<OpenLayers>(module, "OpenLayers")
        .def(py::init<>())
        .def("add", &OpenLayers::add)
        .def_readonly("layers", &OpenLayers::layers)
        .def("describe", &describe);
    py::class_<HeldResult> held(module, "Result");
    const auto view = [&held](const char* name, auto get, const auto& type) {
        held.def_property_readonly(name, [get, type](const py::object& self) {
            const auto& array = get(result_of(self));
            return read_only(py::array(type(), {static_cast<py::ssize_t>(array.size())}, array.data(), self));
        });
    };
    view(
        "layers", [](const SliceResult& r) -> auto& { return r.layers; }, &layer_type);
    view(
        "contours", [](const SliceResult& r) -> auto& { return r.contours; }, &contour_type);
    view(
        "origins", [](const SliceResult& r) -> auto& { return r.origins; }, &origin_type);
    view(
        "closed_gaps", [](const SliceResult& r) -> auto& { return r.closed_gaps; }, &gap_type);
    view(
        "layer_of", [](const SliceResult& r) -> auto& { return r.layer_of; }, &py::dtype::of<std::int64_t>);
    held.def_property_readonly("points_grid", &points_grid)
        .def("points", &points_mm)
        .def("areas",
             [](const HeldResult& h) {
                 return numbers_of(h.result.layers, [&](const Layer& layer) { return h.result.area_mm2(layer); });
             })
        .def("perimeters",
             [](const HeldResult& h) {
                 return numbers_of(h.result.layers, [&](const Layer& layer) { return perimeter_mm(h.result, layer); });
             })
        .def("contour_areas",
             [](const HeldResult& h) {
                 return numbers_of(h.result.contours, [&](const Contour& contour) { return h.result.area_mm2(contour); });
             })
        .def("contour_lengths",
             [](const HeldResult& h) {
                 return numbers_of(h.result.contours, [&](const Contour& contour) { return length_mm(h.result, contour); });
             })
        .def_property_readonly("frame", &frame)
        .def_property_readonly("summary", &summary)
        .def_property_readonly("unit_mm", [](const HeldResult& h) { return h.result.unit_mm; })
        .def("open_layers", &open_layers)
        .def_property_readonly("cancelled_layers", [](const HeldResult& h) { return h.result.summary.cancelled_layers; })
        .def_property_readonly("layer_count", [](const HeldResult& h) { return h.result.layers.size(); })
        .def_readonly("first_layer", &HeldResult::first_layer)
        .def(
            "hash", [](const HeldResult& h) { return hash_result(h.result); }, py::call_guard<py::gil_scoped_release>())
        .def("coarse_grid", &coarse_grid)
        .def("state", &state);
    module.def("restore", &restore);
}

}  // namespace lamella::python
