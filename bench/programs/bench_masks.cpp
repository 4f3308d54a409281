// Times label masks of one mesh: lamella_masks MESH.stl THREADS FOLDER [ROUNDS]. Prints JSON.
//
// The image has 512 x 512 x 275 voxels around the mesh, as wide and high as its box; the contours are there before the clock
// starts. Each way is timed in every round, and the median is printed, of wall time and of processor time:
//
//     raster     contours to voxels in memory, slice by slice into one buffer a thread; nothing is written
//     nii, nrrd  write_mask(): the same, written to a file in FOLDER; NRRD with gzip
//
// Before that the mask is read back and its voxels are counted: the sum must be that of the summary.
#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "lamella/medical.hpp"
#include "medical/mask/slice_raster.hpp"
#include "timing.hpp"

namespace lamella::bench {

namespace {

constexpr std::array<std::uint64_t, 3> size = {512, 512, 275};
constexpr double voxels = 512.0 * 512 * 275;

/// Around the box, a thousandth of a voxel wider.
ImageGeometry image_around(const Box& box) {
    ImageGeometry image;
    image.size = size;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        image.spacing_mm[axis] = (box.max_mm[axis] - box.min_mm[axis]) / (static_cast<double>(size[axis]) - 0.001);
        image.origin_mm[axis] = box.min_mm[axis] + 0.5 * image.spacing_mm[axis];
    }
    return image;
}

double processor_ms() {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Times {
    std::vector<double> wall_ms;
    std::vector<double> processor_ms;

    void add(const std::function<void()>& call) {
        const double before = bench::processor_ms();
        wall_ms.push_back(ms_of(call));
        processor_ms.push_back(bench::processor_ms() - before);
    }
    nlohmann::json json() const {
        const double wall = median_of(wall_ms);
        return {{"wall_ms", wall},
                {"least_wall_ms", *std::min_element(wall_ms.begin(), wall_ms.end())},
                {"processor_ms", median_of(processor_ms)},
                {"voxels_per_s", voxels / (1e-3 * wall)}};
    }
};

/// Every slice into one buffer a thread.
void draw_all(const SliceRaster& raster, int threads) {
    struct Worker {
        SliceRaster::Scratch scratch;
        MaskCounts counts = MaskCounts(1);
        std::vector<unsigned char> slice;
    };
    std::vector<Worker> workers(static_cast<std::size_t>(threads));
    share_out(size[2], threads, [&](std::size_t worker, std::size_t k) {
        Worker& own = workers[worker];
        own.slice.resize(raster.slice_bytes());
        raster.draw(k, own.slice.data(), own.scratch, own.counts);
    });
}

void require_right(const std::filesystem::path& path, std::uint64_t expected) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    constexpr std::size_t header_bytes = 352;
    if (bytes.size() != header_bytes + static_cast<std::size_t>(voxels)) {
        fail("the mask has " + std::to_string(bytes.size()) + " bytes");
    }
    const auto found = static_cast<std::uint64_t>(std::count(bytes.begin() + header_bytes, bytes.end(), '\1'));
    if (found != expected || found == 0) {
        fail("the mask holds " + std::to_string(found) + " voxels, its summary " + std::to_string(expected));
    }
}

nlohmann::json run(const std::vector<std::string>& words) {
    const int threads = std::stoi(words[1]);
    const std::filesystem::path folder = words[2];
    const int rounds = words.size() > 3 ? std::stoi(words[3]) : 15;
    const MeshFile mesh = checked(read_mesh(words[0]));
    const ImageGeometry image = image_around(checked(Slicer().outline(mesh)).box);
    SliceOptions options;
    options.heights_mm = image.slice_heights_mm();
    options.frame.transform = image.slicing_frame(PatientFrame::lps);
    const SliceResult result = checked(slice(mesh, options));
    const MaskPart part{&result, "bone"};
    const MaskOptions mask_options;
    const MaskLayout layout = layout_of("mask.nii", {&part, 1}, false);
    const SliceRaster raster({&part, 1}, image, mask_options, layout);
    const auto write = [&](const char* name) {
        return checked(write_mask({&part, 1}, image, folder / name, mask_options, {.threads = threads}));
    };
    require_right(folder / "mask.nii", write("mask.nii").voxels[0]);
    Times in_memory;
    Times nii;
    Times nrrd;
    for (int round = 0; round < rounds; ++round) {
        in_memory.add([&] { draw_all(raster, threads); });
        nii.add([&] { (void)write("mask.nii"); });
        nrrd.add([&] { (void)write("mask.nrrd"); });
    }
    return {{"triangles", mesh.view().triangle_count},
            {"points", result.points.size()},
            {"threads", threads},
            {"raster", in_memory.json()},
            {"nii", nii.json()},
            {"nrrd", nrrd.json()}};
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, 3, 4, "MESH.stl THREADS FOLDER [ROUNDS]", lamella::bench::run);
}
