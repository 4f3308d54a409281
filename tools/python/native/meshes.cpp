// Meshes: in arrays of Python, from files, welded.
#include <filesystem>

#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh/orient.hpp"
#include "lamella/mesh/weld.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

CoordinateType coordinate_type_of(const py::array& numbers) {
    const bool wide = numbers.itemsize() == 8;
    if (numbers.dtype().kind() == 'f') {
        return wide ? CoordinateType::f64 : CoordinateType::f32;
    }
    return wide ? CoordinateType::i64 : CoordinateType::i32;
}

MeshView mesh_of(const py::array& vertices, const py::object& faces) {
    const auto* const first = static_cast<const std::byte*>(vertices.data());
    const auto rows = static_cast<std::size_t>(vertices.shape(0));
    const auto stride = static_cast<std::size_t>(vertices.strides(0));
    const CoordinateType type = coordinate_type_of(vertices);
    if (faces.is_none()) {
        return MeshView::strided_soup(first, rows, stride, type);
    }
    const auto indices = py::reinterpret_borrow<py::array>(faces);
    return MeshView::indexed(first, rows, stride, type, static_cast<const std::byte*>(indices.data()),
                             static_cast<std::size_t>(indices.shape(0)), static_cast<std::size_t>(indices.strides(0)),
                             indices.itemsize() == 4 ? IndexType::u32 : IndexType::u64);
}

py::array rows_of(const void* data, CoordinateType type, std::size_t rows, std::size_t stride, int width,
                  const py::handle& owner) {
    const py::dtype number = type == CoordinateType::f32 ? py::dtype::of<float>() : py::dtype::of<double>();
    return read_only(py::array(number, {static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(width)},
                               {static_cast<py::ssize_t>(stride), number.itemsize()}, data, owner));
}

py::array faces_of(const Array<std::uint32_t>& indices, const py::handle& owner) {
    return read_only(py::array(py::dtype::of<std::uint32_t>(),
                               {static_cast<py::ssize_t>(indices.size() / 3), py::ssize_t{3}}, indices.data(), owner));
}

py::dict info_of(const MeshFile& file) {
    py::dict info;
    info["format"] = std::string(name_of(file.format));
    info["text"] = file.text;
    info["compressed"] = file.compressed;
    info["states_unit"] = file.states_unit;
    info["patient_frame"] = std::string(name_of(file.patient_frame));
    info["bytes"] = file.file_bytes;
    py::list parts;
    for (const MeshPart& part : file.parts) {
        parts.append(py::dict(py::arg("name") = text_of(part.name), py::arg("role") = std::string(name_of(part.role)),
                              py::arg("first_triangle") = part.first_triangle, py::arg("triangles") = part.triangle_count));
    }
    info["parts"] = parts;
    return info;
}

py::dict read(const std::string& path, double mm_per_unit, const SliceOptions& options) {
    MeshFile outcome = run(options.control, [&](const Control& control) {
        return read_mesh(std::filesystem::path(path), {.mm_per_unit = mm_per_unit, .control = control});
    });
    const auto* const file = new MeshFile(std::move(outcome));
    const py::capsule owner(file, [](void* kept) { delete static_cast<MeshFile*>(kept); });
    const bool soup = file->indices.empty();
    py::dict mesh;
    mesh["vertices"] = rows_of(file->bytes.data() + file->first_offset, file->coordinate_type,
                               soup ? file->triangle_count : file->vertex_count, file->stride, soup ? 9 : 3, owner);
    mesh["faces"] = soup ? py::object(py::none()) : faces_of(file->indices, owner);
    mesh["unit"] = file->mm_per_unit;
    mesh["info"] = info_of(*file);
    py::list warnings;
    for (const std::string& warning : file->warnings) {
        warnings.append(text_of(warning));
    }
    mesh["warnings"] = warnings;
    return mesh;
}

py::dict arrays_of(WeldedMesh&& outcome, const py::dict& info) {
    const auto* const kept_mesh = new WeldedMesh(std::move(outcome));
    const py::capsule owner(kept_mesh, [](void* kept) { delete static_cast<WeldedMesh*>(kept); });
    const MeshView mesh = kept_mesh->view();
    py::dict made;
    made["vertices"] = rows_of(mesh.vertices, mesh.coordinate_type, mesh.vertex_count, mesh.stride, 3, owner);
    made["faces"] = faces_of(kept_mesh->indices, owner);
    made["unit"] = kept_mesh->mm_per_unit;
    made["info"] = info;
    return made;
}

py::dict weld_mesh(const View& view, double tolerance_mm, const SliceOptions& options) {
    WeldedMesh outcome = run(options.control, [&](const Control& control) {
        return weld(view.mesh(),
                    {.tolerance_mm = tolerance_mm, .mm_per_unit = view.parts().front().transform.m[0], .control = control});
    });
    py::dict info;
    info["joined"] = outcome.joined;
    info["largest_move"] = outcome.largest_move_mm;
    info["tolerance"] = outcome.tolerance_mm;
    return arrays_of(std::move(outcome), info);
}

py::dict orient_mesh(const View& view, const SliceOptions& options) {
    OrientedMesh outcome = run(options.control, [&](const Control& control) {
        return orient_shells(view.mesh(),
                             {.mm_per_unit = view.parts().front().transform.m[0], .unit_mm = 0, .control = control});
    });
    py::dict info;
    info["shells"] = outcome.shells;
    info["turned"] = outcome.turned_shells;
    info["complete"] = outcome.complete;
    return arrays_of(std::move(outcome.mesh), info);
}

}  // namespace

Transform transform_of(const py::array_t<double>& matrix) {
    Transform transform;
    for (int i = 0; i < 12; ++i) {
        transform.m[static_cast<std::size_t>(i)] = matrix.at(i / 4, i % 4);
    }
    return transform;
}

View::View(const py::list& meshes) {
    for (const py::handle mesh : meshes) {
        const auto given = py::reinterpret_borrow<py::tuple>(mesh);
        const py::object vertices = given[0];
        const py::object faces = given[1];
        const double mm_per_unit = py::float_(given[2]);
        Part part{.mesh = mesh_of(py::reinterpret_borrow<py::array>(vertices), faces)};
        if (mm_per_unit != 1) {
            part.transform = Transform::scale(mm_per_unit);
        }
        if (const py::object move = given[3]; !move.is_none()) {
            part.transform = transform_of(py::reinterpret_borrow<py::array_t<double>>(move)) * part.transform;
        }
        parts_.push_back(part);
        arrays_.push_back(vertices);
        arrays_.push_back(faces);
    }
}

void define_meshes(py::module_& module) {
    py::class_<View>(module, "View").def(py::init<const py::list&>());
    module.def("read", &read);
    module.def("weld", &weld_mesh);
    module.def("orient_shells", &orient_mesh);
}

}  // namespace lamella::python
