// Reads a mesh file and slices it, in a process of its own. Prints the process's peak memory after the first slice, the
// quantities of its bound, and the time of the first slice beside the median of later ones as JSON.
#include "lamella/io.hpp"
#include "slicing/tuning.hpp"
#include "timing.hpp"

namespace {

using namespace lamella;         // NOLINT(google-build-using-namespace)
using namespace lamella::bench;  // NOLINT(google-build-using-namespace)

void run(const Words& words) {
    const Context context{.threads = std::stoi(words[3])};
    const Tuning tuning{.band_planes = std::stoll(words[4])};
    // Read by this thread alone: no other one has started before the first slice.
    const MeshFile mesh = checked(read_mesh(words[1], {}, {.threads = 1}));
    const SliceOptions options{.layer_height_mm = std::stod(words[2])};
    Slicer slicer;
    SliceResult result;
    const auto slice_once = [&] { checked(slice_tuned(slicer, result, mesh, options, tuning, context)); };
    const double first_ms = ms_of(slice_once);
    const std::uint64_t peak = peak_bytes();
    const SliceInfo& info = result.info;
    print({{"name", words[0]},
           {"threads", context.threads},
           {"band_planes", tuning.band_planes},
           {"real_time", first_ms},
           {"warm_ms", medians_of({{"warm", slice_once}}, 9)["warm"]},
           {"peak_bytes", peak},
           {"input_bytes", mesh.bytes.size()},
           {"crossed", info.crossed},
           {"result_bytes", info.layers * sizeof(Layer) + info.contours * sizeof(Contour) + info.points * sizeof(Point)}});
}

}  // namespace

int main(int count, char** words) {
    return run_program(count, words, "NAME MESH LAYER_HEIGHT_MM THREADS BAND_PLANES", run);
}
