// Checks of a mesh, and of a result beside its mesh; results written to files.
#include <filesystem>
#include <limits>

#include "lamella/audit/crossings.hpp"
#include "lamella/audit/ledger.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/io/check_report.hpp"
#include "lamella/io/report.hpp"
#include "lamella/io/svg.hpp"
#include "lamella/io/text_file.hpp"
#include "lamella/mesh/check.hpp"
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

py::dict certify(const HeldResult& held, const View& view) {
    VolumeCertificate certificate =
        run(Control{}, [&](const Control& control) { return certify_volume(view.mesh(), held.result, control); });
    py::dict made;
    made["verdict"] = std::string(name_of(certificate.verdict));
    made["mesh_volume"] = certificate.mesh_mm3;
    made["slab_volumes"] =
        py::array_t<double>(static_cast<py::ssize_t>(certificate.slab_mm3.size()), certificate.slab_mm3.data());
    made["worst_layer"] = certificate.worst_layer;
    made["worst_difference"] = certificate.worst_difference_mm2;
    made["worst_allowed"] = certificate.worst_allowed_mm2;
    made["differing_layers"] = certificate.differing_layers;
    made["differing_signed"] = certificate.differing_signed_mm2;
    made["differing_solid"] = certificate.differing_solid_mm2;
    return made;
}

/// Ledger and certificate compare with one mesh.
void write_report(const HeldResult& held, const View& view, const std::string& path) {
    const SliceResult& result = held.result;
    const auto control = [](auto work) { return run(Control{}, work); };
    const bool one_mesh = view.parts().size() == 1;
    ReportParts parts;
    Ledger ledger;
    VolumeCertificate volume;
    if (one_mesh) {
        ledger = control([&](const Control& c) { return make_ledger(view.mesh(), result, c); });
        volume = control([&](const Control& c) { return certify_volume(view.mesh(), result, c); });
        parts.ledger = &ledger;
        parts.volume = &volume;
    }
    const Crossings crossings = control([&](const Control& c) { return find_crossings(result, c); });
    parts.crossings = &crossings;
    const std::string text = control([&](const Control&) { return make_report_json(result, parts); });
    control([&](const Control&) { return write_text_file(std::filesystem::path(path), text); });
}

void write_picture(const HeldResult& held, const std::string& path) {
    run(Control{},
        [&](const Control& control) { return write_svg(held.result, std::filesystem::path(path), {.control = control}); });
}

}  // namespace

void define_checks(py::module_& module) {
    module.def("check", &check_mesh);
    const py::object held = module.attr("Result");
    held.attr("certify") = py::cpp_function(&certify, py::name("certify"), py::is_method(held));
    held.attr("write_report") = py::cpp_function(&write_report, py::name("write_report"), py::is_method(held));
    held.attr("write_svg") = py::cpp_function(&write_picture, py::name("write_svg"), py::is_method(held));
}

}  // namespace lamella::python
