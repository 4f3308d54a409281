// Times the calls that hosts make beside whole slices, for scripts/hosts.py: single planes of a prepared mesh, all planes of
// it, small meshes with a kept workspace, and the first slice of a process.
//
// MESH is a binary STL file.
//
//     lamella_hosts first MESH LAYER_MM THREADS             first slice, and the median of later ones
//     lamella_hosts prepared MESH LAYER_MM THREADS ROUNDS   prepare(), one plane a call, all planes
//     lamella_hosts small THREADS                           12 triangles and one plane
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "lamella/lamella.hpp"
#include "medians.hpp"
#include "timed_runs.hpp"

namespace {

std::size_t allocations = 0;

/// Not inlined: GCC 12 would warn that what operator new gave goes to free(), in spite of the operators below.
[[gnu::noinline]] void give(void* block) noexcept {
    std::free(block);
}

}  // namespace

// Counted, as a call with a kept workspace must take no memory. One thread takes any at a time where that is checked.
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

void require(const Status& status) {
    if (!status) {
        throw std::runtime_error(status.error().message);
    }
}

/// Read by this thread alone: no other one has started before the first slice.
std::vector<char> bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

MeshView binary_stl(const std::vector<char>& file) {
    constexpr std::size_t head = 84;
    constexpr std::size_t facet = 50;
    if (file.size() <= head || (file.size() - head) % facet != 0) {
        throw std::runtime_error("not a binary STL file");
    }
    const auto* first = reinterpret_cast<const std::byte*>(file.data()) + head + 3 * sizeof(float);
    return MeshView::strided_soup(first, (file.size() - head) / facet, facet, CoordinateType::f32);
}

SliceOptions options_for(const LayerPlan& plan, int threads) {
    SliceOptions options;
    options.plan = plan;
    options.control.threads = threads;
    return options;
}

nlohmann::json time_first(const MeshView& mesh, const SliceOptions& options) {
    constexpr int later = 9;
    Workspace workspace;
    SliceResult result;
    const auto once = [&] { require(slice(mesh, options, workspace, result)); };
    const double first = ms_of(once);
    return {{"first", first}, {"warm", medians_of({{"warm", once}}, later)["warm"]}};
}

/// A mesh and what was prepared of it, sliced in turn.
class SideBySide {
public:
    SideBySide(const MeshView& mesh, const Control& control)
        : mesh_(mesh), prepared_(checked(prepare(mesh, {.control = control}))) {}

    nlohmann::ordered_json medians(const SliceOptions& options, int rounds) {
        const nlohmann::ordered_json times =
            medians_of({{"prepared", [&] { require(slice(prepared_, options, of_prepared_, found_)); }},
                        {"mesh", [&] { require(slice(mesh_, options, of_mesh_, expected_)); }}},
                       rounds);
        if (hash_result(found_) != hash_result(expected_)) {
            throw std::runtime_error("the prepared mesh gives another result");
        }
        return times;
    }
    const SliceResult& result() const noexcept { return expected_; }
    std::size_t bytes() const noexcept { return prepared_.bytes(); }

private:
    MeshView mesh_;
    PreparedMesh prepared_;
    Workspace of_prepared_;
    Workspace of_mesh_;
    SliceResult found_;
    SliceResult expected_;
};

/// All planes, and one plane a call at nineteen heights, of which the slowest counts.
nlohmann::json time_prepared(const MeshView& mesh, const SliceOptions& all, int rounds) {
    SideBySide both(mesh, all.control);
    nlohmann::json report = medians_of({{"prepare", [&] { checked(prepare(mesh, {.control = all.control})); }}}, rounds);
    report["all"] = both.medians(all, rounds);
    report["planes"] = both.result().layers.size();
    report["bytes"] = both.bytes();
    const double low = both.result().summary.min_mm[2];
    const double high = both.result().summary.max_mm[2];
    double slowest[2] = {0, 0};
    for (int i = 1; i < 20; ++i) {
        const SliceOptions one = options_for({ExplicitPlanes{{low + (high - low) * i / 20}}}, all.control.threads);
        const nlohmann::ordered_json times = both.medians(one, rounds);
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
    const SliceOptions options = options_for({ExplicitPlanes{{4.5}}}, threads);
    constexpr int calls = 1000;
    constexpr int rounds = 101;
    Workspace workspace;
    SliceResult result;
    std::vector<double> kept;
    std::vector<double> fresh;
    std::size_t taken = 0;
    for (int round = 0; round < rounds; ++round) {
        const std::size_t before = allocations;
        kept.push_back(ms_of([&] {
            for (int call = 0; call < calls; ++call) {
                require(slice(box, options, workspace, result));
            }
        }));
        taken = allocations - before;
        fresh.push_back(ms_of([&] {
            for (int call = 0; call < calls / 10; ++call) {
                checked(slice(box, options));
            }
        }));
    }
    return {{"kept_us", median_of(kept)}, {"fresh_us", 10 * median_of(fresh)}, {"allocations", taken}};
}

nlohmann::json run(const std::vector<std::string>& words) {
    if (words.size() == 2 && words[0] == "small") {
        return time_small(std::stoi(words[1]));
    }
    if (words.size() < 4) {
        throw std::runtime_error(
            "usage: first MESH LAYER_MM THREADS | prepared MESH LAYER_MM THREADS ROUNDS | small THREADS");
    }
    const std::vector<char> file = bytes_of(words[1]);
    const MeshView mesh = binary_stl(file);
    const SliceOptions options = options_for({UniformLayers{.layer_height_mm = std::stod(words[2])}}, std::stoi(words[3]));
    return words[0] == "first" ? time_first(mesh, options) : time_prepared(mesh, options, std::stoi(words.at(4)));
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    try {
        std::puts(lamella::bench::run({words + 1, words + count}).dump().c_str());
        return EXIT_SUCCESS;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return EXIT_FAILURE;
    }
}
