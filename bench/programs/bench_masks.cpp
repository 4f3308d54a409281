// Times label masks of one mesh: 512 x 512 x 275 voxels, as wide and high as its box. The contours are there before the
// clock starts.
//
//     raster     contours to voxels in memory, slice by slice into one buffer a thread; nothing is written
//     nii, nrrd  write_mask(): the same, written to a file; NRRD with gzip
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/medical.hpp"
#include "measure.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella::bench {

namespace {

constexpr std::array<std::uint64_t, 3> size = {512, 512, 275};
constexpr std::size_t voxels = std::size_t{512} * 512 * 275;

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

/// A mesh sliced at the slices of an image.
class Masked {
public:
    explicit Masked(const std::filesystem::path& file) : folder_(file.parent_path()) {
        const MeshFile mesh = checked(read_mesh(file));
        image_ = image_around(checked(Slicer().outline(mesh)).box);
        SliceOptions options;
        options.heights_mm = image_.slice_heights_mm();
        options.frame.transform = image_.slicing_frame(PatientFrame::lps);
        result_ = checked(slice(mesh, options));
        check();
    }

    /// Every slice into one buffer a thread.
    void draw(int threads) const {
        struct Worker {
            SliceRaster::Scratch scratch;
            MaskCounts counts = MaskCounts(1);
            std::vector<unsigned char> slice;
        };
        const MaskOptions options;
        const MaskLayout layout = layout_of("mask.nii", {&part_, 1}, false);
        const SliceRaster raster({&part_, 1}, image_, options, layout);
        std::vector<Worker> workers(static_cast<std::size_t>(threads));
        Parallel({.threads = threads}).run(size[2], [&](std::size_t k, int worker) {
            Worker& own = workers[static_cast<std::size_t>(worker)];
            own.slice.resize(raster.slice_bytes());
            raster.draw(k, own.slice.data(), own.scratch, own.counts);
        });
    }
    auto write(const char* name, int threads) const {
        return checked(write_mask({&part_, 1}, image_, folder_ / name, {}, {.threads = threads}));
    }

private:
    /// The mask that is written must have as many voxels as its summary says.
    void check() const {
        const std::uint64_t expected = write("mask.nii", 1).voxels[0];
        std::ifstream file(folder_ / "mask.nii", std::ios::binary);
        file.seekg(352);  // the header
        const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
        const auto found = static_cast<std::uint64_t>(std::count(bytes.begin(), bytes.end(), '\1'));
        if (bytes.size() != voxels || found != expected || found == 0) {
            fail("the mask holds " + std::to_string(found) + " voxels, its summary " + std::to_string(expected));
        }
    }

    std::filesystem::path folder_;
    ImageGeometry image_;
    SliceResult result_;
    MaskPart part_{&result_, "bone"};
};

}  // namespace

void add_masks(const Options& options) {
    const auto add = [&](const char* way, auto work) {
        for (const int threads : {1, 2}) {
            add_benchmark(options, std::string("mask/bone/") + way, threads, [=](benchmark::State& state) {
                const models::Recipe recipe{.triangles = std::uint64_t{options.quick ? 40'000U : 4'000'000U}};
                static const Masked masked(cached_mesh(options, "mask_bone", recipe));
                Figures figures = measure(state, [&] { work(masked, threads); });
                figures["voxels/s"] = rate_of(voxels, figures);
                return figures;
            });
        }
    };
    add("raster", [](const Masked& masked, int threads) { masked.draw(threads); });
    add("nii", [](const Masked& masked, int threads) { (void)masked.write("mask.nii", threads); });
    add("nrrd", [](const Masked& masked, int threads) { (void)masked.write("mask.nrrd", threads); });
}

}  // namespace lamella::bench
