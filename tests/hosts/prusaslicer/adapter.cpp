// lamella in the place of PrusaSlicer's slice_mesh(), slice_mesh_ex() and slice_mesh_slabs(): the library inside a real
// host, for tests.
//
// This file and those that it includes from this folder are compiled against PrusaSlicer's headers and linked with its code.
// They are therefore under PrusaSlicer's licence, the GNU Affero General Public License, version 3 or, at your option, any
// later version. SPDX-License-Identifier: AGPL-3.0-or-later. Nothing else in the project includes them.
//
// What the host expects, and where it is met:
//
//     heights in any order, repeated          by_height()
//     empty layers of an empty mesh           SliceOptions::allow_empty
//     vertices transformed in float           HostVertex in cut.hpp
//     cancelling by an exception              HostCalls in cut.hpp
//     a vertex on a plane lies above it       PlaneSide::below, the default
//     coordinates of 32 bits, 1e-6 mm         contours.hpp: points are copied as bytes
//     gaps joined up to 2 mm                  SliceOptions::stitch_mm
//     no collinear points in regions          RegionRules::drop_collinear
//     loops turned counter-clockwise          Turn::counter_clockwise, then a region of its own per layer
//     faces turned by a mirroring transform   project() in cut.hpp
#include <tbb/parallel_for.h>

#include <algorithm>
#include <libslic3r/ExPolygon.hpp>
#include <libslic3r/Exception.hpp>
#include <libslic3r/TriangleMesh.hpp>
#include <libslic3r/TriangleMeshSlicer.hpp>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "contours.hpp"
#include "cut.hpp"

namespace Slic3r {
namespace {

using namespace lamella_adapter;
using Mode = MeshSlicingParams::SlicingMode;

Mode mode_of(const MeshSlicingParams& params, std::size_t layer) {
    return layer < params.slicing_mode_normal_below_layer ? params.mode_below : params.mode;
}

// Whether all loops are turned counter-clockwise before they are united.
bool turns_loops(Mode mode) {
    return mode == Mode::Positive || mode == Mode::PositiveLargestContour;
}

lamella::FillRule rule_of(Mode mode) {
    return mode == Mode::EvenOdd ? lamella::FillRule::even_odd : lamella::FillRule::non_zero;
}

// The host dilates by closing_radius and erodes by closing_radius - extra_offset; with a larger extra_offset it only
// dilates.
lamella::RegionRules rules_of(const MeshSlicingParamsEx& params, Mode mode) {
    return {.fill_rule = rule_of(mode),
            .closing_mm = params.closing_radius >= params.extra_offset ? params.closing_radius * frame_per_mm : 0,
            .offset_mm = params.extra_offset * frame_per_mm,
            .drop_collinear = true};
}

Polygons polygons_of(const lamella::LayerView& layer, Mode mode) {
    switch (mode) {
        case Mode::Positive:
            return polygons(layer, Turn::counter_clockwise);
        case Mode::PositiveLargestContour:
            return largest_polygon(layer);
        default:
            return polygons(layer, Turn::as_facets);
    }
}

// The region of one layer's loops, which a mode may turn: the rules of a slice see them as the facets turn them.
ExPolygons region(const lamella::LayerView& layer, const lamella::RegionRules& rules, Mode mode) {
    const auto turned = loops(layer, turns_loops(mode) ? Turn::counter_clockwise : Turn::as_facets);
    const std::vector<std::span<const lamella::Point>> views(turned.begin(), turned.end());
    const lamella::Result<lamella::SliceResult> whole = lamella::region_of(views, rules, layer.grid_mm);
    if (!whole) {
        throw SlicingError(whole.error().message);
    }
    return expolygons((*whole)[0]);
}

void simplify(ExPolygons& whole, double resolution_mm) {
    const double resolution = scaled<double>(resolution_mm);
    if (resolution == 0) {
        return;
    }
    ExPolygons simplified;
    simplified.reserve(whole.size());
    for (const ExPolygon& each : whole) {
        append(simplified, each.simplify(resolution));
    }
    whole = std::move(simplified);
}

// By layer to by height. Heights that fall on one plane share its layer.
template <class Layer>
std::vector<Layer> by_height(std::vector<Layer> layers, const std::vector<std::uint64_t>& layer_of) {
    std::vector<std::uint64_t> in_order(layer_of.size());
    std::iota(in_order.begin(), in_order.end(), std::uint64_t{0});
    if (std::equal(layer_of.begin(), layer_of.end(), in_order.begin())) {
        return layers;
    }
    std::vector<Layer> made;
    made.reserve(layer_of.size());
    for (const std::uint64_t layer : layer_of) {
        made.push_back(layers[layer]);
    }
    return made;
}

// What faces of one sense project, by height.
std::vector<Polygons> slabs_by_height(const lamella::SliceResult& slabs) {
    std::vector<Polygons> layers(slabs.layers.size());
    tbb::parallel_for(std::size_t{0}, layers.size(),
                      [&](std::size_t layer) { layers[layer] = polygons(slabs[layer], Turn::as_facets); });
    return by_height(std::move(layers), slabs.info.layer_of);
}

}  // namespace

std::vector<Polygons> slice_mesh(const indexed_triangle_set& mesh, const std::vector<float>& zs,
                                 const MeshSlicingParams& params, std::function<void()> throw_on_cancel) {
    std::vector<Polygons> layers(zs.size());
    const auto layer_of = cut(mesh, zs, params.trafo, {}, throw_on_cancel, [&](const lamella::LayerView& layer) {
        layers[layer.index] = polygons_of(layer, mode_of(params, layer.index));
    });
    return by_height(std::move(layers), layer_of);
}

Polygons slice_mesh(const indexed_triangle_set& mesh, const float plane_z, const MeshSlicingParams& params) {
    Polygons only;
    cut(mesh, plane_z, params.trafo,
        [&](const lamella::LayerView& layer) { only = polygons_of(layer, mode_of(params, 0)); });
    return only;
}

std::vector<ExPolygons> slice_mesh_ex(const indexed_triangle_set& mesh, const std::vector<float>& zs,
                                      const MeshSlicingParamsEx& params, std::function<void()> throw_on_cancel) {
    // One rule in all layers goes into the slice; others are applied to the loops that it gives.
    const bool mixed = params.slicing_mode_normal_below_layer > 0 && params.mode_below != params.mode;
    const bool at_once = !mixed && !turns_loops(params.mode);
    const lamella::RegionRules rules = at_once ? rules_of(params, params.mode) : lamella::RegionRules{};
    std::vector<ExPolygons> layers(zs.size());
    const auto layer_of = cut(mesh, zs, params.trafo, rules, throw_on_cancel, [&](const lamella::LayerView& layer) {
        const Mode mode = mode_of(params, layer.index);
        ExPolygons whole = at_once ? expolygons(layer) : region(layer, rules_of(params, mode), mode);
        if (mode == Mode::PositiveLargestContour) {
            keep_largest_contour_only(whole);
        }
        simplify(whole, params.resolution);
        layers[layer.index] = std::move(whole);
    });
    return by_height(std::move(layers), layer_of);
}

void slice_mesh_slabs(const indexed_triangle_set& mesh, const std::vector<float>& zs, const Transform3d& trafo,
                      std::vector<Polygons>* out_top, std::vector<Polygons>* out_bottom,
                      std::function<void()> throw_on_cancel) {
    std::vector<std::vector<Polygons>*> wanted;
    std::vector<lamella::LayerContent> faces;
    for (const auto& [out, content] : {std::pair(out_top, lamella::LayerContent::upward_faces),
                                       std::pair(out_bottom, lamella::LayerContent::downward_faces)}) {
        if (out != nullptr) {
            wanted.push_back(out);
            faces.push_back(content);
        }
    }
    const std::vector<lamella::SliceResult> slabs = project(mesh, zs, trafo, faces, throw_on_cancel);
    for (std::size_t at = 0; at < wanted.size(); ++at) {
        *wanted[at] = slabs_by_height(slabs[at]);
    }
}

}  // namespace Slic3r
