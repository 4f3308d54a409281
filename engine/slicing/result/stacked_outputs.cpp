#include "slicing/result/stacked_outputs.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace lamella {

namespace {

/// Where an output's contours and points begin in the result.
struct StackPlace {
    std::uint64_t contour = 0;
    std::uint64_t point = 0;
};

void place_output(const BandOutput& output, StackPlace begin, SliceResult& result) {
    std::copy_n(output.points, output.point_count, result.points.data() + begin.point);
    if (output.with_origins) {
        std::copy_n(output.origins, output.point_count, result.origins.data() + begin.point);
    }
    for (std::size_t c = 0; c < output.contours.size(); ++c) {
        Contour& contour = result.contours[begin.contour + c] = output.contours[c];
        contour.first_point += begin.point;
        contour.parent += contour.parent < 0 ? 0 : static_cast<std::int64_t>(begin.contour);
    }
    std::uint64_t first = begin.contour;
    for (std::size_t i = 0; i < output.layer_contours.size(); ++i) {
        Layer& layer = result.layers[output.first_layer + i];
        layer.first_contour = first;
        layer.contour_count = output.layer_contours[i];
        first += layer.contour_count;
    }
}

}  // namespace

ContourCounts stack_outputs(std::span<const std::unique_ptr<BandOutput>> outputs, bool with_origins,
                            const Parallel& parallel, SliceResult& result) {
    ContourCounts counts;
    std::vector<StackPlace> begins;
    StackPlace next;
    begins.reserve(outputs.size());
    for (const auto& output : outputs) {
        begins.push_back(next);
        next.contour += output->contours.size();
        next.point += output->point_count;
        counts.add(output->counts);
    }
    result.contours.resize_discarding(next.contour);
    result.points.resize_discarding(next.point);
    result.origins.resize_discarding(with_origins ? next.point : 0);
    parallel.run(outputs.size(), [&](std::size_t i, int) { place_output(*outputs[i], begins[i], result); });
    return counts;
}

}  // namespace lamella
