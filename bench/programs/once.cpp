// Reads a mesh file and slices it, in a process of its own. Prints as JSON the process's peak memory after the first slice
// and the quantities of its bound, the pages that the first slice touched first, its time beside the medians of later ones,
// with Slicer and result used again ("warm_ms") and without either ("fresh_ms"; freeing the result is not timed), and how
// fast this machine gives pages of 4 KB.
//
// RULE is `contours`; or `ready`, the same after Slicer::make_ready(); or `united`, which is what Python does by default.
#include <sys/mman.h>

#include <cstring>
#include <fstream>

#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "timing.hpp"

namespace {

using namespace lamella;         // NOLINT(google-build-using-namespace)
using namespace lamella::bench;  // NOLINT(google-build-using-namespace)

constexpr int rounds = 9;
constexpr std::uint64_t page = 4096;
constexpr std::uint64_t huge_page = std::uint64_t{1} << 21;

/// Pages that the process has touched first.
struct Pages {
    std::uint64_t faults;
    std::uint64_t huge;  ///< that it holds

    static Pages now() {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        std::ifstream rollup("/proc/self/smaps_rollup");
        std::uint64_t kilobytes = 0;
        for (std::string name; rollup >> name;) {
            if (name == "AnonHugePages:") {
                rollup >> kilobytes;
            }
        }
        return {static_cast<std::uint64_t>(usage.ru_minflt), 1024 * kilobytes / huge_page};
    }
};

double fresh_bytes_per_second() {
    constexpr std::size_t bytes = std::size_t{1} << 25;
    void* const fresh = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (fresh == MAP_FAILED) {
        fail("no memory for pages of 4 KB");
    }
    madvise(fresh, bytes, MADV_NOHUGEPAGE);
    const double seconds = seconds_of([&] { std::memset(fresh, 1, bytes); });
    munmap(fresh, bytes);
    return static_cast<double>(bytes) / seconds;
}

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
    if (words[5] == "ready" && !slicer.make_ready(mesh.triangle_count, context)) {
        fail("no scratch was made ready");
    }
    const Pages before = Pages::now();
    const double first_ms = ms_of(slice_once);
    const Pages after = Pages::now();
    const std::uint64_t peak = peak_bytes();
    const std::uint64_t huge = after.huge - before.huge;
    const std::uint64_t small = after.faults - before.faults - huge;
    const std::uint64_t scratch = slicer.bytes();
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
           {"scratch_bytes", scratch},
           {"small_faults", small},
           {"touched_bytes", small * page + huge * huge_page},
           {"fresh_bytes/s", fresh_bytes_per_second()},
           {"hash", result.hash()}});
}

}  // namespace

int main(int count, char** words) {
    return run_program(count, words, "NAME MESH LAYER_HEIGHT_MM THREADS BAND_PLANES RULE", run);
}
