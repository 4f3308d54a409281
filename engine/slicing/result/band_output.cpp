#include "slicing/result/band_output.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "slicing/result/layer_target.hpp"

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

void LayerTotals::add(const LayerTotals& other) noexcept {
#define END_COUNTER(name) name += other.name;
#include "options/counters.inc"
}

void LayerTotals::describe(SliceInfo& info) const noexcept {
#define END_COUNTER(name) info.name = name;
#include "options/counters.inc"
    info.emptied_layers = info.options.region.keeps_contours() ? 0 : emptied_layers;
}

void BandOutput::finish_layer() {
    if (reader != nullptr) {
        reader->layer_done(*this);
    }
}

void BandOutput::move_to_buffer(std::size_t count) {
    const std::size_t room = point_count + count;
    const auto move = [this, room](auto*& elements, auto& own) {
        if (point_count > 0 && own.capacity() < room) {
            auto larger = std::remove_reference_t<decltype(own)>(own.memory());
            larger.resize_discarding(std::max(room, own.capacity() + own.capacity() / 2));
            std::copy_n(elements, point_count, larger.data());
            own = std::move(larger);
        } else {
            own.resize_discarding(std::max(own.size(), room));
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

void BandOutput::drop_layers() noexcept {
    first_layer += layer_contours.size();
    point_count = 0;
    contours.clear();
    layer_contours.clear();
    stitches.clear();
}

std::size_t BandOutput::bytes_used() const noexcept {
    return point_count * (sizeof(Point) + (with_origins ? sizeof(PointOrigin) : 0)) + contours.size() * sizeof(Contour) +
           layer_contours.size() * sizeof(std::uint32_t) + stitches.size() * sizeof(Stitch);
}

std::size_t BandOutput::bytes_held() const noexcept {
    return buffer.capacity() * sizeof(Point) + origin_buffer.capacity() * sizeof(PointOrigin) +
           contours.capacity() * sizeof(Contour) + layer_contours.capacity() * sizeof(std::uint32_t) +
           stitches.capacity() * sizeof(Stitch);
}

void BandOutput::release() noexcept {
    *this = BandOutput(buffer.memory());
}

SliceResult copy_layer(const BandOutput& output, std::uint64_t segments, StopPace& pace, const Memory* memory) {
    SliceResult result(memory);
    copy_paced(output.contours.data(), output.contours.size(), pace, result.contours);
    copy_paced(output.points, output.point_count, pace, result.points);
    result.layers.resize_discarding(1);
    result.layers[0] = {.contour_count = result.contours.size(), .segments = segments, .plane = {}};
    result.info.layers = result.info.planned_layers = 1;
    result.info.segments = segments;
    LayerTotals totals = output.totals;
    totals.add(result.layers[0]);
    totals.describe(result.info);
    return result;
}

}  // namespace lamella
