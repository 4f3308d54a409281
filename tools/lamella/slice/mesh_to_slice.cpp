#include "slice/mesh_to_slice.hpp"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <utility>

#include "system/process.hpp"

namespace lamella::cli {

std::filesystem::path folder_beside(const SliceArguments& arguments) {
    const char* const asked = std::getenv("TMPDIR");
    // Else beside the output: the system's own folder is often held in memory.
    if ((asked == nullptr || *asked == 0) && !arguments.outputs.outputs.empty() && !arguments.output_to_stdout()) {
        const std::filesystem::path folder = path_of(arguments.outputs.outputs.front()).parent_path();
        return folder.empty() ? "." : folder;
    }
    return path_of(temporary_folder());
}

PatientFrame patient_frame_of(const MeshFile& mesh, const ImageArguments& arguments, const std::string& name) {
    if (mesh.patient_frame != PatientFrame::unstated) {
        return mesh.patient_frame;
    }
    refuse_if(arguments.frame == PatientFrame::unstated, bad_usage,
              name + ": states no patient frame; --frame lps or --frame ras says it");
    return arguments.frame;
}

std::vector<Part> parts_to_cut(const MeshFile& file, const std::optional<MeshView>& mended,
                               const std::optional<MeshView>& negative, bool split) {
    std::vector<Part> parts = parts_of(file);
    const auto counts = [split](const Part& part) {
        return part.role == PartRole::negative || (split && part.role == PartRole::modifier);
    };
    if (!negative && std::none_of(parts.begin(), parts.end(), counts)) {
        return {};
    }
    if (!split) {
        std::erase_if(parts, [](const Part& part) { return part.role == PartRole::modifier; });
    }
    if (mended) {
        std::erase_if(parts, [](const Part& part) { return part.role == PartRole::solid; });
        parts.push_back({.mesh = *mended});
        std::for_each(parts.begin(), parts.end(), [](Part& part) { part.object = 0; });
    }
    std::set<std::uint32_t> objects;
    for (std::size_t p = 0; negative && p < parts.size(); ++p) {
        objects.insert(parts[p].object);
    }
    for (const std::uint32_t object : objects) {
        parts.push_back({.mesh = *negative, .role = PartRole::negative, .object = object});
    }
    return parts;
}

void cut_across(SliceOptions& options, const ImageGeometry& image, PatientFrame frame, std::vector<double> heights) {
    cut_at(options, std::move(heights));
    options.frame.transform = image.slicing_frame(frame);
}

ImageGeometry image_around(const std::vector<MeshToSlice>& meshes, const SliceArguments& arguments) {
    Box all;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        SliceOptions options = arguments.options;
        const PatientFrame frame = patient_frame_of(meshes[i].about(), arguments.image, arguments.meshes[i]);
        cut_across(options, {}, frame, {});
        const Box box = done_or_thrown(Slicer().outline(meshes[i].source(), options)).box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            all.min_mm[axis] = i == 0 ? box.min_mm[axis] : std::min(all.min_mm[axis], box.min_mm[axis]);
            all.max_mm[axis] = i == 0 ? box.max_mm[axis] : std::max(all.max_mm[axis], box.max_mm[axis]);
        }
    }
    return done_or_thrown(geometry_around(all, *arguments.image.spacing));
}

std::vector<std::string> names_of_parts(const MeshFile& file) {
    std::vector<std::string> names;
    for (const MeshPart& part : file.parts) {
        if (part.role == PartRole::solid || part.first_triangle > 0) {  // else left out
            names.push_back(part.name);
        }
    }
    return names;
}

void cut_as_one(SliceOptions& options) {
    options.unite_parts = true;
    make_region(options);
}

void make_one_mesh(SliceResult& cut, const MeshView& mesh) {
    for (Contour& contour : cut.contours) {
        contour.part = 0;
    }
    cut.info.part_count = 1;
    cut.info.triangles = mesh.triangle_count;
    cut.info.options.unite_parts = false;
}

}  // namespace lamella::cli
