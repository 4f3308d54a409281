// Times slicing from a triangle soup in memory, or from an STL file in the page cache, to the finished result.
#ifdef LAMELLA_BENCH_MIMALLOC
#include <mimalloc.h>
#endif

#include "lamella/io/mesh_file.hpp"
#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Returns the allocator's free memory to the system, so that the next run is cold.
void empty_allocator() {
#ifdef LAMELLA_BENCH_MIMALLOC
    mi_collect(true);
#endif
}

/// Times `slice_once` after an untimed `before`.
template <class Before, class Slice>
void run(benchmark::State& state, Prepared& prepared, std::uint64_t input_bytes, int threads, const Before& before,
         const Slice& slice_once) {
    const double seconds = measure(state, before, slice_once);
    count(state,
          {.segments = prepared.info().segments,
           .triangles = prepared.mesh().triangles(),
           .planes = prepared.info().layers,
           .bytes = input_bytes + prepared.result_bytes()},
          seconds, threads);
}

void run_warm(benchmark::State& state, Prepared& prepared, int threads) {
    const auto slice_once = [&] { prepared.slice(threads); };
    slice_once();
    run(
        state, prepared, prepared.mesh().bytes(), threads, [] {}, slice_once);
}

/// Memory comes fresh from the system; freeing it is not timed.
void run_cold(benchmark::State& state, Prepared& prepared, int threads) {
    const auto free_all = [&] {
        prepared.slicer = Slicer();
        prepared.result = SliceResult();
        empty_allocator();
    };
    run(state, prepared, prepared.mesh().bytes(), threads, free_all, [&] { prepared.slice(threads); });
}

/// The memory of the result and the engine is warm. read_mesh() chooses where the file's bytes go.
void run_file(benchmark::State& state, Prepared& prepared, int threads) {
    const auto read = [&] { return checked(read_mesh(prepared.mesh().file, {}, {.threads = threads})); };
    MeshFile mesh = read();
    if (mesh.triangle_count != prepared.mesh().triangles()) {
        fail("the file holds another mesh");
    }
    const std::uint64_t file_bytes = mesh.file_bytes;
    run(
        state, prepared, file_bytes, threads, [&] { mesh = MeshFile(); },
        [&] {
            mesh = read();
            prepared.slice(mesh, threads);
        });
}

}  // namespace

void add_end_to_end(const Options& options, const Case& wanted) {
    static Preparer preparer;
    const Measured& measured = wanted.measured;
    for (const int threads : thread_counts(options)) {
        if (measured.single_use && measured.threads != threads) {
            continue;
        }
        const auto add = [&](const std::string& variant, void (*run_variant)(benchmark::State&, Prepared&, int)) {
            add_benchmark("end_to_end/" + wanted.name + "/" + variant, threads, options, [=](benchmark::State& state) {
                Prepared& prepared = preparer.get(wanted);
                prepared.check(threads);
                run_variant(state, prepared, threads);
            });
        };
        add("warm_swept", run_warm);
        if (measured.cold) {
            add("cold_swept", run_cold);
        }
        if (measured.from_file) {
            add("file_read", run_file);
        }
    }
}

}  // namespace lamella::bench
