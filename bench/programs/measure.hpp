// Timing, counters and names that all benchmarks share.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>

#include "prepared.hpp"

namespace lamella::bench {

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

/// The amount of work in one iteration; zeros are not reported.
struct Handled {
    std::uint64_t segments = 0;
    std::uint64_t triangles = 0;
    std::uint64_t contours = 0;
    std::uint64_t planes = 0;
    std::uint64_t bytes = 0;  ///< bytes that must be read or written once, for the floor
};

void count(benchmark::State& state, const Handled& handled, double seconds, int threads);

/// So many items or bytes an iteration, as a rate.
benchmark::Counter rate_of(std::uint64_t items);

/// Registers "NAME/threads:N", NAME being "what/case/variant". The benchmark reports as its error what `run` throws.
void add_benchmark(const std::string& name, int threads, const Options& options, std::function<void(benchmark::State&)> run);

/// One function for each source file of benchmarks.
void add_end_to_end(const Options& options, const Case& wanted);
void add_copies(const Options& options);
void add_nesting_series(const Options& options);
void add_reads(const Options& options);
void add_regions(const Options& options);

}  // namespace lamella::bench
