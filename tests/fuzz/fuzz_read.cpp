// Any bytes under any name: read, examined and sliced. The first byte chooses the name's extension and how the file is read
// the second time, which must come to the same as the first.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "bytes.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"

using lamella::MeshFile;
using lamella::MeshInfo;
using lamella::MeshView;
using lamella::ReadOptions;
using lamella::Result;

namespace {

namespace fs = std::filesystem;

constexpr std::array extensions = {".stl", ".obj", ".off", ".ply", ".3mf", ".vtk", ".vtp", ".bin"};
constexpr std::uint64_t memory_limit_bytes = std::uint64_t{64} << 20;
constexpr double layers = 12;
constexpr std::uint64_t most_triangles = 20'000;  ///< that are also sliced: a fuzzer lives by its pace

/// A folder in memory where there is one, removed at the end.
class Folder {
public:
    Folder()
        : path_((fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                ("lamella-fuzz-" + std::to_string(::getpid()))) {
        fs::create_directories(path_);
    }
    ~Folder() {
        std::error_code left_behind;
        fs::remove_all(path_, left_behind);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    fs::path write(const char* extension, std::span<const std::uint8_t> bytes) const {
        const fs::path path = path_ / ("mesh" + std::string(extension));
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        return path;
    }

private:
    fs::path path_;
};

void check_error(const lamella::Error& error) {
    fuzz::require(!error.message.empty() && error.message.find('\n') == std::string::npos, "an error is one line");
}

void check_same(const Result<MeshFile>& first, const Result<MeshFile>& second) {
    fuzz::require(first.ok() == second.ok(), "read and mapped, by any threads: both can be read or neither");
    if (!first) {
        fuzz::require(first.error().message == second.error().message && first.error().code == second.error().code,
                      "the same error, not '" + first.error().message + "' and '" + second.error().message + "'");
        return;
    }
    fuzz::require(first->triangle_count == second->triangle_count && first->vertex_count == second->vertex_count &&
                      first->warnings == second->warnings && first->mm_per_unit == second->mm_per_unit,
                  "the same mesh");
}

/// The bytes that hold coordinates are where the view says.
void check_extent(const MeshFile& mesh) {
    const std::size_t number = mesh.number == lamella::CoordinateType::f32 ? sizeof(float) : sizeof(double);
    const bool soup = mesh.indices.empty();
    const std::uint64_t items = soup ? mesh.triangle_count : mesh.vertex_count;
    const std::size_t item = (soup ? 9 : 3) * number;
    fuzz::require(mesh.triangle_count > 0, "a mesh has triangles");
    fuzz::require(items == 0 || mesh.first_offset + (items - 1) * mesh.stride + item <= mesh.bytes.size(),
                  "the coordinates are in memory");
    fuzz::require(soup || mesh.indices.size() == 3 * mesh.triangle_count, "three indices a triangle");
}

void check_slice(const MeshFile& mesh, const MeshInfo& info) {
    const double height = info.max_mm[2] - info.min_mm[2];
    if (mesh.triangle_count > most_triangles || !(height > 0)) {
        return;
    }
    lamella::SliceOptions options;
    options.plan.spacing = lamella::UniformLayers{height / layers};
    options.transform = mesh.to_mm();
    options.memory_limit_bytes = memory_limit_bytes;
    options.control.threads = 1;
    const Result<lamella::SliceResult> result = slice(mesh.view(), options);
    if (!result) {
        check_error(result.error());
        return;
    }
    const lamella::Status valid = validate(*result);
    fuzz::require(valid.ok(), valid.ok() ? "" : valid.error().message);
}

void check_mesh(const MeshFile& mesh) {
    check_extent(mesh);
    const Result<MeshInfo> info = inspect(mesh.view(), {.unit_mm = 0, .transform = mesh.to_mm(), .control = {.threads = 1}});
    if (!info) {
        check_error(info.error());
        return;
    }
    fuzz::require(info->triangles == mesh.triangle_count && info->degenerate <= info->triangles, "triangles are counted");
    check_slice(mesh, *info);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const Folder folder;
    fuzz::Bytes bytes(data, size);
    const unsigned choice = bytes.next();
    const fs::path path = folder.write(extensions[choice % extensions.size()], bytes.rest());
    ReadOptions options;
    options.memory_limit_bytes = memory_limit_bytes;
    options.control.threads = 1;
    const Result<MeshFile> mesh = read_mesh(path, options);
    if (choice / 8 % 4 == 3) {  // not always: another file's worth of time
        options.control.threads = 3;
        options.map_file = choice / 32 % 2 != 0;
        check_same(mesh, read_mesh(path, options));
    }
    if (mesh) {
        check_mesh(*mesh);
    } else {
        check_error(mesh.error());
        fuzz::require(
            mesh.error().message.starts_with(path.string()) || mesh.error().code == lamella::ErrorCode::out_of_memory,
            "the error names the file: " + mesh.error().message);
    }
    return 0;
}
