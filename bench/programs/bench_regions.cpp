// Times operations on layers beside those of the clipping library, one thread each; and slices with regions and stacks of
// layers with their neighbours beside the plain slice. Slices are warm. Areas are compared before anything is timed.
#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include <polyclipping/clipper.hpp>

#include "lamella/layers.hpp"
#include "lamella/overlay.hpp"
#include "measure.hpp"
#include "region_patterns.hpp"

namespace lamella::bench {

namespace {

constexpr SliceOptions layers{.layer_height_mm = 0.2};
constexpr int region_threads = 2;
constexpr double closing_mm = 0.049;
constexpr double offset_mm = 0.2;
constexpr double units_apart = 8;         // of two areas, along the contours
constexpr double tolerance_share = 0.02;  // of an offset: how far arcs may be from it

RegionRules non_zero(double closing = 0, double offset = 0) {
    return {.fill_rule = FillRule::non_zero, .closing_mm = closing, .offset_mm = offset};
}

/// Slices with the region into memory of its own, which stays warm.
std::function<void()> slicing(const MeshView& mesh, const RegionRules& region) {
    SliceOptions options = layers;
    options.region = region;
    const auto slicer = std::make_shared<Slicer>();
    const auto result = std::make_shared<SliceResult>();
    return [=] { checked(slicer->slice_to(*result, mesh, options, {.threads = region_threads})); };
}

/// Combines into memory of its own, which stays warm.
std::function<void()> combining(const SliceResult& of, LayerSet with, const Rule& rule) {
    const auto overlay = std::make_shared<Overlay>();
    const auto result = std::make_shared<SliceResult>();
    with.layers = of;
    return [=, &of] {
        const LayerSet sets[] = {{.layers = of}, with};
        checked(overlay->combine(*result, sets, rule, {}, {.threads = region_threads}));
    };
}

Figures time_slices(const MeshView& mesh, int rounds) {
    SliceOptions united = layers;
    united.region = non_zero();
    const SliceResult stack = checked(slice(mesh, united));
    return medians_of({{"plain", slicing(mesh, {})},
                       {"non_zero", slicing(mesh, non_zero())},
                       {"closing", slicing(mesh, non_zero(closing_mm))},
                       {"offset", slicing(mesh, non_zero(0, offset_mm))},
                       {"top", combining(stack, {.from = 1, .to = 1}, subtract)},
                       {"overhang", combining(stack, {.from = -1, .to = -1, .grow_mm = offset_mm}, subtract)}},
                      rounds);
}

using ClipperLib::Paths;
using Contours = std::vector<std::span<const Point>>;

/// Layers of a set in the library's own form, so that only its work is timed.
std::vector<Paths> paths_of(const std::vector<Contours>& layers, Point moved = {0, 0}) {
    std::vector<Paths> all;
    for (const Contours& contours : layers) {
        Paths& paths = all.emplace_back();
        for (const std::span<const Point> contour : contours) {
            ClipperLib::Path& path = paths.emplace_back();
            for (const Point& point : contour) {
                path.emplace_back(point.x + moved.x, point.y + moved.y);
            }
        }
    }
    return all;
}

/// By ClipperLib 6.4, which the slicers of the Slic3r family use.
Paths clipped(ClipperLib::ClipType what, const Paths& of, const Paths& with) {
    ClipperLib::Clipper clipper;
    clipper.AddPaths(of, ClipperLib::ptSubject, true);
    clipper.AddPaths(with, ClipperLib::ptClip, true);
    Paths region;
    if (!clipper.Execute(what, region, ClipperLib::pftNonZero, ClipperLib::pftNonZero)) {
        fail("the library fails");
    }
    return region;
}

Paths grown(const Paths& paths, double by, ClipperLib::JoinType join = ClipperLib::jtMiter) {
    ClipperLib::ClipperOffset offset(RegionRules{}.miter_limit, std::abs(by) * tolerance_share);
    offset.AddPaths(paths, join, ClipperLib::etClosedPolygon);
    Paths region;
    offset.Execute(region, by);
    return region;
}

double area_of(const Paths& paths) {
    return std::accumulate(paths.begin(), paths.end(), 0.0,
                           [](double sum, const ClipperLib::Path& path) { return sum + ClipperLib::Area(path); });
}

/// What operations are done to: a region and another one for each layer, with contours that may overlap before.
struct Work {
    std::vector<Contours> contours;  ///< as they were given, which are united
    SliceResult region;              ///< of them
    SliceResult other;               ///< empty: each layer's is the next one of `region`
    double unit_mm = 1;
    double offset = 0;       ///< grid units
    std::vector<Paths> own;  ///< contours, region and other in the library's form
    std::vector<Paths> of;
    std::vector<Paths> with;

    LayerSet other_set() const {
        return other.size() > 0 ? LayerSet{.layers = other} : LayerSet{.layers = region, .from = 1, .to = 1};
    }
};

std::vector<Contours> contours_of(const SliceResult& result) {
    std::vector<Contours> all;
    for (const LayerView layer : result) {
        Contours& contours = all.emplace_back();
        for (const Contour& contour : layer.contours) {
            if (contour.role != Role::open) {
                contours.push_back(layer.points_of(contour));
            }
        }
    }
    return all;
}

double length_of(const std::vector<Contours>& layers) {
    double length = 0;
    for (const Contours& contours : layers) {
        for (const std::span<const Point> points : contours) {
            Point last = points.back();
            for (const Point& point : points) {
                length += std::hypot(static_cast<double>(point.x) - last.x, static_cast<double>(point.y) - last.y);
                last = point;
            }
        }
    }
    return length;
}

/// An operation by both. `ours` fills `result` anew.
struct Operation {
    const char* name;
    std::function<void(SliceResult& result)> ours;
    std::function<Paths(std::size_t layer)> theirs;
};

std::vector<Operation> operations_on(const Work& work, Overlay& overlay) {
    const auto combine = [&](const Rule& rule) {
        return [&, rule](SliceResult& result) {
            const LayerSet sets[] = {{.layers = work.region}, work.other_set()};
            checked(overlay.combine(result, sets, rule, {}, {.threads = 1}));
        };
    };
    const auto clip = [&](ClipperLib::ClipType what) {
        return [&, what](std::size_t n) { return clipped(what, work.of[n], work.with[n]); };
    };
    const double mm = work.offset * work.unit_mm;
    const auto offset = [&overlay, &work, tolerance = mm * tolerance_share](std::vector<OffsetStep> steps, Join join) {
        return [&overlay, &work, steps, join, tolerance](SliceResult& result) {
            checked(overlay.offset(result, {.layers = work.region}, steps, {.join = join, .arc_tolerance_mm = tolerance}, {},
                                   {.threads = 1}));
        };
    };
    return {
        {"difference", combine(subtract), clip(ClipperLib::ctDifference)},
        {"intersection", combine(intersect(2)), clip(ClipperLib::ctIntersection)},
        {"miter", offset({{mm}}, Join::miter), [&](std::size_t n) { return grown(work.of[n], work.offset); }},
        {"round", offset({{mm}}, Join::round),
         [&](std::size_t n) { return grown(work.of[n], work.offset, ClipperLib::jtRound); }},
        {"walls", offset({{-mm}, {-mm}, {-mm}}, Join::miter),
         [&](std::size_t n) {
             const Paths first = grown(work.of[n], -work.offset);
             const Paths second = grown(first, -work.offset);
             Paths all = grown(second, -work.offset);
             all.insert(all.end(), second.begin(), second.end());
             all.insert(all.end(), first.begin(), first.end());
             return all;
         }},
    };
}

Figures time_operations(const Work& work, int rounds) {
    Overlay overlay;
    std::vector<Operation> operations = operations_on(work, overlay);
    const double length = length_of(work.contours);
    std::map<std::string, std::function<void()>> works;
    SliceResult result;
    works["union"] = [&] {
        for (const Contours& contours : work.contours) {
            const ContourSet given{contours, work.unit_mm};
            const LayerSet set[] = {{.layers = given, .fill_rule = FillRule::non_zero}};
            checked(overlay.combine(result, set, unite, {}, {.threads = 1}));
        }
    };
    works["library_union"] = [&] {
        for (const Paths& paths : work.own) {
            clipped(ClipperLib::ctUnion, paths, {});
        }
    };
    for (const Operation& each : operations) {
        each.ours(result);
        double apart = 0;
        double area = 0;
        for (std::size_t n = 0; n < work.of.size(); ++n) {
            const double theirs = area_of(each.theirs(n));
            apart += std::abs(result[n].area_mm2() / (work.unit_mm * work.unit_mm) - theirs);
            area += theirs;
        }
        const bool moves_edges = each.name[0] == 'm' || each.name[0] == 'r' || each.name[0] == 'w';
        if (apart > units_apart * length + (moves_edges ? tolerance_share * area : 0)) {
            fail(std::string(each.name) + " differs from the library's by " + std::to_string(apart / length) +
                 " units along its contours");
        }
        works[each.name] = [&] { each.ours(result); };
        works[std::string("library_") + each.name] = [&] {
            for (std::size_t n = 0; n < work.of.size(); ++n) {
                each.theirs(n);
            }
        };
    }
    Figures figures = medians_of(works, rounds);
    figures["contours"] = static_cast<double>(work.contours[0].size());
    return figures;
}

/// A pattern, and the same moved aside.
Figures time_pattern(const Pattern& pattern, int rounds) {
    constexpr double unit_mm = 1;
    Work work;
    work.contours = {Contours(pattern.contours.begin(), pattern.contours.end())};
    work.unit_mm = unit_mm;
    work.offset = pattern.offset;
    std::vector<std::vector<Point>> moved = pattern.contours;
    for (std::vector<Point>& contour : moved) {
        for (Point& point : contour) {
            point = {point.x + 3'333, point.y + 2'111};
        }
    }
    work.region = checked(region_of(work.contours[0], non_zero(), unit_mm));
    work.other = checked(region_of(Contours(moved.begin(), moved.end()), non_zero(), unit_mm));
    work.own = paths_of(work.contours);
    work.of = paths_of(contours_of(work.region));
    work.with = paths_of(contours_of(work.other));
    return time_operations(work, rounds);
}

/// All layers of a mesh, and those above them.
Figures time_layers(const MeshView& mesh, int rounds) {
    const SliceResult plain = checked(slice(mesh, layers));
    SliceOptions united = layers;
    united.region = non_zero();
    Work work;
    work.contours = contours_of(plain);
    work.region = checked(slice(mesh, united));
    work.unit_mm = plain.info.grid_mm;
    work.offset = offset_mm / work.unit_mm;
    work.own = paths_of(work.contours);
    work.of = paths_of(contours_of(work.region));
    work.with = {work.of.begin() + 1, work.of.end()};
    work.with.emplace_back();
    return time_operations(work, rounds);
}

}  // namespace

void add_regions(const Options& options) {
    for (const auto make : list_patterns()) {
        const std::string name = make(0.01).name;
        add_benchmark(options, "regions/" + name + "/operations", 1,
                      [=](benchmark::State&) { return time_pattern(make(options.quick ? 0.01 : 1), 1); });
    }
}

void add_slices_with_regions(const Options& options, const Case& wanted) {
    const int rounds = options.quick ? 1 : 3;
    add_benchmark(options, "regions/" + wanted.name + "/slices", region_threads,
                  [=](benchmark::State&) { return time_slices(prepared(wanted).mesh->view(), 3 * rounds); });
    add_benchmark(options, "regions/" + wanted.name + "/operations", 1,
                  [=](benchmark::State&) { return time_layers(prepared(wanted).mesh->view(), rounds); });
}

}  // namespace lamella::bench
