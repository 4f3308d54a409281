// Times slicing with regions beside the plain slice, and regions of the slice's layers beside the clipping library's.
//
//     lamella_regions MESH LAYER_HEIGHT_MM THREADS ROUNDS
//
// Prints medians as JSON. Everything is warm, and what is compared takes turns, so that a change of the machine's load falls
// on all. Regions of single layers run on one thread. Before that each layer's areas are compared: they may differ by a few
// units along its contours.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "clipper_regions.hpp"
#include "lamella/assemble.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "region_area.hpp"

namespace lamella::bench {

namespace {

constexpr double closing_mm = 0.049;
constexpr double offset_mm = 0.2;
/// Grid units by which a contour may lie elsewhere than the library's, on average.
constexpr double apart = 6;

struct Timed {
    std::string name;
    std::function<void()> work;
};

nlohmann::ordered_json medians_of(const std::vector<Timed>& all, int rounds) {
    using Clock = std::chrono::steady_clock;
    std::map<std::string, std::vector<double>> times;
    for (int round = 0; round <= rounds; ++round) {
        for (const Timed& each : all) {
            const auto start = Clock::now();
            each.work();
            times[each.name].push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
        }
    }
    nlohmann::ordered_json medians;
    for (const Timed& each : all) {
        std::vector<double>& own = times[each.name];
        own.erase(own.begin());  // the first only warms
        std::nth_element(own.begin(), own.begin() + rounds / 2, own.end());
        medians[each.name] = own[static_cast<std::size_t>(rounds / 2)];
    }
    return medians;
}

template <class Value>
Value checked(Result<Value> result) {
    if (!result) {
        throw std::runtime_error(result.error().message);
    }
    return std::move(result).value();
}

RegionRules non_zero(double close_mm = 0, double offset = 0) {
    RegionRules rules;
    rules.fill_rule = FillRule::non_zero;
    rules.close_mm = close_mm;
    rules.offset_mm = offset;
    return rules;
}

/// Slices with the region into memory of its own, which stays warm.
Timed slicing(std::string name, const MeshView& mesh, SliceOptions options, RegionRules region) {
    options.region = std::move(region);
    const auto workspace = std::make_shared<Workspace>();
    const auto result = std::make_shared<SliceResult>();
    return {std::move(name), [=] {
                if (const Status done = slice(mesh, options, *workspace, *result); !done) {
                    throw std::runtime_error(done.error().message);
                }
            }};
}

using Spans = std::vector<std::span<const Point>>;

std::vector<Spans> layers_of(const SliceResult& result) {
    std::vector<Spans> layers;
    for (const Layer& layer : result.layers) {
        Spans& contours = layers.emplace_back();
        for (const Contour& contour : result.contours_of(layer)) {
            if (contour.role != Role::open) {
                contours.push_back(result.points_of(contour));
            }
        }
    }
    return layers;
}

double length_of(const Spans& contours) {
    double sum = 0;
    for (const std::span<const Point> contour : contours) {
        for (std::size_t i = 0; i < contour.size(); ++i) {
            const Point& a = contour[i];
            const Point& b = contour[i + 1 < contour.size() ? i + 1 : 0];
            sum += std::hypot(static_cast<double>(b.x) - a.x, static_cast<double>(b.y) - a.y);
        }
    }
    return sum;
}

/// All layers by the engine and by the library. Throws std::runtime_error if their areas disagree.
class SideBySide {
public:
    explicit SideBySide(const SliceResult& result) : unit_mm_(result.unit_mm), layers_(layers_of(result)) {
        for (const Spans& layer : layers_) {
            library_.push_back(std::make_unique<baselines::ClipperLayer>(layer));
        }
    }

    nlohmann::ordered_json medians(int rounds) {
        compare("the union", non_zero(), 0);
        compare("the closing", non_zero(closing_mm), closing_mm);
        return medians_of({{"union", [this] { ours(non_zero()); }},
                           {"library_union", [this] { theirs(0); }},
                           {"closing", [this] { ours(non_zero(closing_mm)); }},
                           {"library_closing", [this] { theirs(closing_mm); }}},
                          rounds);
    }

private:
    void ours(const RegionRules& rules) {
        for (const Spans& layer : layers_) {
            checked(region_of(layer, rules, unit_mm_));
        }
    }

    bool theirs(std::size_t layer, double close_mm) {
        const double miter_limit = RegionRules{}.miter_limit;
        return close_mm > 0 ? library_[layer]->close(close_mm / unit_mm_, miter_limit)
                            : library_[layer]->unite(FillRule::non_zero);
    }

    void theirs(double close_mm) {
        for (std::size_t layer = 0; layer < library_.size(); ++layer) {
            if (!theirs(layer, close_mm)) {
                throw std::runtime_error("the library fails");
            }
        }
    }

    void compare(const std::string& what, const RegionRules& rules, double close_mm) {
        for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
            const double own = area_of(checked(region_of(layers_[layer], rules, unit_mm_)));
            const bool done = theirs(layer, close_mm);
            const double difference = std::abs(own - library_[layer]->area());
            if (!done || difference > apart * length_of(layers_[layer])) {
                throw std::runtime_error(what + " of layer " + std::to_string(layer) + " differs from the library's by " +
                                         std::to_string(difference) + " square units, " +
                                         std::to_string(difference / length_of(layers_[layer])) +
                                         " units along its contours");
            }
        }
    }

    double unit_mm_;
    std::vector<Spans> layers_;
    std::vector<std::unique_ptr<baselines::ClipperLayer>> library_;
};

int run(const std::string& file, double layer_mm, int threads, int rounds) {
    SliceOptions options;
    options.plan = LayerPlan{UniformLayers{.layer_height_mm = layer_mm}};
    options.control.threads = threads;
    const MeshFile mesh = checked(read_mesh(file, ReadOptions{.control = {.threads = threads}}));
    nlohmann::ordered_json report{{"mesh", file}, {"layer_height_mm", layer_mm}, {"threads", threads}};
    report["slices"] =
        medians_of({slicing("plain", mesh.view(), options, {}), slicing("non_zero", mesh.view(), options, non_zero()),
                    slicing("closing", mesh.view(), options, non_zero(closing_mm)),
                    slicing("offset", mesh.view(), options, non_zero(0, offset_mm))},
                   rounds);
    const SliceResult result = checked(slice(mesh.view(), options));
    report["layers"] = SideBySide(result).medians(std::max(1, rounds / 3));
    std::cout << report.dump() << '\n';
    return 0;
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) try {
    if (count != 5) {
        std::cerr << "usage: lamella_regions MESH LAYER_HEIGHT_MM THREADS ROUNDS\n";
        return 2;
    }
    return lamella::bench::run(words[1], std::atof(words[2]), std::atoi(words[3]), std::max(1, std::atoi(words[4])));
} catch (const std::exception& failure) {
    std::cerr << "lamella_regions: " << failure.what() << '\n';
    return 1;
}
