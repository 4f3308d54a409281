// Times reading mesh files from the page cache, format by format, beside the time of pread() for the same bytes.
#include <zip.h>

#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/mesh_file.hpp"
#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Files by how they hold numbers, named after their formats. bench/run.sh has bench/python/mesh_formats.py write them,
/// beside the mesh that they hold.
const std::pair<const char*, std::vector<std::filesystem::path>> formats[] = {
    {"text", {"stl_ascii.stl", "obj.obj", "off.off", "ply_ascii.ply", "vtk_ascii.vtk", "vtp_ascii.vtp"}},
    {"binary",
     {"stl_binary.stl", "ply_little_endian.ply", "ply_big_endian.ply", "vtk_binary.vtk", "vtk5_binary.vtk", "vtp_raw.vtp"}},
    {"packed", {"vtp_base64.vtp", "vtp_zlib.vtp", "3mf.3mf"}},
};

std::array<float, 3> corner_of(const MeshView& view, std::uint64_t triangle, std::size_t corner) {
    const std::byte* const at = view.indices != nullptr ? view.vertex_at(view.vertex_of(triangle, corner))
                                                        : view.vertex_at(triangle) + 3 * corner * size_of(view.vertex_type);
    std::array<float, 3> floats;
    std::array<double, 3> doubles;
    if (view.vertex_type == Number::f32) {
        std::memcpy(floats.data(), at, sizeof floats);
    } else {
        std::memcpy(doubles.data(), at, sizeof doubles);
        std::copy(doubles.begin(), doubles.end(), floats.begin());
    }
    return floats;
}

/// Throws unless both have the same triangles, corner by corner and to the last bit.
void require_equal(const MeshView& got, const MeshView& wanted) {
    if (got.triangle_count != wanted.triangle_count) {
        fail("reads " + std::to_string(got.triangle_count) + " triangles of " + std::to_string(wanted.triangle_count));
    }
    for (std::uint64_t triangle = 0; triangle < got.triangle_count; ++triangle) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            if (corner_of(got, triangle, corner) != corner_of(wanted, triangle, corner)) {
                fail("reads triangle " + std::to_string(triangle) + " wrongly");
            }
        }
    }
}

/// Seconds that reading the file's bytes takes, into memory allocated as in read_mesh(), without parsing.
double time_pread(const InputFile& file, int threads) {
    return seconds_of([&] {
        Array<std::byte> bytes;
        bytes.resize_discarding(file.size());
        const Parallel parallel({.threads = threads});
        if (!file.read(bytes.span(), parallel).ok()) {
            fail("the file cannot be read");
        }
        benchmark::DoNotOptimize(bytes.data());
    });
}

/// Inflates the mesh part of a 3MF file with libzip and discards it. Returns its size in bytes.
std::uint64_t inflate_model(const std::filesystem::path& file) {
    const std::unique_ptr<zip_t, void (*)(zip_t*)> zip(zip_open(file.c_str(), ZIP_RDONLY, nullptr), zip_discard);
    if (zip == nullptr) {
        fail("the package does not open");
    }
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> part(zip_fopen(zip.get(), "3D/3dmodel.model", 0), zip_fclose);
    std::vector<char> piece(std::size_t{256} << 10);
    std::uint64_t bytes = 0;
    zip_int64_t got = part == nullptr ? -1 : 0;
    while (part != nullptr && (got = zip_fread(part.get(), piece.data(), piece.size())) > 0) {
        bytes += static_cast<std::uint64_t>(got);
    }
    if (got < 0) {
        fail("the model part does not inflate");
    }
    return bytes;
}

/// Bytes of the file after base64, zlib or zip decoding.
std::uint64_t unpacked_bytes(const std::filesystem::path& path, const MeshFile& mesh) {
    if (path.extension() == ".3mf") {
        return inflate_model(path);
    }
    return path.extension() == ".vtp" ? 12 * mesh.view().vertex_count + 32 * mesh.triangle_count : mesh.file_bytes;
}

void run_read(benchmark::State& state, const std::filesystem::path& path, int threads) {
    const auto read = [&] { return checked(read_mesh(path, {}, {.threads = threads})); };
    MeshFile mesh = read();
    const InputFile input = checked(InputFile::open(path));
    require_equal(mesh.view(), checked(read_mesh(path.parent_path() / "mesh.stl")).view());
    state.counters["bytes/s"] = rate_of(mesh.file_bytes);
    state.counters["unpacked_bytes/s"] = rate_of(unpacked_bytes(path, mesh));
    double pread_seconds = 0;
    const double seconds = measure(
        state,
        [&] {
            mesh = MeshFile();
            pread_seconds += time_pread(input, threads);
        },
        [&] { mesh = read(); });
    state.counters["share_of_pread"] = pread_seconds / static_cast<double>(state.iterations()) / seconds;
}

/// Measures the upper bound for a deflate stream: only one thread can inflate it.
void run_inflate(benchmark::State& state, const std::filesystem::path& path) {
    const std::uint64_t bytes = inflate_model(path);
    measure(state, [&] { benchmark::DoNotOptimize(inflate_model(path)); });
    state.counters["unpacked_bytes/s"] = rate_of(bytes);
}

}  // namespace

void add_reads(const Options& options) {
    const std::filesystem::path folder = options.cache / "read";
    for (const auto& [encoding, files] : formats) {
        for (const std::filesystem::path& file : files) {
            for (const int threads : thread_counts()) {
                add_benchmark("read/" + file.stem().string() + "/" + encoding, threads, options,
                              [=](benchmark::State& state) { run_read(state, folder / file, threads); });
            }
        }
    }
    add_benchmark("read/3mf/inflate_alone", 1, options,
                  [=](benchmark::State& state) { run_inflate(state, folder / "3mf.3mf"); });
}

}  // namespace lamella::bench
