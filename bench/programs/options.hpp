// Command-line options that the benchmark programs share.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lamella::bench {

struct Options {
    std::filesystem::path cache = "bench-models";  ///< generated meshes are kept here from run to run
    std::filesystem::path shared;                  ///< folder of real meshes, if there are any
    bool quick = false;                            ///< a hundredth of all sizes, to test the benchmarks
    int max_threads = 0;                           ///< 0: as many as the machine has
};

/// Removes --cache=DIR, --shared=DIR, --quick and --max-threads=N from `arguments` and leaves the rest.
Options take_options(std::vector<char*>& arguments);

/// 1, 2, 4, ... and the maximum.
std::vector<int> thread_counts(const Options& options);

}  // namespace lamella::bench
