#include "slicing/buckets/listed_triangles.hpp"

#include <algorithm>
#include <utility>

#include "slicing/buckets/bucket_parts.hpp"

namespace lamella {

namespace {

void count_from(CrossedTriangle& record, PlaneIndex base) noexcept {
    const PlaneIndex middle = record.middle_plane();
    record.middle_and_source -= std::min(middle, base);
    record.last -= base;
}

}  // namespace

void count_crossings(const ListedTriangles& listed, Buckets& buckets) {
    buckets.list_begin.resize_discarding(listed.list_begin.size());
    std::copy(listed.list_begin.begin(), listed.list_begin.end(), buckets.list_begin.begin());
    buckets.segments.resize_discarding(listed.segments.size());
    std::copy(listed.segments.begin(), listed.segments.end(), buckets.segments.begin());
    buckets.segment_count = 0;
    for (const std::uint32_t segments : listed.segments) {
        buckets.segment_count += segments;
    }
    buckets.degenerate = 0;
    buckets.touched.set_size(0);
}

std::size_t scatter_triangles(const ListedTriangles& listed, std::span<const PlaneIndex> reach_end, const Parallel& parallel,
                              Buckets& buckets, std::span<Reaching> reaching) {
    std::swap(buckets.records, listed.records);
    const auto planes = static_cast<PlaneIndex>(listed.segments.size());
    const std::span<const std::uint32_t> begins = listed.list_begin;
    const std::size_t count = begins.back() - begins.front();
    const BucketParts parts(count, parallel);
    ReachingOutput output(reaching, parts.count);
    parallel.run(parts.count, [&](std::size_t part, int) {
        const auto at = [&](std::size_t p) { return begins.front() + static_cast<std::uint32_t>(count * p / parts.count); };
        const std::uint32_t end = at(part + 1);
        std::uint32_t next = at(part);
        const auto own = std::upper_bound(begins.begin(), begins.end(), next) - begins.begin();
        for (auto plane = static_cast<PlaneIndex>(own - 1); next < end; ++plane) {
            for (const std::uint32_t stop = std::min(end, begins[plane + 1]); next < stop; ++next) {
                CrossedTriangle& record = buckets.records[next];
                if (listed.base > 0) {
                    count_from(record, listed.base);
                }
                const PlaneIndex last = std::min(record.last, planes);
                if (last > reach_end[plane]) {
                    output.add(part, {next, plane, last});
                }
            }
        }
    });
    return output.finish();
}

void give_back(const ListedTriangles& listed, Buckets& buckets) noexcept {
    std::swap(buckets.records, listed.records);
}

}  // namespace lamella
