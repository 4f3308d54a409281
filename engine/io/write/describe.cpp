#include "io/write/describe.hpp"

#include <cmath>

namespace lamella {

namespace {

std::string words(const UniformLayers& layers) {
    const std::string from = layers.datum == Datum::mesh_min ? "the mesh's lowest vertex" : "z = 0";
    std::string text = "layers of " + exact_text(layers.layer_height_mm) + " mm from " + from + " up (datum " +
                       name_of(layers.datum) + "), ";
    if (layers.first_height_mm) {
        return text + "the first plane at " + exact_text(*layers.first_height_mm) + " mm above the datum";
    }
    return text + "the plane in the middle of each";
}

std::string words(const ExplicitPlanes& planes) {
    return counted(planes.heights_mm.size(), "plane") + " at " +
           (planes.heights_mm.size() == 1 ? "a given absolute height" : "given absolute heights");
}

std::string words(const RandomLayers& layers) {
    return "steps drawn from " + exact_text(layers.min_height_mm) + " to " + exact_text(layers.max_height_mm) +
           " mm by seed " + std::to_string(layers.seed) + ", from the mesh's lowest vertex up";
}

/// What the region of each layer went through, as sentences that follow another.
std::string describe_region(const RegionRules& rules) {
    std::string text;
    if (rules.close_mm > 0) {
        text += ". Regions closed by " + exact_text(rules.close_mm) + " mm";
    }
    if (rules.offset_mm != 0) {
        text += ". Regions " + std::string(rules.offset_mm > 0 ? "grown" : "shrunk") + " by " +
                exact_text(std::abs(rules.offset_mm)) + " mm, miter limit " + exact_text(rules.miter_limit);
    }
    if (rules.largest_only) {
        text += ". Only the largest contour of each layer, with its holes";
    }
    if (rules.drop_collinear) {
        text += ". Points within straight lines dropped";
    }
    if (rules.simplify_mm > 0) {
        text += ". Contours simplified by at most " + exact_text(rules.simplify_mm) + " mm";
    }
    if (rules.mark_near_mm > 0) {
        text += ". Contours marked that closing by " + exact_text(rules.mark_near_mm) + " mm would change";
    }
    return text;
}

}  // namespace

const char* name_of(PlaneSide side) noexcept {
    return side == PlaneSide::below ? "below" : "above";
}

const char* name_of(Datum datum) noexcept {
    return datum == Datum::mesh_min ? "mesh-min" : "zero";
}

const char* name_of(GapSense sense) noexcept {
    return sense == GapSense::kept ? "kept" : "any";
}

std::string describe(const LayerPlan& plan) {
    return std::visit([](const auto& spacing) { return words(spacing); }, plan.spacing) +
           "; each height rounded as a vertex of that height would be, then one grid unit " +
           (plan.side == PlaneSide::below ? "down" : "up") + " (side " + name_of(plan.side) + ")";
}

std::string describe_weld(const WeldedMesh& welded) {
    return "Vertices at most " + exact_text(welded.tolerance_mm) +
           " mm apart welded before: " + std::to_string(welded.joined) + " moved";
}

std::string describe_rules(const SliceResult& result) {
    const RegionRules& rules = result.region;
    std::string text = "Fill rule " + std::string(name_of(rules.fill_rule));
    for (const FillFrom& from : rules.fill_from) {
        text += ", from layer " + std::to_string(from.first_layer) + " on " + std::string(name_of(from.rule));
    }
    return text + describe_region(rules);
}

}  // namespace lamella
