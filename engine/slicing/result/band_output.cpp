#include "slicing/result/band_output.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "base/fit.hpp"

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

void set_counts(const ContourCounts& counts, std::uint64_t emptied_layers, SliceSummary& summary) noexcept {
    summary.holes = counts.of(Role::hole);
    summary.open_contours = counts.of(Role::open);
    summary.flat_contours = counts.of(Role::flat);
    summary.overruled_contours = counts.overruled;
    summary.near_contours = counts.near;
    summary.emptied_layers = emptied_layers;
}

void set_counts(const ContourCounts& counts, std::span<const Layer> layers, SliceResult& result) noexcept {
    set_counts(counts, result.region.keeps_contours() ? 0 : count_emptied(layers), result.summary);
}

void set_counts(const ContourCounts& counts, SliceResult& result) noexcept {
    set_counts(counts, result.layers.span(), result);
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

void BandOutput::make_room(std::size_t count) {
    assert(point_count == 0);
    if (buffer.capacity() < count) {
        buffer.resize_discarding(count);
    }
    points = buffer.data();
    capacity = buffer.capacity();
}

void BandOutput::drop_layers() noexcept {
    first_layer += layer_contours.size();
    point_count = 0;
    contours.clear();
    layer_contours.clear();
    closed_gaps.clear();
}

void BandOutput::move_layers_to(BandOutput& other) noexcept {
    assert(in_buffer() && other.point_count == 0);
    other.begin(other.buffer.span());
    std::swap(buffer, other.buffer);
    std::swap(points, other.points);
    std::swap(point_count, other.point_count);
    std::swap(capacity, other.capacity);
    contours.swap(other.contours);
    layer_contours.swap(other.layer_contours);
    closed_gaps.swap(other.closed_gaps);
    other.first_layer = first_layer;
    first_layer += other.layer_contours.size();
}

std::size_t BandOutput::bytes_used() const noexcept {
    return point_count * sizeof(Point) + contours.size() * sizeof(Contour) + layer_contours.size() * sizeof(std::uint32_t) +
           closed_gaps.size() * sizeof(ClosedGap);
}

std::size_t BandOutput::bytes_held() const noexcept {
    return buffer.capacity() * sizeof(Point) + contours.capacity() * sizeof(Contour) +
           layer_contours.capacity() * sizeof(std::uint32_t) + closed_gaps.capacity() * sizeof(ClosedGap);
}

void BandOutput::release() noexcept {
    *this = BandOutput(buffer.memory());
}

LayerContours copy_layer(const BandOutput& output, StopPace& pace, const Memory* memory) {
    LayerContours layer{Array<Contour>(memory), Array<Point>(memory)};
    copy_paced(output.contours.data(), output.contours.size(), pace, layer.contours);
    copy_paced(output.points, output.point_count, pace, layer.points);
    return layer;
}

}  // namespace lamella
