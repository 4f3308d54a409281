// Reads a mesh file and slices it, in a process of its own. Prints the process's peak memory after the first slice, the
// quantities of its bound, and the time of the first slice beside the medians of later ones as JSON: with Slicer and result
// used again ("warm_ms"), and without either ("fresh_ms"; freeing the result is not timed).
//
// RULE is `contours`, or `united`, which is what Python does by default.
#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "timing.hpp"

namespace {

using namespace lamella;         // NOLINT(google-build-using-namespace)
using namespace lamella::bench;  // NOLINT(google-build-using-namespace)

constexpr int rounds = 9;

void run(const Words& words) {
    const Context context{.threads = std::stoi(words[3])};
    const Tuning tuning{.band_planes = std::stoll(words[4])};
    // Read by this thread alone: no other one has started before the first slice.
    const MeshFile mesh = checked(read_mesh(words[1], {}, {.threads = 1}));
    SliceOptions options{.layer_height_mm = std::stod(words[2])};
    if (words[5] == "united") {
        options.region.fill_rule = FillRule::non_zero;
        options.stitch_mm = stitch_by_mesh;
    }
    Slicer slicer;
    SliceResult result;
    const auto slice_once = [&] { checked(slice_tuned(slicer, result, mesh, options, tuning, context)); };
    const double first_ms = ms_of(slice_once);
    const std::uint64_t peak = peak_bytes();
    const double warm_ms = medians_of({{"warm", slice_once}}, rounds)["warm"];
    std::vector<double> fresh_ms;
    for (int round = 0; round < rounds; ++round) {
        SliceResult own;
        fresh_ms.push_back(ms_of([&] { own = checked(slice(mesh, options, context)); }));
    }
    print({{"name", words[0]},
           {"real_time", first_ms},
           {"warm_ms", warm_ms},
           {"fresh_ms", median_of(std::move(fresh_ms))},
           {"peak_bytes", peak},
           {"input_bytes", mesh.bytes.size()},
           {"crossed", result.info.crossed},
           {"result_bytes", result_bytes(result.info)},
           {"hash", result.hash()}});
}

}  // namespace

int main(int count, char** words) {
    return run_program(count, words, "NAME MESH LAYER_HEIGHT_MM THREADS BAND_PLANES RULE", run);
}
