#include "peer.hpp"

#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <utility>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "mesh.hpp"
#include "timed_runs.hpp"

namespace lamella::peers {

namespace {

struct Request {
    std::string mesh;
    double layer_height_mm = 0.032;
    std::string planes;  ///< a file of heights in mm; empty: uniform layers
    int threads = 1;
    unsigned limit_s = 0;
};

LayerPlan plan_of(const Request& request) {
    if (request.planes.empty()) {
        return {.spacing = UniformLayers{.layer_height_mm = request.layer_height_mm}};
    }
    std::ifstream file(request.planes);
    ExplicitPlanes planes;
    for (double height_mm = 0; file >> height_mm;) {
        planes.heights_mm.push_back(height_mm);
    }
    if (!file.eof()) {
        throw std::runtime_error(request.planes + ": not a list of heights in mm");
    }
    return {.spacing = std::move(planes)};
}

/// Planes with another number of contours than the engine's, and by how many in all.
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
    std::vector<double> build_s;
    std::vector<double> slice_s;
    std::vector<double> total_s;
    for (const Times& times : runs) {
        build_s.push_back(times.build_s);
        slice_s.push_back(times.slice_s);
        total_s.push_back(times.sum());
    }
    std::uint64_t contours = 0;
    for (const std::uint64_t count : found.contours) {
        contours += count;
    }
    const auto [planes_apart, contours_apart] = difference(expected, found);
    return {{"peer", peer.name},
            {"version", peer.version},
            {"way", peer.way},
            {"threads", problem.threads},
            {"triangles", problem.triangles()},
            {"planes", problem.planes_mm.size()},
            {"contours", contours},
            {"segments", found.segments},
            {"engine_contours", expected.contours.size()},
            {"engine_segments", expected.summary.segments},
            {"planes_apart", planes_apart},
            {"contours_apart", contours_apart},
            {"build_s", build_s},
            {"slice_s", slice_s},
            {"total_s", total_s},
            {"peak_bytes", bench::peak_bytes()}};
}

void run(const Peer& peer, const Request& request) {
    const auto start = Clock::now();
    const bench::Mesh mesh = bench::checked(bench::load_mesh(request.mesh));
    const double load_s = milliseconds_since(start) / 1000;
    SliceOptions options;
    options.plan = plan_of(request);
    const SliceResult expected = bench::checked(slice(mesh.view(), options));
    Problem problem{mesh.soup.span(), {}, request.threads};
    for (const Layer& layer : expected.layers) {
        problem.planes_mm.push_back(layer.plane.z() * expected.unit_mm);
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
    CLI::App app("Slices a mesh by " + peer.name + ", holds the answer against the engine's and prints the times as JSON");
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
