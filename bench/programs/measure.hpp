// What all benchmarks share: cases ready to be timed, timing, names and figures. What fails throws std::runtime_error.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "timing.hpp"

namespace lamella::bench {

/// Bytes a second that so many threads read, and that they write past the caches: the best of nine passes over 1 GB of warm
/// memory in huge pages, measured once for each run and thread count.
struct Bandwidth {
    double read;
    double write;
};
const Bandwidth& bandwidth(int threads);

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
};

/// Prepares the case unless it is the one asked for last, whose mesh the next case may share.
Prepared& prepared(const Case& wanted);

/// Times only work(); setup() runs before each iteration. "real_time" is the mean, ms.
Figures measure(benchmark::State& state, const std::function<void()>& setup, const std::function<void()>& work);
inline Figures measure(benchmark::State& state, const std::function<void()>& work) {
    return measure(
        state, [] {}, work);
}

/// Items a second of what was measured.
inline double rate_of(std::uint64_t items, const Figures& figures) {
    return 1000 * static_cast<double>(items) / figures.at("real_time");
}

/// Registers the benchmark "NAME/threads:N", NAME being "what/case/variant". It runs after this call. Its counters are the
/// figures that run() returns, its error is what run() throws.
void add_benchmark(const Options& options, const std::string& name, int threads,
                   const std::function<Figures(benchmark::State&)>& run);

// One function for each source file of benchmarks.
void add_end_to_end(const Options& options, const Case& wanted);
void add_hosts(const Options& options, const Case& wanted);
void add_small_calls(const Options& options);
void add_slices_with_regions(const Options& options, const Case& wanted);
void add_regions(const Options& options);
void add_nesting(const Options& options);
void add_reads(const Options& options);
void add_masks(const Options& options);
void add_partition(const Options& options, const Case& wanted);

}  // namespace lamella::bench
