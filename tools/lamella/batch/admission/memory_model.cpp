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

/// The first row that fits holds. Layers of 0.05 mm of a bone of 100 mm: coarser ones take less.
constexpr std::array<FormatCost, 11> costs = {{
    {".stl", "", 50, 130},
    {".obj", "", 40, 180},
    {".off", "", 36, 180},
    {".ply", "format ascii", 40, 180},
    {".ply", "", 19, 160},
    {".vtk", "ASCII", 40, 180},
    {".vtk", "", 22, 180},
    {".vtp", "ascii", 50, 220},
    {".vtp", "", 20, 200},
    {".3mf", "", 10, 260},
    {"", "", 20, 200},
}};
constexpr FormatCost text_stl = {".stl", "", 180, 320};
constexpr double text_gzip_ratio = 4;

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

FormatCost cost_of(const std::string& name, const std::string& begin, std::uint64_t file_bytes, bool packed) {
    const FormatCost cost = *std::find_if(costs.begin(), costs.end(), [&](const FormatCost& row) {
        return name.ends_with(row.end) && begin.find(row.marker) != std::string::npos;
    });
    const bool text = cost.end == ".stl" && !packed && !is_binary_stl(begin, file_bytes);
    return text ? text_stl : cost;
}

}  // namespace

MeshEstimate estimate_mesh(const std::string& path, std::uint64_t file_bytes) {
    std::string name = path;
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool packed = name.ends_with(".gz");
    if (packed) {
        name.resize(name.size() - 3);
    }
    const FormatCost cost = cost_of(name, first_bytes(path), file_bytes, packed);
    const double unpacked = static_cast<double>(file_bytes) * (packed ? text_gzip_ratio : 1);
    const double triangles = unpacked / cost.file_bytes;
    return {triangles, process_bytes + triangles * cost.memory_bytes + (packed ? unpacked : 0)};
}

}  // namespace lamella::cli::batch
