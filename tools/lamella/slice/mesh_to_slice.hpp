// The mesh of `lamella slice`, and what is cut in place of it where its parts have roles.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lamella/io/mesh_stream.hpp"
#include "lamella/lamella.hpp"
#include "slice/slice.hpp"

namespace lamella::cli {

/// The mesh that is sliced: a file, mended or not, or within --memory a stream of it.
struct MeshToSlice {
    MeshFile file;
    std::optional<MeshStream> stream{};      ///< in place of the file
    std::optional<WeldedMesh> welded{};      ///< in place of the file
    std::optional<OrientedMesh> oriented{};  ///< after welding
    std::vector<std::string> warnings{};     ///< of reading
    std::vector<Part> parts{};               ///< in place of all that; empty: none

    const MeshFile& about() const noexcept { return stream ? stream->about() : file; }
    /// The triangles that are sliced. Precondition: no stream.
    MeshView view() const noexcept { return oriented ? oriented->view() : welded ? welded->view() : file.view(); }
    Source source() const noexcept { return stream ? stream->view() : parts.empty() ? Source(view()) : Source(parts); }
    bool is_mended() const noexcept { return oriented || welded; }
};

/// For what a mesh larger than memory does not leave in it.
std::filesystem::path folder_beside(const SliceArguments& arguments);

/// The patient frame of a mesh: what its file states, else --frame. Throws Failure where neither says it.
PatientFrame patient_frame_of(const MeshFile& mesh, const ImageArguments& arguments, const std::string& name);

/// What is cut in place of a file's mesh, where parts of the file or the mesh of --negative take something away, or where
/// `split` and modifiers label what they cover; else nothing. With `split` all parts keep their numbers in parts_of(). A
/// `mended` mesh stands for all solid parts, whatever their object.
std::vector<Part> parts_to_cut(const MeshFile& file, const std::optional<MeshView>& mended,
                               const std::optional<MeshView>& negative, bool split);

/// Planes at these heights along the normal of an image's slices.
void cut_across(SliceOptions& options, const ImageGeometry& image, PatientFrame frame, std::vector<double> heights);

/// The voxels of --spacing around all meshes.
ImageGeometry image_around(const std::vector<MeshToSlice>& meshes, const SliceArguments& arguments);

/// By their numbers in parts_of().
std::vector<std::string> names_of_parts(const MeshFile& file);

/// One region of all that is solid in parts.
void cut_as_one(SliceOptions& options);

/// What was cut of parts is the slice of `mesh` to all that is written.
void make_one_mesh(SliceResult& cut, const MeshView& mesh);

}  // namespace lamella::cli
