// Archives: a whole result as HDF5, for programs that know nothing of this library.
//
//     const lamella::Status written = lamella::write_archive(result, {.name = "liver"}, "liver.h5");
//     const lamella::Result<lamella::Archive> again = lamella::read_archive("liver.h5");
//     if (again) {
//         std::printf("%s: %zu layers\n", again->info.name.c_str(), again->result.layers.size());
//     }
//
// The arrays of SliceResult lie in the file as columns, one dataset each, with units, so that h5py, MATLAB or Julia read
// them as they are:
//
//     /layers/first_contour    [ 0 | 2 | 3 | 7 ]        of layer i: contours first_contour[i] to first_contour[i + 1]
//     /contours/first_point    [ 0 | 4 | 8 | ... ]      of contour c: points first_point[c] to first_point[c + 1]
//     /points                  [ x y | x y | ... ]      in grid units; times `grid_mm` of the root: mm
//
// Where each number comes from stands in attributes: of the root the grid, of /mesh the mesh, of /options the options by
// their names, of /image the voxels. Nothing in the file depends on threads or time. Contours' exact areas are not in it:
// their points give them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Whether archives are built in. Without, all calls below are refused: invalid_argument, "this build has no HDF5".
bool has_archives() noexcept;

/// Of WeldedMesh, what is said of a result.
struct ArchiveWeld {
    double tolerance_mm = 0;
    std::uint64_t joined = 0;
};

/// What an archive says beside the result.
struct ArchiveInfo {
    std::string name{};                           ///< of the mesh; at most 4,096 bytes
    std::string mesh_sha256{};                    ///< of the mesh's file; empty where it is not known
    PatientFrame frame = PatientFrame::unstated;  ///< of the mesh
    std::optional<ArchiveWeld> weld{};            ///< where the mesh was welded before
    std::optional<ImageGeometry> geometry{};      ///< of the image that set the planes, without its series and warnings
    int subslices = 1;                            ///< planes a slice of that image
    bool measures = false;                        ///< /measures has the measures of each layer, as tables name them
};

struct Archive {
    SliceResult result;
    ArchiveInfo info;
};

/// Writes `result`, which may be some layers of a plan: equal results are equal bytes. The file is written aside and renamed
/// when complete; a pipe or a device is written in place.
///
/// O(points); memory of a few MiB, and a temporary file of some KiB with a hole as large as the archive. Errors:
/// invalid_argument (a name too long, a result that contradicts itself), unwritable_file, cancelled, out_of_memory.
Status write_archive(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path,
                     const Context& context = {}) noexcept;

/// Reads an archive back and checks it: the checksum of its bytes, offsets, ranges, parents, and that SliceResult::hash() is
/// the one written. Of SliceInfo, `crossed`, `cancelled_layers`, `bands`, `threads` and times are not kept. The
/// range of layers in SliceInfo::options is that of the layers which the file has.
///
/// O(points) on all threads; memory of the result, at most some times the file's size. Files of HDF5 1.8 and later are read.
/// Errors, with file and place: unreadable_file, malformed_mesh (no HDF5 file, none of this library, damaged), cancelled,
/// out_of_memory.
Result<Archive> read_archive(const std::filesystem::path& path, const Context& context = {}) noexcept;

/// What merge_archives() has joined.
struct MergedArchive {
    std::uint64_t layers = 0;
    std::uint64_t hash = 0;  ///< SliceResult::hash() of the whole
    double grid_mm = 0;
    FillRule fill_rule = FillRule::contours;
    ArchiveInfo info;
};

/// Joins the archives of ranges of layers of one slicing, in any order, to the bytes of the whole's archive. Ranges that
/// overlap or leave a gap, and parts of different slicings, are refused by the names of two files.
///
/// Every part is read and checked whole, one at a time: memory of the largest part. Errors: those of both, and
/// invalid_argument.
Result<MergedArchive> merge_archives(std::span<const std::filesystem::path> parts, const std::filesystem::path& path,
                                     const Context& context = {}) noexcept;

}  // namespace lamella
