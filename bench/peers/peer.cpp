#include "peer.hpp"

#include <exception>
#include <fstream>
#include <iostream>
#include <numeric>
#include <utility>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "mesh.hpp"

namespace lamella::peers {

namespace {

struct Request {
    std::string mesh;
    double layer_height_mm = 0.032;
    std::string planes;  ///< file of heights in mm; empty: uniform layers
    int threads = 1;
    unsigned limit_s = 0;
};

SliceOptions options_of(const Request& request) {
    if (request.planes.empty()) {
        return {.layer_height_mm = request.layer_height_mm};
    }
    std::ifstream file(request.planes);
    std::vector<double> heights_mm;
    for (double height_mm = 0; file >> height_mm;) {
        heights_mm.push_back(height_mm);
    }
    if (!file.eof()) {
        bench::fail(request.planes + ": not a list of heights in mm");
    }
    return {.heights_mm = std::move(heights_mm)};
}

/// The number of planes whose number of contours differs from the engine's, and the sum of these differences.
std::pair<std::uint64_t, std::uint64_t> difference(const SliceResult& expected, const Found& found) {
    std::uint64_t planes = 0;
    std::uint64_t contours = 0;
    for (std::size_t l = 0; l < expected.layers.size(); ++l) {
        const std::uint64_t wanted = expected.layers[l].contour_count;
        const std::uint64_t apart = wanted < found.contours[l] ? found.contours[l] - wanted : wanted - found.contours[l];
        planes += apart != 0 ? 1 : 0;
        contours += apart;
    }
    return {planes, contours};
}

nlohmann::ordered_json to_json(const Peer& peer, const Problem& problem, const SliceResult& expected, const Found& found,
                               const std::vector<Times>& runs) {
    std::vector<double> total_s;
    for (const Times& times : runs) {
        total_s.push_back(times.sum());
    }
    const auto [planes_apart, contours_apart] = difference(expected, found);
    return {{"peer", peer.name},
            {"version", peer.version},
            {"way", peer.way},
            {"threads", problem.threads},
            {"triangles", problem.triangles()},
            {"planes", problem.planes_mm.size()},
            {"contours", std::accumulate(found.contours.begin(), found.contours.end(), std::uint64_t{0})},
            {"segments", found.segments},
            {"engine_contours", expected.contours.size()},
            {"engine_segments", expected.info.segments},
            {"planes_apart", planes_apart},
            {"contours_apart", contours_apart},
            {"build_s", bench::values_of(runs, &Times::build_s)},
            {"slice_s", bench::values_of(runs, &Times::slice_s)},
            {"total_s", total_s},
            {"peak_bytes", bench::peak_bytes()}};
}

void run(const Peer& peer, const Request& request) {
    const auto start = Clock::now();
    const bench::Mesh mesh = bench::load_mesh(request.mesh);
    const double load_s = bench::seconds_since(start);
    const SliceResult expected = bench::checked(slice(mesh.view(), options_of(request)));
    Problem problem{mesh.soup.span(), {}, request.threads};
    for (const Layer& layer : expected.layers) {
        problem.planes_mm.push_back(layer.plane.z() * expected.info.grid_mm);
    }
    bench::end_after(request.limit_s);
    Found found;
    const std::vector<Times> runs = bench::repeated([&] {
        found = {};
        return peer.run(problem, found);
    });
    bench::end_after(0);
    nlohmann::ordered_json row = to_json(peer, problem, expected, found, runs);
    row["load_s"] = load_s;
    std::cout << row.dump() << '\n';
}

}  // namespace

int run_program(const Peer& peer, int count, char** words) noexcept try {
    CLI::App app("Slices a mesh by " + peer.name + ", compares the answer with the engine's and prints the times as JSON");
    Request request;
    app.add_option("--mesh", request.mesh, "file to slice")->required();
    auto* const height = app.add_option("--layer-height", request.layer_height_mm, "mm");
    app.add_option("--planes", request.planes, "file of heights in mm, ascending")->excludes(height);
    app.add_option("--threads", request.threads)->check(CLI::Range(1, 1024));
    app.add_option("--limit", request.limit_s, "seconds for all runs together; 0: none");
    CLI11_PARSE(app, count, words);
    run(peer, request);
    return 0;
} catch (const std::exception& failure) {
    std::cerr << peer.name << ": " << failure.what() << '\n';
    return 1;
}

}  // namespace lamella::peers
