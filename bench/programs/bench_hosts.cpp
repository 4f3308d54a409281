// Times the calls that hosts make beside whole slices, for scripts/hosts.py: single planes of a prepared mesh, all planes of
// it, small meshes with a kept Slicer, and the first slice of a process.
//
//     lamella_hosts first MESH LAYER_MM THREADS             first slice, and the median of later ones
//     lamella_hosts prepared MESH LAYER_MM THREADS ROUNDS   prepare(), one plane a call, all planes
//     lamella_hosts small THREADS                           12 triangles and one plane
#include <algorithm>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "timing.hpp"

namespace {

std::size_t allocations = 0;

/// Not inlined: GCC 12 would warn that what operator new gave goes to free(), in spite of the operators below.
[[gnu::noinline]] void give(void* block) noexcept {
    std::free(block);
}

}  // namespace

// Counted, as a call of a kept Slicer must take no memory. One thread takes any at a time where that is checked.
void* operator new(std::size_t bytes) {
    ++allocations;
    void* const block = std::malloc(bytes);
    if (block == nullptr) {
        throw std::bad_alloc();
    }
    return block;
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    ++allocations;
    const auto step = static_cast<std::size_t>(alignment);
    void* const block = std::aligned_alloc(step, (bytes + step - 1) / step * step);
    if (block == nullptr) {
        throw std::bad_alloc();
    }
    return block;
}
void operator delete(void* block) noexcept {
    give(block);
}
void operator delete(void* block, std::size_t) noexcept {
    give(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
    give(block);
}

namespace lamella::bench {

namespace {

SliceOptions at_height(double mm) {
    return {.heights_mm = std::vector<double>{mm}};
}

nlohmann::json time_first(const MeshView& mesh, const SliceOptions& options, const Context& context) {
    constexpr int later = 9;
    Slicer slicer;
    SliceResult result;
    const auto once = [&] { checked(slicer.slice_to(result, mesh, options, context)); };
    const double first = ms_of(once);
    return {{"first", first}, {"warm", medians_of({{"warm", once}}, later)["warm"]}};
}

/// A mesh and what was prepared of it, sliced in turn.
class SideBySide {
public:
    SideBySide(const MeshView& mesh, const Context& context)
        : mesh_(mesh), context_(context), prepared_(checked(prepare(mesh, {}, context))) {}

    nlohmann::ordered_json medians(const SliceOptions& options, int rounds) {
        const nlohmann::ordered_json times =
            medians_of({{"prepared", [&] { checked(of_prepared_.slice_to(found_, prepared_, options, context_)); }},
                        {"mesh", [&] { checked(of_mesh_.slice_to(expected_, mesh_, options, context_)); }}},
                       rounds);
        if (found_.hash() != expected_.hash()) {
            fail("the prepared mesh gives another result");
        }
        return times;
    }
    const SliceResult& result() const noexcept { return expected_; }
    std::size_t bytes() const noexcept { return prepared_.bytes(); }

private:
    MeshView mesh_;
    Context context_;
    PreparedMesh prepared_;
    Slicer of_prepared_;
    Slicer of_mesh_;
    SliceResult found_;
    SliceResult expected_;
};

/// All planes, and one plane a call at nineteen heights, of which the slowest counts.
nlohmann::json time_prepared(const MeshView& mesh, const SliceOptions& all, const Context& context, int rounds) {
    SideBySide both(mesh, context);
    nlohmann::json report = medians_of({{"prepare", [&] { checked(prepare(mesh, {}, context)); }}}, rounds);
    report["all"] = both.medians(all, rounds);
    report["planes"] = both.result().layers.size();
    report["bytes"] = both.bytes();
    const double low = both.result().info.box.min_mm[2];
    const double high = both.result().info.box.max_mm[2];
    double slowest[2] = {0, 0};
    for (int i = 1; i < 20; ++i) {
        const nlohmann::ordered_json times = both.medians(at_height(low + (high - low) * i / 20), rounds);
        slowest[0] = std::max(slowest[0], times["prepared"].get<double>());
        slowest[1] = std::max(slowest[1], times["mesh"].get<double>());
    }
    report["plane"] = {{"prepared", slowest[0]}, {"mesh", slowest[1]}};
    return report;
}

/// A box. Times in microseconds.
nlohmann::json time_small(int threads) {
    const std::vector<float> corners = {0, 0, 0, 9, 0, 0, 9, 9, 0, 0, 9, 0, 0, 0, 9, 9, 0, 9, 9, 9, 9, 0, 9, 9};
    const std::vector<std::uint32_t> faces = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                              1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    const MeshView box = MeshView::indexed(corners, faces);
    const SliceOptions options = at_height(4.5);
    const Context context{.threads = threads};
    constexpr int calls = 1000;
    Slicer slicer;
    SliceResult result;
    std::size_t taken = 0;
    const auto slice_kept = [&] {
        const std::size_t before = allocations;
        for (int call = 0; call < calls; ++call) {
            checked(slicer.slice_to(result, box, options, context));
        }
        taken = allocations - before;
    };
    const auto slice_fresh = [&] {
        for (int call = 0; call < calls / 10; ++call) {
            checked(slice(box, options, context));
        }
    };
    const nlohmann::ordered_json ms = medians_of({{"kept", slice_kept}, {"fresh", slice_fresh}}, 101);
    return {{"kept_us", ms["kept"]}, {"fresh_us", 10 * ms["fresh"].get<double>()}, {"allocations", taken}};
}

constexpr const char* usage = "first MESH LAYER_MM THREADS | prepared MESH LAYER_MM THREADS ROUNDS | small THREADS";

nlohmann::json run(const std::vector<std::string>& words) {
    if (words.size() == 2 && words[0] == "small") {
        return time_small(std::stoi(words[1]));
    }
    if (words.size() < 4) {
        fail(usage);
    }
    // Read by this thread alone: no other one has started before the first slice.
    const MeshFile file = checked(read_mesh(words[1], {}, {.threads = 1}));
    const MeshView mesh = file.view();
    const SliceOptions options{.layer_height_mm = std::stod(words[2])};
    const Context context{.threads = std::stoi(words[3])};
    return words[0] == "first" ? time_first(mesh, options, context)
                               : time_prepared(mesh, options, context, std::stoi(words.at(4)));
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, 2, 5, lamella::bench::usage, lamella::bench::run);
}
