// Times reading mesh files from the page cache, format by format, beside the time of pread() for the same bytes.
#include <zip.h>

#include <cstring>
#include <filesystem>
#include <memory>
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

/// Nine floats a triangle, of soup or of indices, of floats or doubles.
std::vector<float> soup_of(const MeshView& view) {
    const bool indexed = view.indices != nullptr;
    const std::size_t bytes = size_of(view.vertex_type);
    std::vector<float> soup(9 * view.triangle_count);
    for (std::size_t i = 0; i < soup.size(); ++i) {
        const std::byte* const vertex = view.vertex_at(indexed ? view.vertex_of(i / 9, i % 9 / 3) : i / 9);
        const std::byte* const at = vertex + bytes * (indexed ? i % 3 : i % 9);
        double wide = 0;
        std::memcpy(view.vertex_type == Number::f32 ? static_cast<void*>(&soup[i]) : &wide, at, bytes);
        soup[i] = view.vertex_type == Number::f32 ? soup[i] : static_cast<float>(wide);
    }
    return soup;
}

/// Milliseconds that reading the file's bytes takes, into memory allocated as in read_mesh(), without parsing.
double time_pread(const InputFile& file, int threads) {
    return ms_of([&] {
        Array<std::byte> bytes;
        bytes.resize_discarding(file.size());
        const Parallel parallel({.threads = threads});
        if (!file.read(bytes.span(), parallel).ok()) {
            fail("the file cannot be read");
        }
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

Figures time_read(benchmark::State& state, const std::filesystem::path& path, int threads) {
    const auto read = [&] { return checked(read_mesh(path, {}, {.threads = threads})); };
    MeshFile mesh = read();
    const InputFile input = checked(InputFile::open(path));
    if (soup_of(mesh.view()) != soup_of(checked(read_mesh(path.parent_path() / "mesh.stl")).view())) {
        fail("reads other triangles than were written");
    }
    double pread_ms = 0;
    const auto before = [&] {
        mesh = MeshFile();
        pread_ms += time_pread(input, threads);
    };
    Figures figures = measure(state, before, [&] { mesh = read(); });
    figures["bytes/s"] = rate_of(mesh.file_bytes, figures);
    figures["unpacked_bytes/s"] = rate_of(unpacked_bytes(path, mesh), figures);
    figures["share_of_pread"] = pread_ms / static_cast<double>(state.iterations()) / figures["real_time"];
    return figures;
}

/// Measures the upper bound for a deflate stream: only one thread can inflate it.
Figures time_inflate(benchmark::State& state, const std::filesystem::path& path) {
    const std::uint64_t bytes = inflate_model(path);
    Figures figures = measure(state, [&] { inflate_model(path); });
    figures["unpacked_bytes/s"] = rate_of(bytes, figures);
    return figures;
}

}  // namespace

void add_reads(const Options& options) {
    const std::filesystem::path folder = options.cache / "read";
    for (const auto& [encoding, files] : formats) {
        for (const std::filesystem::path& file : files) {
            for (const int threads : thread_counts()) {
                add_benchmark(options, "read/" + file.stem().string() + "/" + encoding, threads,
                              [=](benchmark::State& state) { return time_read(state, folder / file, threads); });
            }
        }
    }
    add_benchmark(options, "read/3mf/inflate_alone", 1,
                  [=](benchmark::State& state) { return time_inflate(state, folder / "3mf.3mf"); });
}

}  // namespace lamella::bench
