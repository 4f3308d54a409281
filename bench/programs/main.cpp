// Benchmarks of the engine. Options besides Google Benchmark's: --cache=DIR, --shared=DIR, --max-threads=N, --quick.
#include <cstddef>
#include <vector>

#include "copy_bandwidth.hpp"
#include "measure.hpp"

int main(int argument_count, char** argument_values) {
    using namespace lamella::bench;  // NOLINT(google-build-using-namespace)
    std::vector<char*> arguments(argument_values, argument_values + argument_count);
    const Options options = take_options(arguments);
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
