#include "slicing/result/band_output.hpp"

#include <algorithm>
#include <cassert>
#include <type_traits>
#include <utility>

#include "base/vector.hpp"

namespace lamella {

namespace {

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
    summary.cancelled_layers = counts.cancelled_layers;
}

void set_counts(const ContourCounts& counts, SliceResult& result) noexcept {
    set_counts(counts, result.region.keeps_contours() ? 0 : count_emptied(result.layers.span()), result.summary);
}

std::uint64_t count_emptied(std::span<const Layer> layers) noexcept {
    return static_cast<std::uint64_t>(std::count_if(
        layers.begin(), layers.end(), [](const Layer& layer) { return layer.segments > 0 && layer.contour_count == 0; }));
}

void BandOutput::trim() {
    begin({});
    fit(buffer);
    fit(origin_buffer);
    fit(contours);
    fit(layer_contours);
    fit(closed_gaps);
}

void BandOutput::move_to_buffer(std::size_t count) {
    const auto move = [this, count](auto*& elements, auto& own) {
        if (own.capacity() < point_count + count) {
            auto larger = std::remove_reference_t<decltype(own)>(own.memory());
            larger.resize_discarding(std::max(point_count + count, own.capacity() + own.capacity() / 2));
            std::copy_n(elements, point_count, larger.data());
            own = std::move(larger);
        } else {
            own.set_size(std::max(own.size(), point_count + count));
            std::copy_n(elements, point_count, own.data());
        }
        elements = own.data();
    };
    move(points, buffer);
    capacity = buffer.capacity();
    if (with_origins) {
        move(origins, origin_buffer);
        capacity = std::min(capacity, origin_buffer.capacity());
    }
}

void BandOutput::make_room(std::size_t count) {
    assert(point_count == 0);
    if (buffer.size() < count) {
        buffer.resize_discarding(count);
    }
    points = buffer.data();
    capacity = buffer.capacity();
    if (with_origins) {
        if (origin_buffer.size() < count) {
            origin_buffer.resize_discarding(count);
        }
        origins = origin_buffer.data();
        capacity = std::min(capacity, origin_buffer.capacity());
    }
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
    std::swap(*this, other);
    with_origins = other.with_origins;
    counts = other.counts;
    first_layer = other.first_layer + other.layer_contours.size();
    reader = other.reader;
    band = other.band;
}

std::size_t BandOutput::bytes_used() const noexcept {
    return point_count * (sizeof(Point) + (with_origins ? sizeof(PointOrigin) : 0)) + contours.size() * sizeof(Contour) +
           layer_contours.size() * sizeof(std::uint32_t) + closed_gaps.size() * sizeof(ClosedGap);
}

std::size_t BandOutput::bytes_held() const noexcept {
    return buffer.capacity() * sizeof(Point) + origin_buffer.capacity() * sizeof(PointOrigin) +
           contours.capacity() * sizeof(Contour) + layer_contours.capacity() * sizeof(std::uint32_t) +
           closed_gaps.capacity() * sizeof(ClosedGap);
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
