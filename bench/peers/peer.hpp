// What the programs that time another library's slicing share: the command line, the engine's answer for comparison,
// and one line of JSON.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "timing.hpp"

namespace lamella::peers {

struct Problem {
    std::span<const float> soup;    ///< mm, nine numbers a triangle
    std::vector<double> planes_mm;  ///< ascending; the engine's exact plane heights, so that both cut at the same heights
    int threads = 1;

    std::size_t triangles() const noexcept { return soup.size() / 9; }
};

/// By plane: number of contours, closed and open. Counted after the clock has stopped.
using Counts = std::vector<std::uint64_t>;

/// From the soup to the library's own mesh and search tree; from there to the contours of all planes, in memory and linked.
using Seconds = std::array<double, 2>;

using Run = Seconds (*)(const Problem&, Counts&);

/// main() of a peer's program. Exit status: 0 done, 75 over the time limit, 1 failed.
int run_peer(Run run, int count, char** words) noexcept;

using bench::seconds_since;

}  // namespace lamella::peers
