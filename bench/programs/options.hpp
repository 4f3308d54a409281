// What the benchmark programs are told on their command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lamella::bench {

struct Options {
    std::filesystem::path cache = "bench-models";  ///< generated meshes are kept here from run to run
    std::filesystem::path shared;                  ///< real meshes, where there are any
    bool quick = false;                            ///< everything a hundredth of its size: tests the benchmarks
    int max_threads = 0;                           ///< 0: as many as the machine has
};

/// Takes --cache=DIR, --shared=DIR, --quick and --max-threads=N out of `arguments` and leaves the rest.
Options take_options(std::vector<char*>& arguments);

/// 1, 2, 4, ... and the most.
std::vector<int> thread_counts(const Options& options);

}  // namespace lamella::bench
