// Times slicing from a triangle soup in memory, or from an STL file in the page cache, to the finished result.
#include "base/dispatch.hpp"
#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Times slicing on so many threads after an untimed `before`. `times_limit` is that time over the least that memory allows:
/// to read the input once and to write the result once.
Figures timed(benchmark::State& state, const Prepared& of, std::uint64_t input_bytes, int threads,
              const std::function<void()>& before, const std::function<void()>& slice_once) {
    Figures figures = measure(state, before, slice_once);
    const auto [read, write] = bandwidth(threads);
    const double limit_s = static_cast<double>(input_bytes) / read + static_cast<double>(result_bytes(of.info)) / write;
    figures["segments/s"] = rate_of(of.info.segments, figures);
    figures["segments"] = static_cast<double>(of.info.segments);
    figures["triangles"] = static_cast<double>(of.mesh->triangles());
    figures["planes"] = static_cast<double>(of.info.layers);
    figures["times_limit"] = figures["real_time"] / 1000 / limit_s;
    return figures;
}

Figures time_warm(benchmark::State& state, Prepared& of, int threads) {
    return timed(
        state, of, of.mesh->bytes(), threads, [] {}, [&] { of.slice(threads); });
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
        const auto add = [&](const std::string& variant, Figures (*time_variant)(benchmark::State&, Prepared&, int),
                             std::optional<InstructionSet> level = {}) {
            add_benchmark(options, "end_to_end/" + wanted.name + "/" + variant, threads, [=](benchmark::State& state) {
                Prepared& of = prepared(wanted);
                of.plan.tuning.instructions = level;
                of.check(threads);
                return time_variant(state, of, threads);
            });
        };
        add("warm_swept", time_warm);
        if (wanted.from_file) {
            add("file_read", time_file);
            for (const InstructionSet level : {InstructionSet::portable, InstructionSet::avx2}) {
                if (runs(level) && level < instruction_set()) {
                    add("warm_" + std::string(name_of(level)), time_warm, level);
                }
            }
        }
    }
}

}  // namespace lamella::bench
