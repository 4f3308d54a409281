// Times slicing from a triangle soup in memory, or from an STL file in the page cache, to the finished result.
#include <mimalloc.h>

#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Times slicing on so many threads after an untimed `before`. `floor` is that time over what copying would take.
Figures timed(const Options& options, const Prepared& of, std::uint64_t input_bytes, int threads,
              const std::function<void()>& before, const std::function<void()>& slice_once) {
    Figures figures = measure(options, before, slice_once);
    const auto bytes = static_cast<double>(input_bytes + result_bytes(of.info));
    figures["segments/s"] = rate_of(of.info.segments, figures);
    figures["segments"] = static_cast<double>(of.info.segments);
    figures["triangles"] = static_cast<double>(of.mesh->triangles());
    figures["planes"] = static_cast<double>(of.info.layers);
    figures["floor"] = figures["real_time"] / 1000 * copy_bandwidth(threads) / bytes;
    return figures;
}

Figures run_warm(const Options& options, Prepared& of, int threads) {
    return timed(
        options, of, of.mesh->bytes(), threads, [] {}, [&] { of.slice(threads); });
}

/// Memory comes fresh from the system; freeing it is not timed.
Figures run_cold(const Options& options, Prepared& of, int threads) {
    const auto free_all = [&] {
        of.slicer = Slicer();
        of.result = SliceResult();
        mi_collect(true);  // returns the allocator's free memory to the system
    };
    return timed(options, of, of.mesh->bytes(), threads, free_all, [&] { of.slice(threads); });
}

/// The memory of the result and the engine is warm. read_mesh() chooses where the file's bytes go.
Figures run_file(const Options& options, Prepared& of, int threads) {
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
        options, of, mesh.file_bytes, threads, [&] { mesh = MeshFile(); }, read_and_slice);
}

}  // namespace

void run_end_to_end(const Options& options, const Case& wanted) {
    for (const int threads : thread_counts()) {
        if (wanted.only_threads != 0 && wanted.only_threads != threads) {
            continue;
        }
        const auto run = [&](const char* variant, Figures (*run_variant)(const Options&, Prepared&, int)) {
            benchmark(options, "end_to_end/" + wanted.name + "/" + variant, threads, [&] {
                Prepared& of = prepared(wanted);
                of.check(threads);
                return run_variant(options, of, threads);
            });
        };
        run("warm_swept", run_warm);
        if (wanted.cold) {
            run("cold_swept", run_cold);
            run("file_read", run_file);
        }
    }
}

}  // namespace lamella::bench
