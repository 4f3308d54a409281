// Reads any bytes under any file name, then inspects and slices the mesh. The first byte chooses the file's extension and
// how the file is read a second time. Both readings must give the same.
#include "bytes.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "temp_folder.hpp"

using namespace lamella;

namespace {

namespace fs = std::filesystem;

constexpr std::array extensions = {".stl", ".obj", ".off", ".ply", ".3mf", ".vtk", ".vtp", ".bin"};
constexpr std::uint64_t memory_limit_bytes = std::uint64_t{64} << 20;
constexpr double layers = 12;
constexpr std::uint64_t most_triangles = 20'000;  ///< larger meshes are not sliced, to keep the fuzzer fast

/// In memory if possible.
const TempFolder& folder() {
    static const TempFolder folder = [] {
        if (fs::is_directory("/dev/shm")) {
            ::setenv("TMPDIR", "/dev/shm", 1);
        }
        return TempFolder();
    }();
    return folder;
}

void check_error(const Error& error) {
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

/// Requires that the bytes with coordinates are where the view says.
void check_extent(const MeshFile& mesh) {
    const bool soup = mesh.indices.empty();
    const std::uint64_t items = soup ? mesh.triangle_count : mesh.vertex_count;
    const std::size_t item = (soup ? 9 : 3) * size_of(mesh.vertex_type);
    fuzz::require(mesh.triangle_count > 0, "a mesh has triangles");
    fuzz::require(items == 0 || mesh.first_offset + (items - 1) * mesh.stride + item <= mesh.bytes.size(),
                  "the coordinates are in memory");
    fuzz::require(soup || mesh.indices.size() == 3 * mesh.triangle_count, "three indices a triangle");
}

void check_slice(const MeshFile& mesh, const MeshCheck& counts) {
    const double height = counts.box.max_mm[2] - counts.box.min_mm[2];
    if (mesh.triangle_count > most_triangles || !(height > 0)) {
        return;
    }
    const Result<SliceResult> result =
        slice(mesh, {.layer_height_mm = height / layers}, {.threads = 1, .memory_limit_bytes = memory_limit_bytes});
    if (!result) {
        check_error(result.error());
        return;
    }
    fuzz::require_valid(*result);
}

void check_mesh(const MeshFile& mesh) {
    check_extent(mesh);
    const Result<MeshCheck> counts = check(mesh.view(), {.counts_only = true}, {.threads = 1});
    if (!counts) {
        check_error(counts.error());
        return;
    }
    fuzz::require(counts->triangles == mesh.triangle_count && counts->degenerate <= counts->triangles,
                  "triangles are counted");
    check_slice(mesh, *counts);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const unsigned choice = bytes.next();
    const fs::path path = folder().write("mesh" + std::string(extensions[choice % extensions.size()]),
                                         {reinterpret_cast<const char*>(bytes.rest().data()), bytes.rest().size()});
    ReadOptions options;
    options.memory_limit_bytes = memory_limit_bytes;
    options.scalars = true;
    const Result<MeshFile> mesh = read_mesh(path, options, {.threads = 1});
    if (choice / 8 % 4 == 3) {  // only sometimes: writing takes as long as another file
        options.map_file = choice / 32 % 2 != 0;
        check_same(mesh, read_mesh(path, options, {.threads = 3}));
    }
    if (mesh) {
        check_mesh(*mesh);
    } else {
        check_error(mesh.error());
        fuzz::require(mesh.error().message.starts_with(path.string()) || mesh.error().code == ErrorCode::out_of_memory,
                      "the error names the file: " + mesh.error().message);
    }
    return 0;
}
