// Times reading mesh files from the page cache, format by format, beside the time of pread() for the same bytes.
#include <zip.h>

#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/mesh_file.hpp"
#include "measure.hpp"

namespace lamella::bench {

namespace {

struct Format {
    std::string name;
    const char* extension;
    const char* encoding;
};

const std::vector<Format>& formats() {
    static const std::vector<Format> all = {{"stl_ascii", ".stl", "text"},
                                            {"obj", ".obj", "text"},
                                            {"off", ".off", "text"},
                                            {"ply_ascii", ".ply", "text"},
                                            {"vtk_ascii", ".vtk", "text"},
                                            {"vtp_ascii", ".vtp", "text"},
                                            {"stl_binary", ".stl", "binary"},
                                            {"ply_little_endian", ".ply", "binary"},
                                            {"ply_big_endian", ".ply", "binary"},
                                            {"vtk_binary", ".vtk", "binary"},
                                            {"vtk5_binary", ".vtk", "binary"},
                                            {"vtp_raw", ".vtp", "binary"},
                                            {"vtp_base64", ".vtp", "packed"},
                                            {"vtp_zlib", ".vtp", "packed"},
                                            {"3mf", ".3mf", "packed"}};
    return all;
}

/// Where bench/run.sh has bench/python/mesh_formats.py write the files, beside the mesh that they hold.
std::filesystem::path folder_of(const Options& options) {
    return options.cache / (options.quick ? "read-10000" : "read-1000000");
}

std::array<float, 3> corner_of(const MeshView& view, std::uint64_t triangle, std::size_t corner) {
    const std::uint64_t number_bytes = view.coordinate_type == CoordinateType::f32 ? sizeof(float) : sizeof(double);
    const std::byte* const at = view.indices != nullptr ? view.vertices + view.vertex_of(triangle, corner) * view.stride
                                                        : view.vertices + triangle * view.stride + 3 * corner * number_bytes;
    std::array<float, 3> floats;
    std::array<double, 3> doubles;
    if (view.coordinate_type == CoordinateType::f32) {
        std::memcpy(floats.data(), at, sizeof floats);
    } else {
        std::memcpy(doubles.data(), at, sizeof doubles);
        std::copy(doubles.begin(), doubles.end(), floats.begin());
    }
    return floats;
}

/// Empty if both have the same triangles, corner by corner and to the last bit; otherwise the difference.
std::string compare(const MeshView& got, const MeshView& wanted) {
    if (got.triangle_count != wanted.triangle_count) {
        return "reads " + std::to_string(got.triangle_count) + " triangles of " + std::to_string(wanted.triangle_count);
    }
    for (std::uint64_t triangle = 0; triangle < got.triangle_count; ++triangle) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            if (corner_of(got, triangle, corner) != corner_of(wanted, triangle, corner)) {
                return "reads triangle " + std::to_string(triangle) + " wrongly";
            }
        }
    }
    return {};
}

/// Seconds that reading the file's bytes takes, into memory allocated as in read_mesh(), without parsing.
double time_pread(const InputFile& file, int threads) {
    const auto start = std::chrono::steady_clock::now();
    Array<std::byte> bytes;
    bytes.resize_discarding(file.size());
    const bool read = file.read(bytes.span(), Parallel({.threads = threads})).ok();
    benchmark::DoNotOptimize(bytes.data());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return read ? seconds : 0;
}

/// Inflates the mesh part of a 3MF file with libzip and discards it. Returns its size in bytes; zero on failure.
std::uint64_t inflate_model(const std::filesystem::path& file) {
    const std::unique_ptr<zip_t, void (*)(zip_t*)> zip(zip_open(file.c_str(), ZIP_RDONLY, nullptr), zip_discard);
    if (zip == nullptr) {
        return 0;
    }
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> part(zip_fopen(zip.get(), "3D/3dmodel.model", 0), zip_fclose);
    if (part == nullptr) {
        return 0;
    }
    std::vector<char> piece(std::size_t{256} << 10);
    std::uint64_t bytes = 0;
    zip_int64_t got = 0;
    while ((got = zip_fread(part.get(), piece.data(), piece.size())) > 0) {
        bytes += static_cast<std::uint64_t>(got);
    }
    return got == 0 ? bytes : 0;
}

/// Bytes of the file after base64, zlib or zip decoding.
std::uint64_t unpacked_bytes(const Format& format, const std::filesystem::path& path, const MeshFile& mesh) {
    if (format.name == "3mf") {
        return inflate_model(path);
    }
    return format.name.starts_with("vtp") ? 12 * mesh.view().vertex_count + 32 * mesh.triangle_count : mesh.file_bytes;
}

benchmark::Counter rate_of(std::uint64_t bytes) {
    return {static_cast<double>(bytes), benchmark::Counter::kIsIterationInvariantRate};
}

void run_read(benchmark::State& state, const std::filesystem::path& folder, const Format& format, int threads) {
    const std::filesystem::path path = folder / (format.name + format.extension);
    ReadOptions options;
    options.control.threads = threads;
    Result<MeshFile> mesh = read_mesh(path, options);
    const Result<MeshFile> wanted = read_mesh(folder / "mesh.stl");
    const Result<InputFile> input = InputFile::open(path);
    if (!mesh || !wanted || !input) {
        state.SkipWithError((!mesh ? mesh.error() : !wanted ? wanted.error() : input.error()).message.c_str());
        return;
    }
    if (const std::string failure = compare(mesh->view(), wanted->view()); !failure.empty()) {
        state.SkipWithError(failure.c_str());
        return;
    }
    state.counters["bytes/s"] = rate_of(mesh->file_bytes);
    state.counters["unpacked_bytes/s"] = rate_of(unpacked_bytes(format, path, *mesh));
    double pread_seconds = 0;
    const double seconds = measure(
        state,
        [&] {
            mesh = Error{};
            pread_seconds += time_pread(input.value(), threads);
        },
        [&] { mesh = read_mesh(path, options); });
    if (!mesh) {
        state.SkipWithError(mesh.error().message.c_str());
    }
    state.counters["share_of_pread"] = benchmark::Counter(pread_seconds / static_cast<double>(state.iterations()) / seconds);
    state.counters["threads"] = benchmark::Counter(threads);
}

/// Measures the upper bound for a deflate stream: only one thread can inflate it.
void run_inflate(benchmark::State& state, const std::filesystem::path& path) {
    const std::uint64_t bytes = inflate_model(path);
    if (bytes == 0) {
        state.SkipWithError("the model part does not inflate");
        return;
    }
    measure(state, [&] { benchmark::DoNotOptimize(inflate_model(path)); });
    state.counters["unpacked_bytes/s"] = rate_of(bytes);
    state.counters["threads"] = benchmark::Counter(1);
}

}  // namespace

void add_reads(const Options& options) {
    const std::filesystem::path folder = folder_of(options);
    for (const Format& format : formats()) {
        for (const int threads : thread_counts(options)) {
            add_benchmark(benchmark_name("read", format.name, format.encoding, threads), options,
                          [=](benchmark::State& state) { run_read(state, folder, format, threads); });
        }
    }
    add_benchmark(benchmark_name("read", "3mf", "inflate_alone", 1), options,
                  [=](benchmark::State& state) { run_inflate(state, folder / "3mf.3mf"); });
}

}  // namespace lamella::bench
