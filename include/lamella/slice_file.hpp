// Slicing a mesh file that is larger than memory.
//
//     // Sums up areas without ever holding the mesh or all of its layers.
//     struct Areas {
//         double mm3 = 0;
//         void operator()(const lamella::LayerView& view) noexcept {
//             mm3 += view.area_mm2() * (view.layer.top_mm - view.layer.bottom_mm);
//         }
//     } areas;
//     lamella::FileSliceOptions in_ranges;
//     in_ranges.memory_bytes = 100'000'000;
//     const lamella::LayerSink sink = lamella::LayerSink::to(areas, lamella::SinkOrder::ascending);
//     const lamella::Result<lamella::FileSlice> sliced = lamella::slice_file("liver.stl", sink, in_ranges);
//     if (sliced) {
//         std::printf("%llu layers, %g mm3\n", static_cast<unsigned long long>(sliced->totals.layers), areas.mm3);
//     }
//
// The file is binary STL, or binary PLY of triangles, whose vertices stay in memory: 12 bytes each of floats, 24 of doubles.
// It is read twice, in pieces. The first pass finds the box, which chooses grid and planes as it does for the whole
// mesh in memory. The second keeps the triangles that planes cut, 48 bytes each, as the sweep needs them:
//
//     kept triangles    what is cut, and when
//     fit the budget    all layers, at the end of the pass, in one range or a few, from where the triangles lie: they are
//                       sorted by their first planes in place
//     do not fit        where no triangle to come reaches below some layer, as in files in the order of height, the layers
//                       below it at once. Else they go to a temporary file, ordered by ranges of layers, and each range is
//                       read back when its turn comes. That never costs more than reading the file again for each range,
//                       but for two ranges of a mesh of which most triangles are cut: there it costs a tenth more.
//
// Layers are those of slice() of the whole mesh, byte for byte, whatever the budget and the number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/result.hpp"
#include "lamella/sink.hpp"
#include "lamella/slice.hpp"

namespace lamella {

/// What is known before the first layer is cut: what files of layers say at their beginnings.
struct FileOutline {
    SliceResult facts;  ///< plan, frame, unit, rules, box and `layer_of`; without layers, and the rest of the summary 0
    std::uint64_t layers = 0;  ///< that will come
};

/// The host's function that takes the outline; it is called once, before the sink is. Null: nothing wants it.
struct OutlineSink {
    void (*take)(void* context, const FileOutline& outline) noexcept = nullptr;
    void* context = nullptr;
};

struct FileSliceOptions {
    SliceOptions slice{};            ///< `origins` are not to be had
    double mm_per_unit = 1;          ///< of the file's coordinates; applied before `slice.transform`
    std::uint64_t memory_bytes = 0;  ///< what the call may hold, results apart; 0: half of physical memory
    /// Where the temporary file is made, which no name leads to and which ends with the call. Empty: the system's folder.
    std::filesystem::path temporary_folder{};
    std::string_view name{};  ///< what messages call the file; empty: its path
    bool hash = false;        ///< compute FileSlice::hash; layers then come in ascending order
    OutlineSink outline{};
};

/// What was done.
struct FileSlice {
    MeshFile mesh;       ///< what read_mesh() says of the file, without bytes and indices
    SliceTotals totals;  ///< as of slice_to() for the whole mesh, but for `summary.bands` and `summary.ms`, which are sums
    std::optional<std::uint64_t> hash;  ///< hash_result() of the layers handed over, where asked for
    std::uint64_t ranges = 0;           ///< of layers, cut one after the other
    std::uint64_t spilled_bytes = 0;    ///< written to the temporary file
    std::uint64_t memory_bytes = 0;     ///< the budget
};

/// What the beginning of `path` says: all of FileSlice::mesh, before anything is cut. Errors: as of slice_file().
Result<MeshFile> describe_file(const std::filesystem::path& path, const FileSliceOptions& options = {}) noexcept;

/// What the first pass finds: box, grid, planes and the number of layers, of which none is cut. One read of the file,
/// O(n + k). Memory and errors: as of slice_file(), but for a budget that is too small for some layer.
Result<FileOutline> outline_file(const std::filesystem::path& path, const FileSliceOptions& options = {}) noexcept;

/// Slices the binary STL or PLY file `path` and hands each layer to `sink`. O(n + k + m) as slice(), with two reads of the
/// file, and where triangles are spilled 96 bytes more of reading and writing for each that planes cut.
///
/// Memory: at most `options.memory_bytes`, of which the vertices of PLY take 12 or 24 bytes each, the tables 24 bytes a
/// layer and, in budgets of a megabyte and less, a few bytes for each hundred triangles of the file. In ascending order one
/// layer is held at a time, and as much as the budget allows is put aside. Errors: those of slice_to() and of read_mesh();
/// invalid_argument for files of other formats, for PLY that holds polygons or strips, for text and for gzip, which have to
/// be converted first, and for `origins`; out_of_memory where the budget is below the least that serves, which is named:
/// that of the layer with the most triangles, or first of the vertices; unwritable_file (the temporary file). After an error
/// the sink has got some layers and gets no more.
Result<FileSlice> slice_file(const std::filesystem::path& path, const LayerSink& sink,
                             const FileSliceOptions& options = {}) noexcept;

/// The layers of all ranges put together: what slice() gives, but for `summary.bands` and `summary.ms`.
struct CollectedFileSlice {
    FileSlice file;
    SliceResult result;
};

/// The same with a result that holds all layers, which takes memory beside the budget.
Result<CollectedFileSlice> slice_file(const std::filesystem::path& path, const FileSliceOptions& options = {}) noexcept;

}  // namespace lamella
