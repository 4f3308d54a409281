#include "slicing/buckets/lowest_corners.hpp"

namespace lamella {

void find_lowest_corners(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel,
                         Buckets& buckets) {
    constexpr std::size_t grain = std::size_t{1} << 13;
    buckets.lowest_corners.resize_discarding(buckets.records.size());
    with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        parallel.run_ranges(buckets.records.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            parallel.stop_if_asked();
            for (std::size_t record = begin; record < end; ++record) {
                buckets.lowest_corners[record] = height_order_of(read(buckets.records[record].triangle)).lower;
            }
        });
    });
}

}  // namespace lamella
