// What all benchmarks share: cases ready to be timed, timing, counters and names. What fails throws std::runtime_error.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "timing.hpp"

namespace lamella::bench {

/// Bytes read plus bytes written per second when `threads` threads copy warm memory much larger than the caches, to which
/// the `floor` counters refer. The median of several copies, measured once for each run and thread count.
double copy_bandwidth(int threads);

/// A case: its mesh in memory, its answer checked.
class Prepared {
public:
    /// Throws unless the mesh has the stated numbers and its answer is valid.
    Prepared(const Case& wanted, std::shared_ptr<const Mesh> mesh);

    /// Slices into `result`: `from`, or the case's mesh.
    SliceInfo slice(const Source& from, int threads) {
        return checked(slice_tuned(slicer, result, from, plan.options, plan.tuning, {.threads = threads}));
    }
    SliceInfo slice(int threads) { return slice(mesh->view(), threads); }

    /// Throws unless slicing on these threads gives the hash of one thread. Leaves `slicer` and `result` warm.
    void check(int threads);

    std::string name;
    std::string mesh_name;
    std::shared_ptr<const Mesh> mesh;
    Plan plan;
    SliceInfo info;  ///< of one thread
    Slicer slicer;
    SliceResult result;

private:
    void check_known(const KnownAnswer& known);

    std::uint64_t hash_ = 0;
    std::set<int> checked_;
};

/// Prepares the case unless it is the one asked for last, whose mesh the next case may share.
Prepared& prepared(const Case& wanted);

inline std::uint64_t result_bytes(const SliceInfo& info) {
    return info.layers * sizeof(Layer) + info.contours * sizeof(Contour) + info.points * sizeof(Point);
}

/// Times only work(); setup() runs before each call. Returns the mean in seconds.
template <class Setup, class Work>
double measure(benchmark::State& state, Setup&& setup, Work&& work) {
    double all = 0;
    for (auto _ : state) {
        setup();
        const double seconds = seconds_of(work);
        state.SetIterationTime(seconds);
        all += seconds;
    }
    return all / static_cast<double>(std::max<benchmark::IterationCount>(1, state.iterations()));
}

template <class Work>
double measure(benchmark::State& state, Work&& work) {
    return measure(
        state, [] {}, work);
}

/// Reports what was measured before as counters of one iteration.
void report(benchmark::State& state, const Figures& figures);

/// Items or bytes of an iteration, as a rate.
benchmark::Counter rate_of(std::uint64_t items);

/// Registers "NAME/threads:N", NAME being "what/case/variant". The benchmark reports as its error what `run` throws.
benchmark::internal::Benchmark* add_benchmark(const std::string& name, int threads, const Options& options,
                                              std::function<void(benchmark::State&)> run);

// One function for each source file of benchmarks.
void add_end_to_end(const Options& options, const Case& wanted);
void add_partition(const Options& options, const Case& wanted);
void add_hosts(const Options& options, const Case& wanted);
void add_small_calls(const Options& options);
void add_slices_with_regions(const Options& options, const Case& wanted);
void add_regions(const Options& options);
void add_nesting(const Options& options);
void add_reads(const Options& options);
void add_masks(const Options& options);

}  // namespace lamella::bench
