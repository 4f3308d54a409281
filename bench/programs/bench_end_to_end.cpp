// Times slicing from a triangle soup in memory, or from an STL file in the page cache, to the finished result; and where
// threads have no core each.
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>

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

/// A process that spins on a core while it is let.
class Neighbour {
public:
    Neighbour() : process_(fork()) {
        if (process_ == 0) {
            prctl(PR_SET_PDEATHSIG, SIGKILL);
            cpu_set_t own;
            CPU_ZERO(&own);
            CPU_SET(sched_getcpu(), &own);
            sched_setaffinity(0, sizeof own, &own);
            for (volatile bool spins = true; spins;) {
            }
        }
    }
    ~Neighbour() {
        kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
    }
    Neighbour(const Neighbour&) = delete;
    Neighbour& operator=(const Neighbour&) = delete;

    void let(bool spin) const { kill(process_, spin ? SIGCONT : SIGSTOP); }

private:
    pid_t process_;
};

/// Slices on `threads` threads take turns with slices on as many as cores; beside the former a neighbour spins, or not.
Figures time_crowded(Prepared& of, int threads, bool with_neighbour) {
    const Neighbour neighbour;
    Slicer others;  // keeps its threads
    const auto slice = [&](Slicer& slicer, int count, bool spin) {
        neighbour.let(spin);
        checked(slice_tuned(slicer, of.result, of.mesh->view(), of.plan.options, of.plan.tuning, {.threads = count}));
    };
    const Figures ms = medians_of({{"alone", [&] { slice(of.slicer, thread_counts().back(), false); }},
                                   {"pressed", [&] { slice(others, threads, with_neighbour); }}},
                                  9);
    return {{"alone_ms", ms.at("alone")}, {"over", ms.at("pressed") / ms.at("alone")}};
}

void add_crowded(const Options& options, const Case& wanted) {
    const int cores = thread_counts().back();
    const auto add = [&](const std::string& variant, int threads) {
        add_benchmark(options, "cores/" + wanted.name + "/" + variant, threads,
                      [=](benchmark::State&) { return time_crowded(prepared(wanted), threads, variant == "neighbour"); });
    };
    for (const int times : {2, 4, 8}) {
        add("times_" + std::to_string(times), times * cores);
    }
    add("neighbour", cores);
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
        if (wanted.from_file) {
            add("file_read", time_file);
        }
    }
    if (wanted.hosts) {
        add_crowded(options, wanted);
    }
}

}  // namespace lamella::bench
