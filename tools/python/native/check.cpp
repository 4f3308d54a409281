// What check() found, as arrays.
#include "lamella/mesh/check.hpp"

#include <limits>

#include "lamella/io/check_report.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

template <class Number, class Row, class Value>
py::array_t<Number> column(const std::vector<Row>& rows, Value value) {
    py::array_t<Number> numbers(static_cast<py::ssize_t>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        numbers.mutable_data()[i] = value(rows[i]);
    }
    return numbers;
}

py::dict finding(const FaultFinding& found) {
    const std::vector<FaultPlace>& places = found.places;
    const auto count = static_cast<py::ssize_t>(places.size());
    py::array_t<double> points({count, py::ssize_t{3}, py::ssize_t{3}});
    py::array_t<std::int64_t> triangles({count, py::ssize_t{2}});
    for (std::size_t i = 0; i < places.size(); ++i) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                points.mutable_data()[9 * i + 3 * corner + axis] = static_cast<int>(corner) < places[i].point_count
                                                                       ? places[i].points_mm[corner][axis]
                                                                       : std::numeric_limits<double>::quiet_NaN();
            }
        }
        std::copy(places[i].triangles.begin(), places[i].triangles.end(), triangles.mutable_data() + 2 * i);
    }
    py::dict made;
    made["count"] = found.count;
    made["at_least"] = found.at_least;
    made["points"] = points;
    made["point_count"] = column<std::int64_t>(places, [](const FaultPlace& p) { return p.point_count; });
    made["triangles"] = triangles;
    made["parts"] = column<std::int64_t>(places, [](const FaultPlace& p) { return static_cast<std::int64_t>(p.parts); });
    made["measure"] = column<double>(places, [](const FaultPlace& p) { return p.measure; });
    made["closed"] = column<bool>(places, [](const FaultPlace& p) { return p.closed; });
    return made;
}

/// By name, as a structured array is filled.
py::dict shells(const std::vector<MeshShell>& all) {
    py::array_t<double> first({static_cast<py::ssize_t>(all.size()), py::ssize_t{3}});
    for (std::size_t i = 0; i < all.size(); ++i) {
        std::copy(all[i].first_mm.begin(), all[i].first_mm.end(), first.mutable_data() + 3 * i);
    }
    py::dict made;
    made["triangles"] = column<std::int64_t>(all, [](const MeshShell& s) { return static_cast<std::int64_t>(s.triangles); });
    made["closed"] = column<bool>(all, [](const MeshShell& s) { return s.closed; });
    made["volume"] = column<double>(all, [](const MeshShell& s) { return s.volume_mm3; });
    made["orientation"] = column<std::int64_t>(all, [](const MeshShell& s) { return s.orientation; });
    made["depth"] = column<std::int64_t>(all, [](const MeshShell& s) { return s.depth; });
    made["parent"] = column<std::int64_t>(all, [](const MeshShell& s) { return s.parent; });
    made["triangle"] = column<std::int64_t>(all, [](const MeshShell& s) { return s.triangle; });
    made["first"] = first;
    return made;
}

py::dict info_of(const MeshInfo& info) {
    py::dict made;
    made["triangles"] = info.triangles;
    made["degenerate"] = info.degenerate;
    made["min"] = py::make_tuple(info.min_mm[0], info.min_mm[1], info.min_mm[2]);
    made["max"] = py::make_tuple(info.max_mm[0], info.max_mm[1], info.max_mm[2]);
    made["volume"] = info.volume_mm3;
    made["area"] = info.area_mm2;
    made["edges"] = info.edges;
    made["boundary_edges"] = info.boundary_edges;
    made["overfull_edges"] = info.overfull_edges;
    made["mismatched_edges"] = info.mismatched_edges;
    made["shells"] = info.shells;
    made["closed"] = info.closed;
    made["grid"] = info.unit_mm;
    return made;
}

py::dict check_mesh(const View& view, const SliceOptions& options, double tolerance_mm, double sliver_ratio,
                    std::size_t most_places) {
    const MeshCheck found = run(options.control, [&](const Control& control) {
        return check(view.mesh(), {.unit_mm = options.unit_mm,
                                   .transform = view.to_planes(options.transform),
                                   .tolerance_mm = tolerance_mm,
                                   .sliver_ratio = sliver_ratio,
                                   .most_places = most_places,
                                   .control = control});
    });
    py::dict findings;
    for (std::size_t i = 0; i < fault_count; ++i) {
        findings[std::string(key_of(static_cast<Fault>(i))).c_str()] = finding(found.findings[i]);
    }
    py::dict made;
    made["verdict"] = run(Control{}, [&](const Control&) { return make_verdict(found); });
    made["clean"] = found.clean();
    made["complete"] = found.complete();
    made["info"] = info_of(found.info);
    made["shells"] = shells(found.shells);
    made["findings"] = findings;
    return made;
}

}  // namespace

void define_check(py::module_& module) {
    module.def("check", &check_mesh);
}

}  // namespace lamella::python
