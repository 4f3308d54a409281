#include "batch/admission/memory_model.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

namespace lamella::cli::batch {

namespace {

struct FormatCost {
    std::string_view end;     ///< of the name
    std::string_view marker;  ///< in the first bytes; empty: any
    double file_bytes;        ///< a triangle
    double memory_bytes;      ///< a triangle
};

/// The first row that fits holds. Rows are the largest of what was measured, so that packed STL counts as text. XML
/// polydata without compression may have 32-bit indices, which take fewer bytes of file than the 64-bit ones measured.
constexpr std::array<FormatCost, 18> costs = {{
    {".stl.gz", "", 17, 320},
    {".ply.gz", "", 9, 140},
    {".obj.gz", "", 11, 140},
    {".off.gz", "", 11, 140},
    {".vtk.gz", "", 10, 145},
    {".vtp.gz", "", 11, 170},
    {".gz", "", 9, 200},
    {".stl", "", 50, 145},
    {".obj", "", 36, 130},
    {".off", "", 36, 130},
    {".ply", "format ascii", 36, 125},
    {".ply", "", 19, 135},
    {".vtk", "ASCII", 36, 125},
    {".vtk", "", 22, 140},
    {".vtp", "compressor=", 10, 125},
    {".vtp", "", 22, 150},
    {".3mf", "", 14, 155},
    {"", "", 20, 200},
}};
constexpr FormatCost text_stl = {".stl", "", 150, 190};

/// Of a file, and of nothing that could keep the batch waiting.
std::string first_bytes(const std::string& path) {
    std::error_code unknown;
    std::string bytes(512, '\0');
    std::ifstream file;
    if (std::filesystem::is_regular_file(path, unknown)) {
        file.open(path, std::ios::binary);
    }
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(file.gcount()));
    return bytes;
}

/// The triangles that the header states fill the file.
bool is_binary_stl(const std::string& begin, std::uint64_t file_bytes) {
    constexpr std::size_t header = 84;
    std::uint32_t triangles = 0;
    if (begin.size() < header) {
        return false;
    }
    std::memcpy(&triangles, begin.data() + 80, sizeof triangles);
    return file_bytes >= header + std::uint64_t{50} * triangles && !(begin.starts_with("solid") && triangles == 0);
}

FormatCost cost_of(const std::string& name, const std::string& begin, std::uint64_t file_bytes) {
    const FormatCost cost = *std::find_if(costs.begin(), costs.end(), [&](const FormatCost& row) {
        return name.ends_with(row.end) && begin.find(row.marker) != std::string::npos;
    });
    return cost.end == ".stl" && !is_binary_stl(begin, file_bytes) ? text_stl : cost;
}

}  // namespace

MeshEstimate estimate_mesh(const std::string& path, std::uint64_t file_bytes) {
    std::string name = path;
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const FormatCost cost = cost_of(name, first_bytes(path), file_bytes);
    const double triangles = static_cast<double>(file_bytes) / cost.file_bytes;
    return {triangles, process_bytes + triangles * cost.memory_bytes};
}

}  // namespace lamella::cli::batch
