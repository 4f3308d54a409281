// Slices one mesh file once. Prints the process's peak memory and the quantities of its bound as JSON.
//
//     lamella_peak NAME MESH LAYER_HEIGHT_MM THREADS BAND_PLANES
#include <filesystem>

#include "lamella/io.hpp"
#include "slicing/tuning.hpp"
#include "timing.hpp"

namespace {

using namespace lamella;  // NOLINT(google-build-using-namespace)

nlohmann::ordered_json run(const std::vector<std::string>& words) {
    const Context context{.threads = std::stoi(words[3])};
    const Tuning tuning{.band_planes = std::stoll(words[4])};
    const MeshFile mesh = bench::checked(read_mesh(words[1], {}, context));
    Slicer slicer;
    SliceResult result;
    const SliceOptions options{.layer_height_mm = std::stod(words[2])};
    const SliceInfo info = bench::checked(slice_tuned(slicer, result, mesh, options, tuning, context));
    return {{"name", words[0]},
            {"mesh", std::filesystem::path(words[1]).filename().string()},
            {"threads", context.threads},
            {"band_planes", tuning.band_planes},
            {"bands", info.bands},
            {"peak_bytes", bench::peak_bytes()},
            {"input_bytes", mesh.bytes.size()},
            {"crossed", info.crossed},
            {"result_bytes", info.layers * sizeof(Layer) + info.contours * sizeof(Contour) + info.points * sizeof(Point)}};
}

}  // namespace

int main(int count, char** words) {
    return bench::run_program(count, words, 5, 5, "NAME MESH LAYER_HEIGHT_MM THREADS BAND_PLANES", run);
}
