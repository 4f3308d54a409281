#include "slicing/result/band_output.hpp"

#include <algorithm>
#include <utility>

#include "base/fit.hpp"

namespace lamella {

namespace {

std::uint64_t count_emptied(std::span<const Layer> layers) noexcept {
    return static_cast<std::uint64_t>(std::count_if(
        layers.begin(), layers.end(), [](const Layer& layer) { return layer.segments > 0 && layer.contour_count == 0; }));
}

}  // namespace

void set_counts(const ContourCounts& counts, SliceResult& result) noexcept {
    SliceSummary& summary = result.summary;
    summary.holes = counts.of(Role::hole);
    summary.open_contours = counts.of(Role::open);
    summary.flat_contours = counts.of(Role::flat);
    summary.overruled_contours = counts.overruled;
    summary.near_contours = counts.near;
    summary.emptied_layers = result.region.keeps_contours() ? 0 : count_emptied(result.layers.span());
}

void BandOutput::trim() {
    begin({});
    fit(buffer);
    fit(contours);
    fit(layer_contours);
    fit(closed_gaps);
}

void BandOutput::move_to_buffer(std::size_t count) {
    if (buffer.capacity() < point_count + count) {
        Array<Point> larger(buffer.memory());
        larger.resize_discarding(std::max(point_count + count, buffer.capacity() + buffer.capacity() / 2));
        std::copy_n(points, point_count, larger.data());
        buffer = std::move(larger);
    } else {
        buffer.set_size(std::max(buffer.size(), point_count + count));
        std::copy_n(points, point_count, buffer.data());
    }
    points = buffer.data();
    capacity = buffer.capacity();
}

}  // namespace lamella
