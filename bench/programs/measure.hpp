// Timing, counters and names that all benchmarks share.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "options.hpp"
#include "prepared.hpp"

namespace lamella::bench {

/// Times only work(); setup() runs before each call. Returns the mean in seconds.
template <class Setup, class Work>
double measure(benchmark::State& state, Setup&& setup, Work&& work) {
    using Clock = std::chrono::steady_clock;
    double all = 0;
    for (auto _ : state) {
        setup();
        const auto start = Clock::now();
        work();
        const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
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

/// The amount of work in one iteration; zeros are not reported.
struct Handled {
    std::uint64_t segments = 0;
    std::uint64_t triangles = 0;
    std::uint64_t contours = 0;
    std::uint64_t planes = 0;
    std::uint64_t bytes = 0;  ///< bytes that must be read or written once, for the floor
};

void count(benchmark::State& state, const Handled& handled, double seconds, int threads);

/// Registers `name`. `run` is called with the prepared case; if there is none, the benchmark reports why.
void add_case_benchmark(const std::string& name, const Options& options, const Case& wanted,
                        std::function<void(benchmark::State&, Prepared&)> run);
/// Registers a benchmark that needs no case.
void add_benchmark(const std::string& name, const Options& options, std::function<void(benchmark::State&)> run);

/// Returns "what/case/variant/threads:N".
std::string benchmark_name(const std::string& what, const std::string& case_name, const std::string& variant, int threads);

/// One function for each source file of benchmarks.
void add_end_to_end(const Options& options, const Case& wanted);
void add_copies(const Options& options);
void add_nesting_series(const Options& options);
void add_reads(const Options& options);
void add_regions(const Options& options);

/// Adds machine, compiler, flags, threads, pinning and huge pages to the context of the results.
void describe_context(const Options& options);

}  // namespace lamella::bench
