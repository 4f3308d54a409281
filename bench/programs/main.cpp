// Benchmarks of the engine. Prints a line of JSON for each whose name matches FILTER: its figures, or its error.
#include <string>

#include "measure.hpp"

namespace lamella::bench {

namespace {

void run_all(const Words& words) {
    const Options options{.cache = words[0], .shared = words[1], .filter = words[2], .quick = words[3] == "quick"};
    for (const int threads : thread_counts()) {
        benchmark(options, "copy/memory/warm", threads, [=] { return Figures{{"bytes/s", copy_bandwidth(threads)}}; });
    }
    run_nesting(options);
    run_reads(options);
    run_regions(options);
    run_masks(options);
    run_small_calls(options);
    for (const Case& each : make_catalogue(options)) {
        run_end_to_end(options, each);
        if (each.hosts) {
            run_hosts(options, each);
        }
        if (each.regions) {
            run_slices_with_regions(options, each);
        }
    }
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, "CACHE SHARED FILTER full|quick", lamella::bench::run_all);
}
