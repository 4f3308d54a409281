// Times slicing from a triangle soup in memory, or from an STL file in the page cache, to the finished result.
#include <mimalloc.h>

#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Times slicing on so many threads after an untimed `before`. `floor` is that time over what copying would take.
Figures timed(benchmark::State& state, const Prepared& of, std::uint64_t input_bytes, int threads,
              const std::function<void()>& before, const std::function<void()>& slice_once) {
    Figures figures = measure(state, before, slice_once);
    const auto bytes = static_cast<double>(input_bytes + result_bytes(of.info));
    figures["segments/s"] = rate_of(of.info.segments, figures);
    figures["segments"] = static_cast<double>(of.info.segments);
    figures["triangles"] = static_cast<double>(of.mesh->triangles());
    figures["planes"] = static_cast<double>(of.info.layers);
    figures["floor"] = figures["real_time"] / 1000 * copy_bandwidth(threads) / bytes;
    return figures;
}

Figures time_warm(benchmark::State& state, Prepared& of, int threads) {
    return timed(
        state, of, of.mesh->bytes(), threads, [] {}, [&] { of.slice(threads); });
}

/// Memory comes fresh from the system; freeing it is not timed.
Figures time_cold(benchmark::State& state, Prepared& of, int threads) {
    const auto free_all = [&] {
        of.slicer = Slicer();
        of.result = SliceResult();
        mi_collect(true);  // returns the allocator's free memory to the system
    };
    return timed(state, of, of.mesh->bytes(), threads, free_all, [&] { of.slice(threads); });
}

/// The memory of the result and the engine is warm. read_mesh() chooses where the file's bytes go.
Figures time_file(benchmark::State& state, Prepared& of, int threads) {
    const auto read = [&] { return checked(read_mesh(of.mesh->file, {}, {.threads = threads})); };
    MeshFile mesh = read();
    if (mesh.triangle_count != of.mesh->triangles()) {
        fail("the file holds another mesh");
    }
    const auto read_and_slice = [&] {
        mesh = read();
        of.slice(mesh, threads);
    };
    return timed(
        state, of, mesh.file_bytes, threads, [&] { mesh = MeshFile(); }, read_and_slice);
}

}  // namespace

void add_end_to_end(const Options& options, const Case& wanted) {
    for (const int threads : thread_counts()) {
        if (wanted.only_threads != 0 && wanted.only_threads != threads) {
            continue;
        }
        const auto add = [&](const std::string& variant, Figures (*time_variant)(benchmark::State&, Prepared&, int)) {
            add_benchmark(options, "end_to_end/" + wanted.name + "/" + variant, threads, [=](benchmark::State& state) {
                Prepared& of = prepared(wanted);
                of.check(threads);
                return time_variant(state, of, threads);
            });
        };
        add("warm_swept", time_warm);
        if (wanted.cold) {
            add("cold_swept", time_cold);
            add("file_read", time_file);
        }
    }
}

}  // namespace lamella::bench
