// Archives: a whole result as HDF5, for programs that know nothing of this library.
//
//     const lamella::Status written = lamella::write_archive(result, {.name = "liver"}, "liver.h5");
//     const lamella::Result<lamella::Archive> again = lamella::read_archive("liver.h5");
//     if (again) {
//         std::printf("%zu layers\n", again->result.layers.size());
//     }
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// What an archive says beside the result.
struct ArchiveInfo {
    std::string name;                             ///< of the mesh
    std::string mesh_sha256;                      ///< of the mesh's file, or empty
    PatientFrame frame = PatientFrame::unstated;  ///< of the mesh
    std::optional<ImageGeometry> geometry;        ///< of the image that set the planes
    int subslices = 1;                            ///< planes a slice of that image
    std::uint64_t first_layer = 0;                ///< of the whole slicing: the first layer of this part
    std::optional<std::uint64_t> all_layers;      ///< of the whole slicing, where this is a part of it
};

struct Archive {
    SliceResult result;
    ArchiveInfo info;
};

/// Writes what of `result` does not depend on threads and time: equal results are equal bytes. Errors: unwritable_file,
/// invalid_argument, cancelled, out_of_memory.
Status write_archive(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path,
                     const Control& control = {}) noexcept;

/// Reads an archive back and checks it. Errors: unreadable_file, malformed_mesh, result_too_large, out_of_memory.
Result<Archive> read_archive(const std::filesystem::path& path, const Control& control = {}) noexcept;

/// Joins the archives of ranges of layers of one slicing to the bytes of the whole. Errors: those of both.
Status merge_archives(std::span<const std::filesystem::path> parts, const std::filesystem::path& path,
                      const Control& control = {}) noexcept;

}  // namespace lamella
