// Times slicing from a triangle soup in memory, or from an STL file in the page cache, to the finished result.
#include <mimalloc.h>

#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Times `slice_once` after an untimed `before`.
template <class Before, class Slice>
void run(benchmark::State& state, const Prepared& of, std::uint64_t input_bytes, int threads, const Before& before,
         const Slice& slice_once) {
    const double seconds = measure(state, before, slice_once);
    const auto bytes = static_cast<double>(input_bytes + result_bytes(of.info));
    state.counters["segments/s"] = rate_of(of.info.segments);
    state.counters["segments"] = static_cast<double>(of.info.segments);
    state.counters["triangles"] = static_cast<double>(of.mesh->triangles());
    state.counters["planes"] = static_cast<double>(of.info.layers);
    state.counters["floor"] = seconds * copy_bandwidth(threads) / bytes;
}

void run_warm(benchmark::State& state, Prepared& of, int threads) {
    of.slice(threads);
    run(
        state, of, of.mesh->bytes(), threads, [] {}, [&] { of.slice(threads); });
}

/// Memory comes fresh from the system; freeing it is not timed.
void run_cold(benchmark::State& state, Prepared& of, int threads) {
    const auto free_all = [&] {
        of.slicer = Slicer();
        of.result = SliceResult();
        mi_collect(true);  // returns the allocator's free memory to the system
    };
    run(state, of, of.mesh->bytes(), threads, free_all, [&] { of.slice(threads); });
}

/// The memory of the result and the engine is warm. read_mesh() chooses where the file's bytes go.
void run_file(benchmark::State& state, Prepared& of, int threads) {
    const auto read = [&] { return checked(read_mesh(of.mesh->file, {}, {.threads = threads})); };
    MeshFile mesh = read();
    if (mesh.triangle_count != of.mesh->triangles()) {
        fail("the file holds another mesh");
    }
    const std::uint64_t file_bytes = mesh.file_bytes;
    const auto read_and_slice = [&] {
        mesh = read();
        of.slice(mesh, threads);
    };
    run(
        state, of, file_bytes, threads, [&] { mesh = MeshFile(); }, read_and_slice);
}

}  // namespace

void add_end_to_end(const Options& options, const Case& wanted) {
    for (const int threads : thread_counts()) {
        if (wanted.only_threads != 0 && wanted.only_threads != threads) {
            continue;
        }
        const auto add = [&](const std::string& variant, void (*run_variant)(benchmark::State&, Prepared&, int)) {
            add_benchmark("end_to_end/" + wanted.name + "/" + variant, threads, options, [=](benchmark::State& state) {
                Prepared& of = prepared(wanted);
                of.check(threads);
                run_variant(state, of, threads);
            });
        };
        add("warm_swept", run_warm);
        if (wanted.cold) {
            add("cold_swept", run_cold);
            add("file_read", run_file);
        }
    }
}

}  // namespace lamella::bench
