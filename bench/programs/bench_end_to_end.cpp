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

Handled handled_by(const Prepared& prepared, std::uint64_t input_bytes) {
    return {.segments = prepared.summary().segments,
            .triangles = prepared.mesh().triangles(),
            .planes = prepared.planes(),
            .bytes = input_bytes + prepared.result_bytes()};
}

void run_warm(benchmark::State& state, Prepared& prepared, ContourForm form, int threads) {
    if (const std::string failure = prepared.check(form, threads); !failure.empty()) {
        state.SkipWithError(failure.c_str());
        return;
    }
    const SliceOptions options = prepared.options(form, threads);
    const MeshView view = prepared.mesh().view();
    bool ok = slice(view, options, prepared.workspace, prepared.result).ok();
    const double seconds =
        measure(state, [&] { ok = ok && slice(view, options, prepared.workspace, prepared.result).ok(); });
    if (!ok) {
        state.SkipWithError("slicing failed");
    }
    count(state, handled_by(prepared, prepared.mesh().bytes()), seconds, threads);
}

/// Memory comes fresh from the system; freeing it is not timed.
void run_cold(benchmark::State& state, Prepared& prepared, ContourForm form, int threads) {
    if (const std::string failure = prepared.check(form, threads); !failure.empty()) {
        state.SkipWithError(failure.c_str());
        return;
    }
    const SliceOptions options = prepared.options(form, threads);
    const MeshView view = prepared.mesh().view();
    std::unique_ptr<Workspace> workspace;
    std::unique_ptr<SliceResult> result;
    bool ok = true;
    const double seconds = measure(
        state,
        [&] {
            workspace.reset();
            result.reset();
            empty_allocator();
        },
        [&] {
            workspace = std::make_unique<Workspace>();
            result = std::make_unique<SliceResult>();
            ok = ok && slice(view, options, *workspace, *result).ok();
        });
    if (!ok) {
        state.SkipWithError("slicing failed");
    }
    count(state, handled_by(prepared, prepared.mesh().bytes()), seconds, threads);
}

/// The memory of the result and the engine is warm. read_mesh() chooses where the file's bytes go.
void run_file(benchmark::State& state, Prepared& prepared, bool map_file, int threads) {
    std::string failure = prepared.check(ContourForm::swept, threads);
    const SliceOptions options = prepared.options(ContourForm::swept, threads);
    ReadOptions reading;
    reading.control.threads = threads;
    reading.map_file = map_file;
    Result<MeshFile> mesh = read_mesh(prepared.mesh().file, reading);
    if (failure.empty() && (!mesh || mesh->triangle_count != prepared.mesh().triangles())) {
        failure = mesh ? "the file holds another mesh" : mesh.error().message;
    }
    if (!failure.empty()) {
        state.SkipWithError(failure.c_str());
        return;
    }
    const std::uint64_t file_bytes = mesh->file_bytes;
    bool ok = true;
    const double seconds = measure(
        state, [&] { mesh = Error{}; },
        [&] {
            mesh = read_mesh(prepared.mesh().file, reading);
            ok = ok && mesh && slice(mesh->view(), options, prepared.workspace, prepared.result).ok();
        });
    if (!ok) {
        state.SkipWithError("slicing failed");
    }
    count(state, handled_by(prepared, file_bytes), seconds, threads);
}

}  // namespace

void add_end_to_end(const Options& options, const Case& wanted) {
    const Measured& measured = wanted.measured;
    for (const int threads : thread_counts(options)) {
        if (measured.single_use && measured.threads != threads) {
            continue;
        }
        const auto add = [&](const std::string& variant, auto run) {
            add_case_benchmark(benchmark_name("end_to_end", wanted.name, variant, threads), options, wanted, run);
        };
        const auto add_form = [&](ContourForm form) {
            const std::string suffix = std::string("_") + name_of(form);
            add("warm" + suffix, [=](benchmark::State& state, Prepared& p) { run_warm(state, p, form, threads); });
            if (measured.cold) {
                add("cold" + suffix, [=](benchmark::State& state, Prepared& p) { run_cold(state, p, form, threads); });
            }
        };
        add_form(ContourForm::swept);
        if (measured.assembled) {
            add_form(ContourForm::assembled);
        }
        if (measured.from_file) {
            add("file_read", [=](benchmark::State& state, Prepared& p) { run_file(state, p, false, threads); });
            add("file_mapped", [=](benchmark::State& state, Prepared& p) { run_file(state, p, true, threads); });
        }
    }
}

}  // namespace lamella::bench
