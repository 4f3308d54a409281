// Which meshes are sliced, at which planes, and what is known of the answer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh.hpp"
#include "slicing/tuning.hpp"

namespace lamella::bench {

/// Options of the command line that benchmark programs share.
struct Options {
    std::filesystem::path cache = "bench-models";  ///< generated meshes are kept here from run to run
    std::filesystem::path shared;                  ///< folder of real meshes, if there are any
    bool quick = false;                            ///< a hundredth of all sizes, to test the benchmarks
    int max_threads = 0;                           ///< 0: as many as the machine has
};

/// Takes in --cache=DIR, --shared=DIR, --quick and --max-threads=N. False for other arguments.
bool take_option(std::string_view argument, Options& options);

/// 1, 2, 4, ... and the maximum.
std::vector<int> thread_counts(const Options& options);

/// Counts of the paper authors' own program at grid 0.004 mm and layers of 0.032 mm, with the first plane 0.008 mm
/// above the lowest point.
struct KnownAnswer {
    std::uint64_t planes, segments, contours, open;
};

/// Which benchmarks measure a case.
struct Measured {
    bool partition = false;   ///< bands and parts alone
    bool cold = false;        ///< end to end with fresh memory too
    bool from_file = false;   ///< end to end from a file in the page cache too
    bool single_use = false;  ///< the above only at the thread count in `threads`
    int threads = 0;
};

/// Where a case is cut.
struct Plan {
    SliceOptions options{};
    Tuning tuning{};
};

struct Case {
    std::string name;
    std::function<Mesh()> mesh;
    std::string mesh_name;  ///< equal for cases of the same mesh, which are neighbours in the catalogue
    std::function<Plan(const Mesh&)> plan;
    Measured measured;
    std::uint64_t triangles = 0;  ///< stated number, checked within 1 %; 0: not stated
    std::uint64_t segments = 0;   ///< stated number, checked within 5 %; 0: not stated
    std::optional<KnownAnswer> known{};
};

std::vector<Case> make_catalogue(const Options& options);

}  // namespace lamella::bench
