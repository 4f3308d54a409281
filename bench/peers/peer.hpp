// What the programs that time another library's slicing share: the command line, the engine's answer for comparison,
// and one line of JSON.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "catalogue.hpp"
#include "lamella/lamella.hpp"
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

inline void time_peer(Run run, const bench::Words& words) {
    const bench::Mesh mesh = bench::load_mesh(words[0]);
    const SliceResult expected = bench::checked(slice(mesh.view(), {.layer_height_mm = std::stod(words[1])}));
    Problem problem{mesh.soup.span(), {}, std::stoi(words[2])};
    problem.planes_mm.reserve(expected.layers.size());
    for (const Layer& layer : expected.layers) {
        problem.planes_mm.push_back(layer.plane.z() * expected.info.grid_mm);
    }
    bench::end_after(static_cast<unsigned>(std::stoul(words[3])));  // all runs together
    Counts contours;
    const auto [build_s, slice_s] = bench::repeated<2>([&] {
        contours = {};
        return run(problem, contours);
    });
    bench::end_after(0);
    std::vector<double> total_s(build_s.size());
    std::transform(build_s.begin(), build_s.end(), slice_s.begin(), total_s.begin(), std::plus<>());
    std::uint64_t planes_apart = 0;
    std::uint64_t contours_apart = 0;
    for (std::size_t l = 0; l < contours.size(); ++l) {
        const std::uint64_t wanted = expected.layers[l].contour_count;
        contours_apart += std::max(wanted, contours[l]) - std::min(wanted, contours[l]);
        planes_apart += wanted != contours[l] ? 1U : 0U;
    }
    bench::print({{"planes", contours.size()},
                  {"engine_contours", expected.contours.size()},
                  {"planes_apart", planes_apart},
                  {"contours_apart", contours_apart},
                  {"build_s", build_s},
                  {"slice_s", slice_s},
                  {"total_s", total_s}});
}

/// main() of a peer's program. Exit status: 0 done, 75 over the time limit, 1 failed.
inline int run_peer(Run run, int count, char** words) noexcept {
    return bench::run_program(count, words, "MESH LAYER_MM THREADS LIMIT_S",
                              [run](const bench::Words& given) { time_peer(run, given); });
}

using bench::seconds_since;

}  // namespace lamella::peers
