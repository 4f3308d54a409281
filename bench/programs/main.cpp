// Benchmarks of the engine. Options besides Google Benchmark's: --cache=DIR, --shared=DIR, --max-threads=N, --quick.
#include <cstddef>
#include <string>
#include <vector>

#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Adds compiler, flags, allocator, threads and sizes to the context of the results; scripts/summarise.py adds the machine.
void describe_context(const Options& options) {
    std::string threads;
    for (const int count : thread_counts(options)) {
        threads += (threads.empty() ? "" : ",") + std::to_string(count);
    }
    benchmark::AddCustomContext("compiler", LAMELLA_BENCH_COMPILER);
    benchmark::AddCustomContext("flags", LAMELLA_BENCH_FLAGS);
    benchmark::AddCustomContext("thread_counts", threads);
#ifdef LAMELLA_BENCH_MIMALLOC
    benchmark::AddCustomContext("allocator", "mimalloc");
#else
    benchmark::AddCustomContext("allocator", "the system's");
#endif
    benchmark::AddCustomContext("sizes", options.quick ? "quick: a hundredth; figures mean nothing" : "full");
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
    if (options.quick) {
        set_copy_size(std::size_t{16} << 20);
    }
    add_copies(options);
    add_nesting_series(options);
    add_reads(options);
    add_regions(options);
    for (const Case& each : make_catalogue(options)) {
        add_end_to_end(options, each);
    }
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
