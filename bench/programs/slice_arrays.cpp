// Slices arrays as scripts/python.py has them, in C++, for comparison with the same call in Python.
//
//     lamella_slice_arrays VERTICES FACES THREADS
//
// VERTICES holds three float32 a vertex, FACES three uint32 a triangle. For each line `LAYER_MM CALLS` of standard input the
// program slices so often, after one call that only warms, and prints the median in ms as a line of JSON: `kept` with
// workspace and result reused, `fresh` with neither. The two take turns. Between two lines it waits, so that what is compared
// takes turns too.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
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

nlohmann::json sliced(const MeshView& mesh, const SliceOptions& options, int calls, Workspace& workspace, SliceResult& result) {
    const auto kept = [&] {
        if (const Status done = slice(mesh, options, workspace, result); !done) {
            throw std::runtime_error(done.error().message);
        }
    };
    nlohmann::json report = medians_of({{"kept", kept}, {"fresh", [&] { checked(slice(mesh, options)); }}}, calls);
    report["layers"] = result.layers.size();
    report["points"] = result.points.size();
    report["hash"] = hash_result(result);
    return report;
}

void run(const std::string& vertices, const std::string& faces, int threads) {
    const auto xyz = numbers_of<float>(vertices);
    const auto indices = numbers_of<std::uint32_t>(faces);
    const MeshView mesh = MeshView::indexed(xyz, indices);
    SliceOptions options;
    options.control.threads = threads;
    Workspace workspace;
    SliceResult result;
    double layer_mm = 0;
    int calls = 0;
    while (std::cin >> layer_mm >> calls) {
        options.plan = {UniformLayers{.layer_height_mm = layer_mm}};
        std::cout << sliced(mesh, options, calls, workspace, result) << std::endl;
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
