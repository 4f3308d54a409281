// Slices arrays as scripts/python.py has them, in C++ and by what Python does by default, for comparison with the same call
// there.
//
//     lamella_slice_arrays VERTICES FACES THREADS
//
// VERTICES holds three float32 a vertex, FACES three uint32 a triangle. For each line `LAYER_MM CALLS HOW` of standard input
// the program slices so often, after one call that only warms, and prints a line of JSON with the time of each call in ms.
// HOW is `kept`, workspace and result reused, or `fresh`, neither. Between two lines it waits, so that programs can take
// turns.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "lamella/lamella.hpp"
#include "medians.hpp"
#include "timed_runs.hpp"

namespace lamella::bench {

namespace {

template <class T>
std::vector<T> numbers_of(const std::string& path) {
    std::vector<T> numbers(static_cast<std::size_t>(std::filesystem::file_size(path)) / sizeof(T));
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(numbers.data()), static_cast<std::streamsize>(numbers.size() * sizeof(T)));
    if (!file) {
        throw std::runtime_error("cannot read " + path);
    }
    return numbers;
}

void require(const Status& done) {
    if (!done) {
        throw std::runtime_error(done.error().message);
    }
}

/// The time of each call, and what tells that the result is another's.
nlohmann::json report_of(const SliceResult& result, std::vector<double> times) {
    times.erase(times.begin());
    return {{"ms", times}, {"layers", result.layers.size()}, {"hash", hash_result(result)}};
}

nlohmann::json slice_kept(const MeshView& mesh, const SliceOptions& options, int calls) {
    Workspace workspace;
    SliceResult result;
    std::vector<double> times;
    for (int call = 0; call <= calls; ++call) {
        times.push_back(ms_of([&] { require(slice(mesh, options, workspace, result)); }));
    }
    return report_of(result, std::move(times));
}

/// Freeing the result is not timed.
nlohmann::json slice_fresh(const MeshView& mesh, const SliceOptions& options, int calls) {
    SliceResult result;
    std::vector<double> times;
    for (int call = 0; call <= calls; ++call) {
        result = SliceResult{};
        times.push_back(ms_of([&] { result = checked(slice(mesh, options)); }));
    }
    return report_of(result, std::move(times));
}

void run(const std::string& vertices, const std::string& faces, int threads) {
    const auto xyz = numbers_of<float>(vertices);
    const auto indices = numbers_of<std::uint32_t>(faces);
    const MeshView mesh = MeshView::indexed(xyz, indices);
    SliceOptions options;
    options.control.threads = threads;
    options.region.fill_rule = FillRule::non_zero;
    options.close_gaps_mm = gaps_by_mesh;
    double layer_mm = 0;
    int calls = 0;
    std::string how;
    while (std::cin >> layer_mm >> calls >> how) {
        options.plan = {UniformLayers{.layer_height_mm = layer_mm}};
        std::cout << (how == "kept" ? slice_kept(mesh, options, calls) : slice_fresh(mesh, options, calls)) << std::endl;
    }
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    if (count != 4) {
        std::fputs("usage: lamella_slice_arrays VERTICES FACES THREADS\n", stderr);
        return 2;
    }
    try {
        lamella::bench::run(words[1], words[2], std::stoi(words[3]));
        return EXIT_SUCCESS;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return EXIT_FAILURE;
    }
}
