#include "slicing/result/band_output.hpp"

#include <algorithm>
#include <utility>

namespace lamella {

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

}  // namespace lamella
