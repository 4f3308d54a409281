// Benchmarks of the engine. Options besides Google Benchmark's: --cache DIR, --shared DIR, --quick.
#include <CLI/CLI.hpp>

#include "measure.hpp"

namespace lamella::bench {

namespace {

void add_all(const Options& options) {
    for (const int threads : thread_counts()) {
        add_benchmark(options, "bandwidth/memory/warm", threads, [=](benchmark::State&) {
            return Figures{{"read", bandwidth(threads).read}, {"write", bandwidth(threads).write}};
        });
    }
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
        if (each.partition) {
            add_partition(options, each);
        }
        if (each.regions) {
            add_slices_with_regions(options, each);
        }
    }
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) try {
    benchmark::Initialize(&count, words);
    lamella::bench::Options options;
    CLI::App others("Benchmarks of the engine");
    others.add_option("--cache", options.cache, "Folder in which generated meshes are kept");
    others.add_option("--shared", options.shared, "Folder of real meshes");
    others.add_flag("--quick", options.quick, "A hundredth of all sizes, to test the benchmarks");
    others.add_option(
        "--modelled", options.modelled,
        "Machine of partition/: GB/s of a core, GB/s and cores of a socket, us to wake a thread, GB/s of fresh pages");
    CLI11_PARSE(others, count, words);
    lamella::bench::add_all(options);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
} catch (const std::exception& failure) {
    std::fprintf(stderr, "%s: %s\n", words[0], failure.what());
    return 1;
}
