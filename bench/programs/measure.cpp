#include "measure.hpp"

#include "copy_bandwidth.hpp"

namespace lamella::bench {

void count(benchmark::State& state, const Handled& handled, double seconds, int threads) {
    using benchmark::Counter;
    const auto rate = [&](const char* name, std::uint64_t items) {
        if (items != 0) {
            state.counters[name] = Counter(static_cast<double>(items), Counter::kIsIterationInvariantRate);
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

void add_benchmark(const std::string& name, const Options& options, std::function<void(benchmark::State&)> run) {
    benchmark::RegisterBenchmark(name.c_str(), std::move(run))
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(options.quick ? 0.005 : 0.2)
        ->Repetitions(options.quick ? 1 : 5);
}

void add_case_benchmark(const std::string& name, const Options& options, const Case& wanted,
                        std::function<void(benchmark::State&, Prepared&)> run) {
    static Preparer preparer;
    add_benchmark(name, options, [wanted, run = std::move(run)](benchmark::State& state) {
        Prepared* prepared = preparer.get(wanted);
        if (prepared == nullptr || !prepared->failure().empty()) {
            state.SkipWithError((prepared == nullptr ? preparer.failure() : prepared->failure()).c_str());
            return;
        }
        run(state, *prepared);
    });
}

std::string benchmark_name(const std::string& what, const std::string& case_name, const std::string& variant, int threads) {
    return what + "/" + case_name + "/" + variant + "/threads:" + std::to_string(threads);
}

void add_copies(const Options& options) {
    for (const int threads : thread_counts(options)) {
        add_benchmark("copy/memory/warm/threads:" + std::to_string(threads), options, [=](benchmark::State& state) {
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
