#include "slicing/result/band_output.hpp"

#include <algorithm>
#include <utility>

namespace lamella {

namespace {

std::uint64_t count_emptied(std::span<const Layer> layers) noexcept {
    return static_cast<std::uint64_t>(std::count_if(
        layers.begin(), layers.end(), [](const Layer& layer) { return layer.segments > 0 && layer.contour_count == 0; }));
}

template <class T>
void copy_paced(const T* from, std::size_t count, StopPace& pace, Array<T>& to) {
    constexpr std::size_t words = (sizeof(T) + 7) / 8;
    to.resize_discarding(count);
    pace.in_stretches(0, count, words,
                      [&](std::size_t begin, std::size_t end) { std::copy(from + begin, from + end, to.data() + begin); });
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

void BandOutput::move_to_buffer(std::size_t count) {
    if (buffer.capacity() < point_count + count) {
        Array<Point> larger(buffer.memory());
        larger.resize_discarding(std::max(point_count + count, buffer.capacity() + buffer.capacity() / 2));
        std::copy_n(points, point_count, larger.data());
        buffer = std::move(larger);
    } else {
        std::copy_n(points, point_count, buffer.data());
    }
    points = buffer.data();
    capacity = buffer.capacity();
}

LayerContours copy_layer(const BandOutput& output, StopPace& pace, const Memory* memory) {
    LayerContours layer{Array<Contour>(memory), Array<Point>(memory)};
    copy_paced(output.contours.data(), output.contours.size(), pace, layer.contours);
    copy_paced(output.points, output.point_count, pace, layer.points);
    return layer;
}

}  // namespace lamella
