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
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "lamella/medical.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella::bench {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::array<std::uint64_t, 3> size = {512, 512, 275};
constexpr double voxels = 512.0 * 512 * 275;

[[noreturn]] void stop(const std::string& why) {
    throw std::runtime_error(why);
}

template <class T>
T value_of(Result<T> result) {
    if (!result) {
        stop(result.error().message);
    }
    return std::move(result).value();
}

/// Around the box, a thousandth of a voxel wider.
ImageGeometry image_around(const SliceSummary& box) {
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
        const Clock::time_point begin = Clock::now();
        call();
        wall_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
        processor_ms.push_back(bench::processor_ms() - before);
    }
    static double median(std::vector<double> all) {
        std::sort(all.begin(), all.end());
        return all[all.size() / 2];
    }
    nlohmann::json json() const {
        const double wall = median(wall_ms);
        return {{"wall_ms", wall},
                {"least_wall_ms", *std::min_element(wall_ms.begin(), wall_ms.end())},
                {"processor_ms", median(processor_ms)},
                {"voxels_per_s", voxels / (1e-3 * wall)}};
    }
};

/// Every slice into one buffer a thread.
void draw_all(const SliceRaster& raster, int threads) {
    std::atomic<std::uint64_t> next = 0;
    std::vector<std::thread> workers;
    workers.reserve(static_cast<std::size_t>(threads));
    for (int i = 0; i < threads; ++i) {
        workers.emplace_back([&] {
            SliceRaster::Scratch scratch;
            MaskCounts counts(1);
            std::vector<unsigned char> slice(raster.slice_bytes());
            for (std::uint64_t k = next++; k < size[2]; k = next++) {
                raster.draw(k, slice.data(), scratch, counts);
            }
        });
    }
    for (std::thread& worker : workers) {
        worker.join();
    }
}

void require_right(const std::filesystem::path& path, std::uint64_t expected) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    constexpr std::size_t header_bytes = 352;
    if (bytes.size() != header_bytes + static_cast<std::size_t>(voxels)) {
        stop("the mask has " + std::to_string(bytes.size()) + " bytes");
    }
    const auto found = static_cast<std::uint64_t>(std::count(bytes.begin() + header_bytes, bytes.end(), '\1'));
    if (found != expected || found == 0) {
        stop("the mask holds " + std::to_string(found) + " voxels, its summary " + std::to_string(expected));
    }
}

nlohmann::json run(int count, char** words) {
    if (count < 4) {
        stop("usage: lamella_masks MESH.stl THREADS FOLDER [ROUNDS]");
    }
    const int threads = std::atoi(words[2]);
    const std::filesystem::path folder = words[3];
    const int rounds = count > 4 ? std::atoi(words[4]) : 15;
    const MeshFile mesh = value_of(read_mesh(words[1]));
    SliceOptions options;
    options.plan.spacing = ExplicitPlanes{{0}};
    const ImageGeometry image = image_around(value_of(slice(mesh, options)).summary);
    options.plan.spacing = ExplicitPlanes{image.slice_heights_mm()};
    options.transform = image.slicing_frame(PatientFrame::lps);
    const SliceResult result = value_of(slice(mesh, options));
    const MaskPart part{&result, "bone"};
    const MaskOptions mask_options{.control = {.threads = threads}};
    const MaskLayout layout = layout_of("mask.nii", {&part, 1}, false);
    const SliceRaster raster({&part, 1}, image, mask_options, layout);
    const auto write = [&](const char* name) {
        return value_of(write_mask({&part, 1}, image, folder / name, mask_options));
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
    try {
        std::puts(lamella::bench::run(count, words).dump(2).c_str());
        return EXIT_SUCCESS;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return EXIT_FAILURE;
    }
}
