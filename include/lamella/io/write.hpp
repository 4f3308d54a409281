// Writers. Files are written aside and renamed into place when complete: no half-written output is ever left. A path that is
// a device or a pipe is written in place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lamella/audit/crossings.hpp"
#include "lamella/audit/ledger.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh/weld.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// What the engine cannot know: where the mesh came from and what it cost to read and write.
struct ReportContext {
    std::string mesh_file{};
    const MeshFile* file = nullptr;  ///< as it was read, if it came from a file
    const Ledger* ledger = nullptr;  ///< if it was drawn up
    const VolumeCertificate* volume = nullptr;
    const Crossings* crossings = nullptr;
    const WeldedMesh* welded = nullptr;  ///< if it was
    double weld_mm = 0;                  ///< the tolerance asked for
    std::string output_file{};
    double read_ms = 0;  ///< bytes only
    double parse_ms = 0;
    double write_ms = 0;
    double total_ms = 0;
    std::uint64_t peak_rss_bytes = 0;
    std::vector<std::string> warnings{};
};

/// Layered SVG in the convention of Slic3r: a <g id="layerN" slic3r:z="mm"> per layer holding a <polygon
/// slic3r:type="contour|hole|flat"> per contour (and a <polyline slic3r:type="open"> per open one), coordinates in mm
/// (rounded to 1e-6 mm or to the grid, whichever is coarser), y up by a transform, a viewBox around the mesh, dark on white.
/// Grid, rounding rule, datum and frame stand in <desc>, and of `context` what was welded. Streamed layer by layer:
/// O(points) time, 1 MiB of memory. `stop` is checked at every layer. Errors: unwritable_file, cancelled, out_of_memory.
Status write_svg(const SliceResult& result, const std::filesystem::path& path, const ReportContext& context = {},
                 const Control& control = {}) noexcept;

/// The report as JSON text (indented, with a final newline). Errors: out_of_memory.
Result<std::string> report_json(const SliceResult& result, const ReportContext& context) noexcept;

/// Writes `text` to `path` aside and renames it into place. Errors: unwritable_file, out_of_memory.
Status write_text_file(const std::filesystem::path& path, const std::string& text) noexcept;

/// Removes what this process has of an unfinished `path` aside: for a program that ends at once, while a writer may still
/// run.
void remove_unfinished(const std::filesystem::path& path) noexcept;

}  // namespace lamella
