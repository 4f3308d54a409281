#include "io/write/describe.hpp"

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

}  // namespace

const char* name_of(PlaneSide side) noexcept {
    return side == PlaneSide::below ? "below" : "above";
}

const char* name_of(Datum datum) noexcept {
    return datum == Datum::mesh_min ? "mesh-min" : "zero";
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
    std::string text = "Fill rule " + std::string(name_of(result.region.fill_rule));
    if (result.close_gaps_mm > 0) {
        text += ". Gaps of up to " + exact_text(result.close_gaps_mm) +
                " mm closed: " + std::to_string(result.closed_gaps.size());
    }
    return text;
}

}  // namespace lamella
