// Benchmarks of the engine. Options besides Google Benchmark's: --cache=DIR, --shared=DIR, --quick.
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "measure.hpp"

namespace lamella::bench {

namespace {

bool take_option(std::string_view argument, Options& options) {
    const std::size_t equals = argument.find('=');
    const std::string_view name = argument.substr(0, equals);
    const std::string_view value = equals < argument.size() ? argument.substr(equals + 1) : "";
    if (name == "--cache") {
        options.cache = value;
    } else if (name == "--shared") {
        options.shared = value;
    } else if (name == "--quick") {
        options.quick = true;
    } else {
        return false;
    }
    return true;
}

/// Adds compiler, flags, allocator, threads and sizes to the context of the results; scripts/summary.py adds the machine.
void describe_context(const Options& options) {
    std::string threads;
    for (const int count : thread_counts()) {
        threads += (threads.empty() ? "" : ",") + std::to_string(count);
    }
    benchmark::AddCustomContext("compiler", LAMELLA_BENCH_COMPILER);
    benchmark::AddCustomContext("flags", LAMELLA_BENCH_FLAGS);
    benchmark::AddCustomContext("thread_counts", threads);
    benchmark::AddCustomContext("allocator", "mimalloc");
    benchmark::AddCustomContext("sizes", options.quick ? "quick: a hundredth; figures mean nothing" : "full");
}

void add_copies(const Options& options) {
    for (const int threads : thread_counts()) {
        add_benchmark("copy/memory/warm", threads, options, [=](benchmark::State& state) {
            report(state, {{"bytes/s", copy_bandwidth(threads)}});
        });
    }
}

void add_all(const Options& options) {
    add_copies(options);
    add_nesting(options);
    add_reads(options);
    add_regions(options);
    add_masks(options);
    add_small_calls(options);
    for (const Case& each : make_catalogue(options)) {
        add_end_to_end(options, each);
        if (each.hosts) {
            add_hosts(options, each);
        }
        if (each.regions) {
            add_slices_with_regions(options, each);
        }
        if (each.partition) {
            add_partition(options, each);
        }
    }
}

}  // namespace

}  // namespace lamella::bench

int main(int argument_count, char** argument_values) {
    using namespace lamella::bench;  // NOLINT(google-build-using-namespace)
    std::vector<char*> arguments(argument_values, argument_values + argument_count);
    Options options;
    std::erase_if(arguments, [&](const char* argument) { return take_option(argument, options); });
    auto count = static_cast<int>(arguments.size());
    describe_context(options);
    benchmark::Initialize(&count, arguments.data());
    if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) {
        return 2;
    }
    add_all(options);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
