// What the programs that time another library's slicing share: the command line, the engine's answer for comparison,
// and one line of JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "timing.hpp"

namespace lamella::peers {

struct Problem {
    std::span<const float> soup;    ///< mm, nine numbers a triangle
    std::vector<double> planes_mm;  ///< ascending; the engine's exact plane heights, so that both cut at the same heights
    int threads = 1;

    std::size_t triangles() const noexcept { return soup.size() / 9; }
};

/// The library's answer, counted after the clock has stopped.
struct Found {
    std::vector<std::uint64_t> contours;  ///< by plane: number of contours, closed and open
    std::uint64_t segments = 0;
};

struct Times {
    double build_s = 0;  ///< from the soup to the library's own mesh and search tree
    double slice_s = 0;  ///< from there to the contours of all planes, in memory and linked
    double sum() const noexcept { return build_s + slice_s; }
};

struct Peer {
    std::string name;
    std::string version;
    std::string way;  ///< which of the library's slicing methods is used
    Times (*run)(const Problem&, Found&) = nullptr;
};

/// main() of a peer's program. Exit status: 0 done, 75 over the time limit, 1 failed.
int run_program(const Peer& peer, int count, char** words) noexcept;

using bench::seconds_since;
using bench::share_out;

}  // namespace lamella::peers
