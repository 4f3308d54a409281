// Tables: what each layer measures, for a spreadsheet or a program.
//
//     const lamella::TablePart organ{.result = &result, .name = "liver"};
//     const lamella::Status written = lamella::write_layer_table({&organ, 1}, "liver.csv");
//     std::printf("%s\n", written ? "written" : written.error().message.c_str());
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/destination.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// What is known of a whole mesh.
struct MeshFacts {
    std::uint64_t triangles = 0;
    double volume_mm3 = 0;  ///< NaN, not known, of an open mesh
    double surface_mm2 = 0;
    std::string certificate;  ///< "certified", or why not
    std::vector<std::string> warnings;
};

/// The facts of a mesh and its result. O(n + q). Errors: those of check() and audit().
Result<MeshFacts> measure_facts(const MeshView& mesh, const SliceResult& result, const Context& context = {}) noexcept;

/// A mesh of a table.
struct TablePart {
    const SliceResult* result = nullptr;
    std::string name;
    const MeshFacts* facts = nullptr;  ///< where they are known
};

/// Writes a row a layer, or with `islands` a row an island: by the end of the name .csv or .jsonl. Columns are those of
/// SectionMeasures. What is not known is empty, or null. Moments and angles are in the frame of the section. Where there are
/// facts, .jsonl begins with a line a mesh, and beside NAME.csv stands NAME.meshes.csv. `image`: at whose slices the parts
/// were cut, in its slicing_frame(); heights and places are then the patient's, in columns named _lps_mm
/// (ImageGeometry::height_lps_mm(), to_lps()). Errors: invalid_argument, unwritable_file, cancelled, out_of_memory.
Status write_layer_table(std::span<const TablePart> parts, const std::filesystem::path& path,
                         const ImageGeometry* image = nullptr, bool islands = false, const Context& context = {}) noexcept;

/// The same file for one mesh without facts, layer by layer, of a result that is never held: add() each layer in ascending
/// order, then finish(). Errors are kept, and finish() returns the first; a stream that ends without it leaves no file.
class LayerTableStream {
public:
    static Result<LayerTableStream> begin(const std::string& name, const std::filesystem::path& path,
                                          const ImageGeometry* image = nullptr, bool islands = false) noexcept;
    LayerTableStream(LayerTableStream&& other) noexcept;
    LayerTableStream& operator=(LayerTableStream&& other) noexcept;
    ~LayerTableStream();

    void add(const LayerView& layer) noexcept;
    /// Something failed: more layers are for nothing.
    bool failed() const noexcept;
    Status finish() noexcept;

private:
    struct State;
    explicit LayerTableStream(std::unique_ptr<State> state) noexcept;
    std::unique_ptr<State> state_;
};

}  // namespace lamella
