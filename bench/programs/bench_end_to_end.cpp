// Times slicing from a triangle soup in memory, or from an STL file in the page cache, to the finished result.
#include <memory>

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
    bool ok = true;
    const double seconds = measure(state, before, [&] { ok = slice_once() && ok; });
    if (!ok) {
        state.SkipWithError("slicing failed");
    }
    count(state,
          {.segments = prepared.summary().segments,
           .triangles = prepared.mesh().triangles(),
           .planes = prepared.planes(),
           .bytes = input_bytes + prepared.result_bytes()},
          seconds, threads);
}

void run_warm(benchmark::State& state, Prepared& prepared, int threads) {
    const SliceOptions options = prepared.options(threads);
    const MeshView view = prepared.mesh().view();
    const auto slice_once = [&] { return slice(view, options, prepared.workspace, prepared.result).ok(); };
    (void)slice_once();
    run(
        state, prepared, prepared.mesh().bytes(), threads, [] {}, slice_once);
}

/// Memory comes fresh from the system; freeing it is not timed.
void run_cold(benchmark::State& state, Prepared& prepared, int threads) {
    const SliceOptions options = prepared.options(threads);
    const MeshView view = prepared.mesh().view();
    std::unique_ptr<Workspace> workspace;
    std::unique_ptr<SliceResult> result;
    const auto free_all = [&] {
        workspace.reset();
        result.reset();
        empty_allocator();
    };
    run(state, prepared, prepared.mesh().bytes(), threads, free_all, [&] {
        workspace = std::make_unique<Workspace>();
        result = std::make_unique<SliceResult>();
        return slice(view, options, *workspace, *result).ok();
    });
}

/// The memory of the result and the engine is warm. read_mesh() chooses where the file's bytes go.
void run_file(benchmark::State& state, Prepared& prepared, int threads) {
    const SliceOptions options = prepared.options(threads);
    ReadOptions reading;
    reading.control.threads = threads;
    Result<MeshFile> mesh = read_mesh(prepared.mesh().file, reading);
    if (!mesh || mesh->triangle_count != prepared.mesh().triangles()) {
        state.SkipWithError(mesh ? "the file holds another mesh" : mesh.error().message.c_str());
        return;
    }
    const std::uint64_t file_bytes = mesh->file_bytes;
    run(
        state, prepared, file_bytes, threads, [&] { mesh = Error{}; },
        [&] {
            mesh = read_mesh(prepared.mesh().file, reading);
            return mesh.ok() && slice(mesh->view(), options, prepared.workspace, prepared.result).ok();
        });
}

}  // namespace

void add_end_to_end(const Options& options, const Case& wanted) {
    const Measured& measured = wanted.measured;
    for (const int threads : thread_counts(options)) {
        if (measured.single_use && measured.threads != threads) {
            continue;
        }
        const auto add = [&](const std::string& variant, void (*run_variant)(benchmark::State&, Prepared&, int)) {
            add_case_benchmark(benchmark_name("end_to_end", wanted.name, variant, threads), options, wanted,
                               [=](benchmark::State& state, Prepared& prepared) {
                                   if (const std::string failure = prepared.check(threads); !failure.empty()) {
                                       state.SkipWithError(failure.c_str());
                                       return;
                                   }
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
