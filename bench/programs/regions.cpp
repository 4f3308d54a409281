// Times slicing with regions beside the plain slice, and regions of the slice's layers beside the clipping library's.
//
//     lamella_regions MESH LAYER_HEIGHT_MM THREADS ROUNDS
//
// Prints medians as JSON. Everything is warm, and what is compared takes turns, so that a change of the machine's load falls
// on all. Regions of single layers run on one thread. Before that each layer's areas are compared: they may differ by a few
// units along its contours.
#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>

#include <nlohmann/json.hpp>
#include <polyclipping/clipper.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "timing.hpp"

namespace lamella::bench {

namespace {

constexpr double closing_mm = 0.049;
constexpr double offset_mm = 0.2;
/// Grid units by which a contour may lie elsewhere than the library's, on average.
constexpr double apart = 6;

RegionRules non_zero(double closing_mm = 0, double offset = 0) {
    return {.fill_rule = FillRule::non_zero, .closing_mm = closing_mm, .offset_mm = offset};
}

/// Slices with the region into memory of its own, which stays warm.
Timed slicing(std::string name, const MeshView& mesh, SliceOptions options, RegionRules region, int threads) {
    options.region = std::move(region);
    const auto slicer = std::make_shared<Slicer>();
    const auto result = std::make_shared<SliceResult>();
    return {std::move(name), [=] { checked(slicer->slice_to(*result, mesh, options, {.threads = threads})); }};
}

using Spans = std::vector<std::span<const Point>>;

std::vector<Spans> layers_of(const SliceResult& result) {
    std::vector<Spans> layers;
    for (const LayerView layer : result) {
        Spans& contours = layers.emplace_back();
        for (const Contour& contour : layer.contours) {
            if (contour.role != Role::open) {
                contours.push_back(layer.points_of(contour));
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

ClipperLib::Paths grown(const ClipperLib::Paths& paths, double by) {
    ClipperLib::ClipperOffset offset(RegionRules{}.miter_limit);
    offset.AddPaths(paths, ClipperLib::jtMiter, ClipperLib::etClosedPolygon);
    ClipperLib::Paths region;
    offset.Execute(region, by);
    return region;
}

/// A layer's region by ClipperLib 6.4, which the slicers of the Slic3r family use. The contours are there in the library's
/// own form, so that only its work is timed.
class ClipperLayer {
public:
    explicit ClipperLayer(const Spans& contours) {
        for (const std::span<const Point> contour : contours) {
            ClipperLib::Path& path = contours_.emplace_back();
            for (const Point& point : contour) {
                path.emplace_back(point.x, point.y);
            }
        }
    }

    /// As slicers close: united by non-zero, grown by so many grid units with miter joins, then shrunk by as many.
    void close(double radius) {
        ClipperLib::Clipper clipper;
        clipper.AddPaths(contours_, ClipperLib::ptSubject, true);
        if (!clipper.Execute(ClipperLib::ctUnion, region_, ClipperLib::pftNonZero, ClipperLib::pftNonZero)) {
            fail("the library fails");
        }
        if (radius > 0) {
            region_ = grown(grown(region_, radius), -radius);
        }
    }

    /// The area of the last region, square grid units.
    double area() const {
        double sum = 0;
        for (const ClipperLib::Path& path : region_) {
            sum += ClipperLib::Area(path);
        }
        return sum;
    }

private:
    ClipperLib::Paths contours_;
    ClipperLib::Paths region_;
};

/// All layers by the engine and by the library. Throws std::runtime_error if their areas disagree.
class SideBySide {
public:
    explicit SideBySide(const SliceResult& result)
        : unit_mm_(result.info.grid_mm), layers_(layers_of(result)), library_(layers_.begin(), layers_.end()) {}

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

    void theirs(double closing_mm) {
        for (ClipperLayer& layer : library_) {
            layer.close(closing_mm / unit_mm_);
        }
    }

    void compare(const std::string& what, const RegionRules& rules, double closing_mm) {
        for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
            const SliceResult region = checked(region_of(layers_[layer], rules, unit_mm_));
            const double own = region[0].area_mm2() / (unit_mm_ * unit_mm_);
            library_[layer].close(closing_mm / unit_mm_);
            const double difference = std::abs(own - library_[layer].area());
            if (difference > apart * length_of(layers_[layer])) {
                fail(what + " of layer " + std::to_string(layer) + " differs from the library's by " +
                     std::to_string(difference) + " square units, " +
                     std::to_string(difference / length_of(layers_[layer])) + " units along its contours");
            }
        }
    }

    double unit_mm_;
    std::vector<Spans> layers_;
    std::vector<ClipperLayer> library_;
};

nlohmann::ordered_json run(const std::vector<std::string>& words) {
    const SliceOptions options{.layer_height_mm = std::stod(words[1])};
    const int threads = std::stoi(words[2]);
    const int rounds = std::max(1, std::stoi(words[3]));
    const MeshFile mesh = checked(read_mesh(words[0], {}, {.threads = threads}));
    nlohmann::ordered_json report{{"mesh", words[0]}, {"layer_height_mm", options.layer_height_mm}, {"threads", threads}};
    const auto by = [&](const char* name, const RegionRules& rules) {
        return slicing(name, mesh.view(), options, rules, threads);
    };
    report["slices"] = medians_of({by("plain", {}), by("non_zero", non_zero()), by("closing", non_zero(closing_mm)),
                                   by("offset", non_zero(0, offset_mm))},
                                  rounds);
    const SliceResult result = checked(slice(mesh, options, {.threads = threads}));
    report["layers"] = SideBySide(result).medians(std::max(1, rounds / 3));
    return report;
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, 4, 4, "MESH LAYER_HEIGHT_MM THREADS ROUNDS", lamella::bench::run);
}
