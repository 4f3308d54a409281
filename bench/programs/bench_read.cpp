// Times reading mesh files from the page cache, format by format, beside the time of pread() for the same bytes.
#include <zip.h>

#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/mesh_file.hpp"
#include "measure.hpp"
#include "mesh_writers.hpp"

namespace lamella::bench {

namespace {

/// A mesh and its files. Each file is written when it is first asked for.
class Files {
public:
    struct File {
        std::filesystem::path path;
        std::uint64_t bytes = 0;
        std::uint64_t unpacked_bytes = 0;
    };

    explicit Files(const Options& options) : options_(options) {}

    const WeldedMesh& mesh() const noexcept { return mesh_; }

    Result<File> get(const MeshWriter& writer);

private:
    Status make_mesh();

    Options options_;
    WeldedMesh mesh_;
    std::map<std::string_view, File> files_;
};

Status Files::make_mesh() {
    const std::uint64_t triangles = options_.quick ? 10'000 : 1'000'000;
    const Result<std::filesystem::path> stl =
        cached_mesh({.shape = models::Shape::bone, .triangles = triangles}, options_.cache);
    const Result<Mesh> soup = stl ? load_mesh(*stl) : Result<Mesh>(stl.error());
    if (!soup) {
        return soup.error();
    }
    Result<WeldedMesh> welded = weld(soup->view(), {.tolerance_mm = 0});
    if (!welded) {
        return welded.error();
    }
    mesh_ = std::move(welded).value();
    return {};
}

Result<Files::File> Files::get(const MeshWriter& writer) {
    if (mesh_.vertex_count == 0) {
        if (Status made = make_mesh(); !made) {
            return made.error();
        }
    }
    const auto [at, is_new] = files_.try_emplace(writer.name);
    File& file = at->second;
    if (is_new) {
        file.path = options_.cache / ("read-" + std::string(writer.name) + std::string(writer.extension));
        file.unpacked_bytes = writer.write(mesh_, file.path);
        std::error_code missing;
        file.bytes = std::filesystem::file_size(file.path, missing);
        file.bytes = missing ? 0 : file.bytes;
    }
    if (file.unpacked_bytes == 0) {
        return Error{ErrorCode::unwritable_file, file.path.string() + " cannot be written"};
    }
    return file;
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

void run_read(benchmark::State& state, Files& files, const MeshWriter& writer, int threads) {
    const Result<Files::File> file = files.get(writer);
    if (!file) {
        state.SkipWithError(file.error().message.c_str());
        return;
    }
    ReadOptions options;
    options.control.threads = threads;
    Result<MeshFile> mesh = read_mesh(file->path, options);
    const std::string failure = mesh ? compare(mesh->view(), files.mesh().view()) : mesh.error().message;
    const Result<InputFile> input = InputFile::open(file->path);
    if (!failure.empty() || !input) {
        state.SkipWithError((failure.empty() ? input.error().message : failure).c_str());
        return;
    }
    double pread_seconds = 0;
    const double seconds = measure(
        state,
        [&] {
            mesh = Error{};
            pread_seconds += time_pread(input.value(), threads);
        },
        [&] { mesh = read_mesh(file->path, options); });
    if (!mesh) {
        state.SkipWithError(mesh.error().message.c_str());
    }
    using benchmark::Counter;
    const auto rate = [](std::uint64_t bytes) {
        return Counter(static_cast<double>(bytes), Counter::kIsIterationInvariantRate);
    };
    state.counters["bytes/s"] = rate(file->bytes);
    state.counters["unpacked_bytes/s"] = rate(file->unpacked_bytes);
    state.counters["share_of_pread"] = Counter(pread_seconds / static_cast<double>(state.iterations()) / seconds);
    state.counters["threads"] = Counter(threads);
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

/// Measures the upper bound for a deflate stream: only one thread can inflate it.
void run_inflate(benchmark::State& state, Files& files, const MeshWriter& writer) {
    const Result<Files::File> file = files.get(writer);
    if (!file || inflate_model(file->path) != file->unpacked_bytes) {
        state.SkipWithError("the model part does not inflate");
        return;
    }
    measure(state, [&] { benchmark::DoNotOptimize(inflate_model(file->path)); });
    state.counters["unpacked_bytes/s"] =
        benchmark::Counter(static_cast<double>(file->unpacked_bytes), benchmark::Counter::kIsIterationInvariantRate);
    state.counters["threads"] = benchmark::Counter(1);
}

const char* name_of(Encoding encoding) {
    constexpr std::array names = {"text", "binary", "packed"};
    return names[static_cast<std::size_t>(encoding)];
}

}  // namespace

void add_reads(const Options& options) {
    const auto files = std::make_shared<Files>(options);
    for (const MeshWriter& writer : mesh_writers()) {
        const std::string format(writer.name);
        for (const int threads : thread_counts(options)) {
            add_benchmark(benchmark_name("read", format, name_of(writer.encoding), threads), options,
                          [=](benchmark::State& state) { run_read(state, *files, writer, threads); });
        }
        if (writer.name == "3mf") {
            add_benchmark(benchmark_name("read", format, "inflate_alone", 1), options,
                          [=](benchmark::State& state) { run_inflate(state, *files, writer); });
        }
    }
}

}  // namespace lamella::bench
