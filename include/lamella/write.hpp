// Writers. Files are written aside and renamed into place when complete: no half-written output is ever left.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lamella/result.hpp"
#include "lamella/status.hpp"

namespace lamella {

/// Layered SVG in the convention of Slic3r: a <g id="layerN" slic3r:z="mm"> per layer holding a <polygon
/// slic3r:type="contour|hole"> per contour (and a <polyline> per open one), coordinates in mm, y up by a transform, a
/// viewBox around the mesh, dark on white. Streamed layer by layer. Errors: unwritable_file.
Status write_svg(const SliceResult& result, const std::filesystem::path& path);

/// What the engine cannot know: where the mesh came from and what it cost to read and write.
struct ReportContext {
    std::string mesh_file;
    std::string output_file;
    double read_ms = 0;  ///< bytes only
    double parse_ms = 0;
    double write_ms = 0;
    double total_ms = 0;
    std::uint64_t peak_rss_bytes = 0;
    std::vector<std::string> warnings;
};

/// The report as JSON text (indented, with a final newline).
std::string report_json(const SliceResult& result, const ReportContext& context);

/// Writes `text` to `path` aside and renames it into place. Errors: unwritable_file.
Status write_text_file(const std::filesystem::path& path, const std::string& text);

}  // namespace lamella
