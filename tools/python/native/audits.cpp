// A result compared with its mesh, and written to files.
#include <filesystem>

#include "lamella/audit/crossings.hpp"
#include "lamella/audit/ledger.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/io/report.hpp"
#include "lamella/io/svg.hpp"
#include "lamella/io/text_file.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

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

void define_audits(py::module_& module) {
    const py::object held = module.attr("Result");
    held.attr("certify") = py::cpp_function(&certify, py::name("certify"), py::is_method(held));
    held.attr("write_report") = py::cpp_function(&write_report, py::name("write_report"), py::is_method(held));
    held.attr("write_svg") = py::cpp_function(&write_picture, py::name("write_svg"), py::is_method(held));
}

}  // namespace lamella::python
