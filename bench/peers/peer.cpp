#include "peer.hpp"

#include <functional>
#include <utility>

#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"

namespace lamella::peers {

namespace {

void time_peer(Run run, const bench::Words& words) {
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

}  // namespace

int run_peer(Run run, int count, char** words) noexcept {
    return bench::run_program(count, words, "MESH LAYER_MM THREADS LIMIT_S",
                              [run](const bench::Words& given) { time_peer(run, given); });
}

}  // namespace lamella::peers
