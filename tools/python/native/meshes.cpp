// Meshes: in arrays of Python, from files, welded, turned, checked.
#include <pybind11/stl.h>

#include <cstddef>
#include <filesystem>

#include "lamella/check.hpp"
#include "lamella/io/check_report.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/weld.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

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

py::dict read(const std::string& path, double mm_per_unit, const Asked& asked) {
    MeshFile file = run(asked, [&](const Context& context) {
        return read_mesh(std::filesystem::path(path), {.mm_per_unit = mm_per_unit}, context);
    });
    py::list warnings;
    for (const std::string& warning : file.warnings) {
        warnings.append(text_of(warning));
    }
    const py::dict info = info_of(file);
    py::dict mesh = arrays_of(std::move(file), info);
    mesh["warnings"] = warnings;
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

py::dict check_mesh(const View& view, const Asked& asked, double tolerance_mm, double sliver_ratio,
                    std::size_t most_places) {
    const MeshCheck found = run(asked, [&](const Context& context) {
        return check(view.mesh(),
                     {.frame = asked.options.frame,
                      .tolerance_mm = tolerance_mm,
                      .sliver_ratio = sliver_ratio,
                      .most_places = most_places},
                     context);
    });
    return py::dict("verdict"_a = run([&](const Context& /*lent*/) { return make_verdict(found); }),
                    "clean"_a = found.clean(), "complete"_a = found.complete(), "info"_a = info_of(found),
                    "shells"_a = shells_of(found), "findings"_a = findings_of(found));
}

}  // namespace

View::View(const py::list& meshes, bool as_parts) : as_parts_(as_parts) {
    for (const py::handle mesh : meshes) {
        const auto given = py::reinterpret_borrow<py::tuple>(mesh);
        const py::object vertices = given[0];
        const py::object faces = given[1];
        Part& part = parts_.emplace_back();
        part.mesh = mesh_of(py::reinterpret_borrow<py::array>(vertices), faces, py::float_(given[2]));
        if (const py::object placement = given[3]; !placement.is_none()) {
            const auto rows = py::reinterpret_borrow<py::array_t<double, py::array::c_style>>(placement);
            std::copy_n(rows.data(), part.placement.m.size(), part.placement.m.begin());
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
}

}  // namespace lamella::python
