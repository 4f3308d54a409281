// Slices arrays as scripts/python.py has them, in C++ and by what Python does by default, for comparison with the same call
// there.
//
//     lamella_slice_arrays VERTICES FACES THREADS
//
// VERTICES holds three float32 a vertex, FACES three uint32 a triangle. For each line `LAYER_MM CALLS HOW` of standard input
// the program slices so often, after one call that only warms, and prints a line of JSON with the time of each call in ms.
// HOW is `kept`, Slicer and result used again, or `fresh`, neither. Between two lines it waits, so that programs can take
// turns.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "lamella/lamella.hpp"
#include "timing.hpp"

namespace lamella::bench {

namespace {

template <class T>
std::vector<T> numbers_of(const std::string& path) {
    std::vector<T> numbers(static_cast<std::size_t>(std::filesystem::file_size(path)) / sizeof(T));
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(numbers.data()), static_cast<std::streamsize>(numbers.size() * sizeof(T)));
    if (!file) {
        fail("cannot read " + path);
    }
    return numbers;
}

/// The time of each call, and what tells that the result is another's. Freeing the result is not timed.
Json time_calls(const MeshView& mesh, const SliceOptions& options, const Context& context, int calls, bool kept) {
    Slicer slicer;
    SliceResult result;
    std::vector<double> times;
    for (int call = 0; call <= calls; ++call) {
        if (kept) {
            times.push_back(ms_of([&] { checked(slicer.slice_to(result, mesh, options, context)); }));
        } else {
            result = SliceResult{};
            times.push_back(ms_of([&] { result = checked(slice(mesh, options, context)); }));
        }
    }
    times.erase(times.begin());
    return {{"ms", times}, {"layers", result.layers.size()}, {"hash", result.hash()}};
}

void run(const Words& words) {
    const auto xyz = numbers_of<float>(words[0]);
    const auto indices = numbers_of<std::uint32_t>(words[1]);
    const MeshView mesh = MeshView::indexed(xyz, indices);
    SliceOptions options;
    options.region.fill_rule = FillRule::non_zero;
    options.stitch_mm = stitch_by_mesh;
    double layer_mm = 0;
    int calls = 0;
    std::string how;
    while (std::cin >> layer_mm >> calls >> how) {
        options.layer_height_mm = layer_mm;
        print(time_calls(mesh, options, {.threads = std::stoi(words[2])}, calls, how == "kept"));
    }
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, "VERTICES FACES THREADS", lamella::bench::run);
}
