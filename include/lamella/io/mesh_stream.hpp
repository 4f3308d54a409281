// A mesh file larger than memory, as a Source: it is read in pieces whenever it is sliced.
//
//     const lamella::Result<lamella::MeshStream> file = lamella::open_mesh("liver.stl", {.memory_bytes = 100'000'000});
//     if (file) {
//         double mm3 = 0;
//         auto add = [&](const lamella::LayerView& layer) noexcept {
//             mm3 += layer.area_mm2() * (layer.top_mm - layer.bottom_mm);
//         };
//         lamella::Slicer slicer;
//         const auto info = slicer.slice_to(lamella::LayerSink{.take = add}, *file);
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
// Layers are those of the whole mesh, byte for byte, whatever the budget and the number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/source.hpp"

namespace lamella {

struct StreamOptions {
    std::uint64_t memory_bytes = 0;  ///< what a slice may hold, results apart; 0: half of physical memory
    /// Where the temporary file is made, which no name leads to and which ends with the call. Empty: the system's folder.
    std::filesystem::path temporary_folder{};
    ReadOptions read{};  ///< `map_file` and its limit are not used
};

class MeshStream {
public:
    MeshStream(MeshStream&&) noexcept;
    MeshStream& operator=(MeshStream&&) noexcept;
    ~MeshStream();

    /// What read_mesh() says of the file, without coordinates and indices.
    const MeshFile& about() const noexcept;
    /// For a Slicer. Memory: at most StreamOptions::memory_bytes, of which the vertices of PLY take 12 or 24 bytes each, the
    /// tables 24 bytes a layer and, in budgets of a megabyte and less, a few bytes for each hundred triangles. In ascending
    /// order one layer is held at a time, and as much as the budget allows is put aside. Errors besides those of slice() and
    /// read_mesh(): invalid_argument (SliceOptions::origins, contents other than sections); out_of_memory where the budget
    /// is below the least that serves, which is named: that of the layer with the most triangles, or first of the vertices;
    /// unwritable_file (the temporary file).
    Source view() const noexcept;

    /// The last slice, by whichever Slicer.
    struct Spent {
        std::uint64_t ranges = 0;         ///< of layers, cut one after the other
        std::uint64_t spilled_bytes = 0;  ///< written to the temporary file
        std::uint64_t memory_bytes = 0;   ///< the budget
    };
    Spent spent() const noexcept;

private:
    struct Impl;
    explicit MeshStream(std::unique_ptr<Impl> impl) noexcept;
    friend Result<MeshStream> open_mesh(const std::filesystem::path&, const StreamOptions&) noexcept;
    std::unique_ptr<Impl> impl_;
};

/// Reads the beginning of the file. Errors: those of read_mesh(); invalid_argument for files of other formats, for PLY that
/// holds polygons or strips, for text and for gzip, which have to be converted first.
Result<MeshStream> open_mesh(const std::filesystem::path& path, const StreamOptions& options = {}) noexcept;

}  // namespace lamella
