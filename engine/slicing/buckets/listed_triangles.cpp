#include "slicing/buckets/listed_triangles.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "slicing/buckets/thread_shares.hpp"

namespace lamella {

namespace {

void count_from(CrossedTriangle& record, PlaneIndex base) noexcept {
    const PlaneIndex middle = record.middle_plane();
    record.middle_and_source -= std::min(middle, base);
    record.last -= base;
}

}  // namespace

void ListedSource::count(double /*unit_mm*/) {
    buckets_.list_begin.resize_discarding(listed_.list_begin.size());
    std::copy(listed_.list_begin.begin(), listed_.list_begin.end(), buckets_.list_begin.begin());
    buckets_.segments.resize_discarding(listed_.segments.size());
    std::copy(listed_.segments.begin(), listed_.segments.end(), buckets_.segments.begin());
    buckets_.segment_count = std::accumulate(listed_.segments.begin(), listed_.segments.end(), std::uint64_t{0});
    buckets_.degenerate = 0;
}

std::size_t ListedSource::scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool /*origins*/) {
    std::swap(buckets_.records, listed_.records);
    const auto planes = static_cast<PlaneIndex>(listed_.segments.size());
    const std::span<const std::uint32_t> begins = listed_.list_begin;
    const std::size_t count = begins.back() - begins.front();
    const ThreadShares shares(count, parallel_);
    std::atomic<std::size_t> reaching_count = 0;
    parallel_.run(shares.count, [&](std::size_t share, int) {
        const auto at = [&](std::size_t s) { return begins.front() + static_cast<std::uint32_t>(count * s / shares.count); };
        ReachingWriter writer(reaching, reaching_count);
        const std::uint32_t end = at(share + 1);
        std::uint32_t next = at(share);
        const auto own = std::upper_bound(begins.begin(), begins.end(), next) - begins.begin();
        for (auto plane = static_cast<PlaneIndex>(own - 1); next < end; ++plane) {
            for (const std::uint32_t stop = std::min(end, begins[plane + 1]); next < stop; ++next) {
                CrossedTriangle& record = buckets_.records[next];
                if (listed_.base > 0) {
                    count_from(record, listed_.base);
                }
                const PlaneIndex last = std::min(record.last, planes);
                if (last > reach_end[plane]) {
                    writer.add({next, plane, last});
                }
            }
        }
        writer.flush();
    });
    return reaching_count;
}

void ListedSource::give_back() noexcept {
    std::swap(buckets_.records, listed_.records);
}

}  // namespace lamella
