// How long both take. Under the adapter's licence: AGPL-3.0-or-later (see adapter.cpp).
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "both.hpp"

namespace compare {
namespace {

using namespace Slic3r;

const std::function<void()> never = [] {};

struct Pair {
    double host_ms = 0;
    double ours_ms = 0;
};

template <class Work>
double milliseconds(const Work& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> times) {
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

// Medians of runs that alternate, so that a machine which slows down slows both. The first of each is not counted.
template <class Host, class Ours>
Pair medians(const Host& host, const Ours& ours) {
    constexpr std::size_t least_runs = 3;
    constexpr std::size_t most_runs = 7;
    constexpr double enough_ms = 20000;
    std::vector<double> host_ms;
    std::vector<double> ours_ms;
    double spent_ms = milliseconds(host) + milliseconds(ours);
    while (host_ms.size() < least_runs || (host_ms.size() < most_runs && spent_ms < enough_ms)) {
        host_ms.push_back(milliseconds(host));
        ours_ms.push_back(milliseconds(ours));
        spent_ms += host_ms.back() + ours_ms.back();
    }
    return {median(host_ms), median(ours_ms)};
}

Pair time_loops(const Model& model, const std::vector<float>& zs) {
    const MeshSlicingParams params;
    return medians([&] { slice_mesh_host(model.mesh, zs, params, never); },
                   [&] { slice_mesh(model.mesh, zs, params, never); });
}

Pair time_regions(const Model& model, const std::vector<float>& zs, float closing_mm) {
    MeshSlicingParamsEx params;
    params.closing_radius = closing_mm;
    return medians([&] { slice_mesh_ex_host(model.mesh, zs, params, never); },
                   [&] { slice_mesh_ex(model.mesh, zs, params, never); });
}

// Per call, over planes spread over the whole height.
Pair time_single_planes(const Model& model) {
    constexpr std::size_t planes = 31;
    const std::vector<float> all = heights(model, 0.2, 0.1);
    std::vector<float> some;
    for (std::size_t plane = 0; plane < planes; ++plane) {
        some.push_back(all[(2 * plane + 1) * all.size() / (2 * planes)]);
    }
    const MeshSlicingParams params;
    const auto over_planes = [&](const auto& slice) {
        return [&some, slice] {
            for (const float z : some) {
                slice(z);
            }
        };
    };
    const Pair sums = medians(over_planes([&](float z) { slice_mesh_host(model.mesh, z, params); }),
                              over_planes([&](float z) { slice_mesh(model.mesh, z, params); }));
    return {sums.host_ms / planes, sums.ours_ms / planes};
}

// Prints a cell, with a mark if it misses its bar: how many times faster it must be.
bool reaches(Pair pair, double bar) {
    const double times = pair.host_ms / pair.ours_ms;
    std::printf(" %.3g -> %.3g (%.1f%s) |", pair.host_ms, pair.ours_ms, times, times < bar ? ", below the bar" : "");
    std::fflush(stdout);
    return times >= bar;
}

}  // namespace

bool time_both(const std::vector<Model>& organs) {
    std::printf("| | slice_mesh | slice_mesh_ex, closing 0 | slice_mesh_ex, closing 0.049 |\n|---|---|---|---|\n");
    bool all = true;
    for (const Model& model : organs) {
        for (const double layer_mm : {0.2, 0.032}) {
            const bool barred = layer_mm == 0.2;
            const std::vector<float> zs = heights(model, layer_mm, layer_mm / 2);
            std::printf("| %s %g mm |", model.name.c_str(), layer_mm);
            all = reaches(time_loops(model, zs), barred ? 12 : 1) && all;
            all = reaches(time_regions(model, zs, 0), 1) && all;
            all = reaches(time_regions(model, zs, 0.049F), barred ? 8 : 1) && all;
            std::printf("\n");
        }
    }
    std::printf("\n| one plane a call | slice_mesh |\n|---|---|\n");
    for (const Model& model : organs) {
        std::printf("| %s |", model.name.c_str());
        all = reaches(time_single_planes(model), 1) && all;
        std::printf("\n");
    }
    return all;
}

}  // namespace compare
