#include "measure.hpp"

#include <exception>
#include <utility>

namespace lamella::bench {

void count(benchmark::State& state, const Handled& handled, double seconds, int threads) {
    using benchmark::Counter;
    const auto rate = [&](const char* name, std::uint64_t items) {
        if (items != 0) {
            state.counters[name] = rate_of(items);
        }
    };
    rate("segments/s", handled.segments);
    rate("triangles/s", handled.triangles);
    rate("contours/s", handled.contours);
    if (handled.bytes != 0) {
        state.counters["floor"] = Counter(seconds * copy_bandwidth(threads) / static_cast<double>(handled.bytes));
    }
    state.counters["segments"] = Counter(static_cast<double>(handled.segments));
    state.counters["triangles"] = Counter(static_cast<double>(handled.triangles));
    state.counters["planes"] = Counter(static_cast<double>(handled.planes));
    state.counters["threads"] = Counter(threads);
}

benchmark::Counter rate_of(std::uint64_t items) {
    return {static_cast<double>(items), benchmark::Counter::kIsIterationInvariantRate};
}

void add_benchmark(const std::string& name, int threads, const Options& options,
                   std::function<void(benchmark::State&)> run) {
    benchmark::RegisterBenchmark((name + "/threads:" + std::to_string(threads)).c_str(),
                                 [run = std::move(run)](benchmark::State& state) {
                                     try {
                                         run(state);
                                     } catch (const std::exception& failure) {
                                         state.SkipWithError(failure.what());
                                     }
                                 })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(options.quick ? 0.005 : 0.2)
        ->Repetitions(options.quick ? 1 : 5);
}

void add_copies(const Options& options) {
    for (const int threads : thread_counts(options)) {
        add_benchmark("copy/memory/warm", threads, options, [=](benchmark::State& state) {
            const double bytes_per_s = copy_bandwidth(threads);
            for (auto _ : state) {
                state.SetIterationTime(1e-3);
            }
            state.counters["bytes/s"] = benchmark::Counter(bytes_per_s);
            state.counters["threads"] = benchmark::Counter(threads);
        });
    }
}

}  // namespace lamella::bench
