#include "slice/part_warnings.hpp"

#include <algorithm>
#include <cmath>

#include "files/scale_words.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

std::string why_nothing_is_cut(const SliceSummary& found) {
    return "no plane meets the mesh, which reaches from " + exact_text(found.min_mm[2]) + " to " +
           exact_text(found.max_mm[2]) + " mm along the slicing direction";
}

std::string why_nothing_is_left(const SliceResult& result) {
    const double offset_mm = result.region.offset_mm;
    const std::string what = offset_mm < 0 ? "an offset of " + exact_text(offset_mm) + " mm" : "the fill rule";
    return what + " leaves nothing: " +
           (result.summary.emptied_layers == 1
                ? "the one layer that the mesh crosses is empty"
                : "all " + counted(result.summary.emptied_layers, "layer") + " that the mesh crosses are empty");
}

std::vector<std::string> doubts_of(const SliceResult& result, const SliceArguments& arguments, const MeshFile& mesh,
                                   const std::optional<ImageGeometry>& image) {
    const std::optional<double> distance = least_plane_distance(result.plan);
    MeasuredMesh measured{.min_mm = result.summary.min_mm,
                          .max_mm = result.summary.max_mm,
                          .unit_mm = result.unit_mm,
                          .plane_distance_mm = distance,
                          .detail_mm = distance.value_or(common_layer_mm),
                          .moved = !arguments.transform.empty() || !arguments.normal.empty()};
    if (image) {
        measured.detail_mm = std::min({measured.detail_mm, image->spacing_mm[0], image->spacing_mm[1]});
        for (const auto& corner : {result.summary.min_mm, result.summary.max_mm}) {
            for (const double at : image->to_lps({corner[0], corner[1], corner[2]})) {
                measured.farthest_mm = std::max(measured.farthest_mm.value_or(0), std::abs(at));
            }
        }
    }
    return doubts_of_scale(arguments, mesh, measured);
}

}  // namespace

std::vector<std::string> warnings_of(const SlicedPart& part, std::optional<std::uint64_t> contours,
                                     const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image) {
    const SliceSummary& summary = part.result.summary;
    std::vector<std::string> warnings;
    if (part.open.layers > 0 && !arguments.outputs.strict) {  // which says the same
        warnings.push_back(arguments.name() + (arguments.split ? ", " + part.name : "") + ": " +
                           describe(part.open, "--close-gaps "));
    }
    if (summary.segments == 0) {
        warnings.push_back(why_nothing_is_cut(summary));
    }
    if (summary.emptied_layers > 0 && contours.value_or(part.result.contours.size()) == 0) {
        warnings.push_back(why_nothing_is_left(part.result));
    }
    if (summary.cancelled_layers > 0) {
        warnings.push_back("in " + counted(summary.cancelled_layers, "layer") +
                           " shells turned inwards overlap others, and where they do, both cancel: solid is missing there; "
                           "--orient-shells turns each shell outwards unless it bounds a cavity");
    }
    const std::vector<std::string> doubts = doubts_of(part.result, arguments, mesh, image);
    warnings.insert(warnings.end(), doubts.begin(), doubts.end());
    return warnings;
}

}  // namespace lamella::cli
