// Both reads, whatever triangles are read from: the shares of threads, their counters, the prefix sums between the two
// reads, and for triangles that are read one by one the reads themselves. Such a triangle has
//
//     is_degenerate()
//     planes()              those that cut it, a PlaneRange
//     write(record, last)   its record, which ends at plane `last`; returns which corner is the lowest
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "base/parallel.hpp"
#include "base/system/processor.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// Triangles in as many shares as there are threads. A share is every so manieth stripe of blocks, since triangles often lie
/// in the order of height, and a tier then has few of the stripes.
struct ThreadShares {
    std::size_t triangles;
    std::size_t count;

    ThreadShares(std::size_t triangle_count, const Parallel& parallel)
        : triangles(triangle_count),
          count(std::min<std::size_t>(static_cast<std::size_t>(parallel.threads()), (triangle_count >> 12) + 1)) {}
    std::size_t blocks() const noexcept { return block_count(triangles); }

    /// Calls use(begin, end) for every block of a share. Each millisecond or sooner the host is asked whether to end.
    template <class Use>
    void for_each_block(std::size_t share, const Parallel& parallel, Use use) const {
        const std::size_t stripe_blocks = std::clamp<std::size_t>(blocks() / (8 * count), 1, 64);
        for (std::size_t stripe = share; stripe * stripe_blocks < blocks(); stripe += count) {
            parallel.stop_if_asked();
            const std::size_t end_block = std::min((stripe + 1) * stripe_blocks, blocks());
            for (std::size_t block = stripe * stripe_blocks; block < end_block; ++block) {
                const std::size_t begin = block * block_triangles;
                use(begin, std::min(begin + block_triangles, triangles));
            }
        }
    }
};

/// Counters of one share, two rows of them, by plane:
///
///     row          while counting                           while scattering
///     0            triangles that it cuts first             where the share's next such record goes
///     1            triangles that the plane below cut last  -
inline std::uint32_t* counters_of(Buckets& buckets, std::size_t share, std::size_t planes, std::size_t row) noexcept {
    return buckets.counters.data() + (2 * share + row) * (planes + 1);
}

struct ShareCounts {
    std::uint32_t* starting;
    std::uint32_t* ended;
    std::uint64_t degenerate = 0;

    ShareCounts(Buckets& buckets, std::size_t share, std::size_t planes) noexcept
        : starting(counters_of(buckets, share, planes, 0)), ended(counters_of(buckets, share, planes, 1)) {
        std::fill_n(starting, 2 * (planes + 1), 0U);
    }
    void add(PlaneIndex first, PlaneIndex last) noexcept {
        ++starting[first];
        ++ended[last];
    }
};

/// Counts triangles [begin, end), at most 64, of which read(t) gives one; returns which of them planes cut. What is not cut
/// adds zero, so that no branch depends on it.
template <class Read>
CrossedBlock count_each(const Read& read, std::size_t begin, std::size_t end, bool may_be_degenerate, ShareCounts& counts) {
    CrossedBlock block;
    for (std::size_t t = begin; t < end; ++t) {
        const auto triangle = read(t);
        if (may_be_degenerate && triangle.is_degenerate()) {
            ++counts.degenerate;
            continue;
        }
        const PlaneRange cut = triangle.planes();
        const std::uint32_t crossed = (cut.first - cut.end) >> 31;  // both are less than 2^31
        counts.starting[cut.first] += crossed;
        counts.ended[cut.end] += crossed;
        block.mask |= std::uint64_t{crossed} << (t - begin);
        block.add(cut.first | (crossed - 1), cut.end & (0U - crossed));
    }
    return block;
}

/// Turns counts into where lists begin, for all and for each share, and sums up the segments: for each plane, then over all.
inline void sum_up(std::size_t planes, std::size_t shares, const Parallel& parallel, Buckets& buckets) {
    const auto each_plane = [&](const auto& use) {
        const std::size_t grain = (std::size_t{1} << 15) / shares + 1;
        parallel.run_ranges(planes, grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t plane = begin; plane < end; ++plane) {
                use(plane);
            }
        });
    };
    each_plane([&](std::size_t plane) {
        std::uint32_t starting = 0;
        std::uint32_t ended = 0;
        for (std::size_t share = 0; share < shares; ++share) {
            starting += counters_of(buckets, share, planes, 0)[plane];
            ended += counters_of(buckets, share, planes, 1)[plane];
        }
        buckets.list_begin[plane] = starting;
        buckets.segments[plane] = starting - ended;  // modulo 2^32, as is their sum
    });
    std::uint32_t begin = 0;
    std::uint32_t active = 0;
    buckets.segment_count = 0;
    for (std::size_t plane = 0; plane < planes; ++plane) {
        begin += std::exchange(buckets.list_begin[plane], begin);
        active = buckets.segments[plane] += active;
        buckets.segment_count += active;
    }
    buckets.list_begin[planes] = begin;
    each_plane([&](std::size_t plane) {
        std::uint32_t next = buckets.list_begin[plane];
        for (std::size_t share = 0; share < shares; ++share) {
            next += std::exchange(counters_of(buckets, share, planes, 0)[plane], next);
        }
    });
}

/// The first read: count_block(begin, end, counts) counts triangles [begin, end), at most 64, and returns what is kept of
/// them.
template <class CountBlock>
void count_blocks(const ThreadShares& shares, const Parallel& parallel, std::size_t planes, Buckets& buckets,
                  CountBlock count_block) {
    buckets.crossed.resize_discarding(shares.blocks());
    buckets.counters.resize_discarding(shares.count * 2 * (planes + 1));
    buckets.list_begin.resize_discarding(planes + 1);
    buckets.segments.resize_discarding(planes);
    PerWorker<std::uint64_t> degenerate(shares.count);
    parallel.run(shares.count, [&](std::size_t share, int) {
        ShareCounts counts(buckets, share, planes);
        shares.for_each_block(share, parallel, [&](std::size_t begin, std::size_t end) {
            buckets.crossed[begin / block_triangles] = count_block(begin, end, counts);
        });
        degenerate[share] = counts.degenerate;
    });
    buckets.degenerate = 0;
    degenerate.for_each([&buckets](std::uint64_t of_share) { buckets.degenerate += of_share; });
    sum_up(planes, shares.count, parallel, buckets);
}

/// Writes down triangles that reach beyond their bands, a buffer at a time: cores that write side by side wait for each
/// other's cache lines.
class ReachingWriter {
public:
    /// `count`: of those written by all.
    ReachingWriter(std::span<Reaching> room, std::atomic<std::size_t>& count) noexcept : room_(room), count_(count) {}

    void add(const Reaching& triangle) noexcept {
        if (size_ == buffer_.size()) {
            flush();
        }
        buffer_[size_++] = triangle;
    }
    void flush() noexcept {
        const std::size_t at = count_.fetch_add(size_, std::memory_order_relaxed);
        assert(at + size_ <= room_.size());
        std::copy_n(buffer_.begin(), size_, room_.begin() + static_cast<std::ptrdiff_t>(at));
        size_ = 0;
    }

private:
    std::array<Reaching, 256> buffer_;
    std::size_t size_ = 0;
    std::span<Reaching> room_;
    std::atomic<std::size_t>& count_;
};

/// A triangle of a soup or of a prepared mesh, which is rounded when it is read.
struct RoundedTriangle {
    GridTriangle v;
    std::size_t number;
    const PlaneSet& all_planes;

    bool is_degenerate() const noexcept { return lamella::is_degenerate(v); }
    PlaneRange planes() const noexcept {
        const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
        return all_planes.between(low, high);
    }
    std::uint8_t write(CrossedTriangle& to, PlaneIndex last) const noexcept {
        CrossedTriangle record = order_by_height(v, static_cast<std::uint32_t>(number));
        record.middle_and_source |= all_planes.first_above(record.middle.z);
        record.last = last;
        to = record;
        return height_order_of(v).lower;
    }
};

/// What a share writes while scattering.
struct ShareRecords {
    CrossedTriangle* records;
    std::uint32_t* next;           ///< by plane: where the next record goes that begins there
    std::uint8_t* lowest_corners;  ///< null where origins are not asked for
    const PlaneIndex* reach_end;
    ReachingWriter reaching;
    PlaneRange tier;
    std::uint32_t tier_begin;
    std::atomic<std::uint32_t>& reaching_in;  ///< where the next record goes that begins below the tier

    /// Where the next record goes that these planes cut, which meet the tier.
    std::uint32_t take_place(PlaneRange cut) noexcept {
        const PlaneIndex end = std::min(cut.end, tier.end);
        if (cut.first < tier.first) {
            const std::uint32_t at = reaching_in.fetch_add(1, std::memory_order_relaxed);
            reaching.add({at, tier.first - 1, end});
            return at;
        }
        const std::uint32_t at = next[cut.first]++ - tier_begin;
        if (end > reach_end[cut.first]) {
            reaching.add({at, cut.first, end});
        }
        return at;
    }

    /// The triangles begin + b with bit b in `crossed`, which are quick to read. First where records go, then the records: a
    /// store that waits for memory would hold up the next ones, and loads that are a multiple of 4096 bytes away from it.
    template <class Read>
    void write_each(const Read& read, std::size_t begin, std::uint64_t crossed) {
        std::array<Reaching, block_triangles> places;
        std::size_t count = 0;
        for (std::uint64_t left = crossed; left != 0; left &= left - 1) {
            const PlaneRange cut = read(begin + static_cast<std::size_t>(std::countr_zero(left))).planes();
            if (!cut.meets(tier)) {
                crossed &= ~(left & (0 - left));
                continue;
            }
            const std::uint32_t at = take_place(cut);
            prefetch_to_write(records + at);
            places[count++] = {at, cut.first, cut.end};
        }
        count = 0;
        for (std::uint64_t left = crossed; left != 0; left &= left - 1, ++count) {
            const Reaching& place = places[count];
            const auto triangle = read(begin + static_cast<std::size_t>(std::countr_zero(left)));
            const std::uint8_t lowest = triangle.write(records[place.record], place.last);
            if (lowest_corners != nullptr) {
                lowest_corners[place.record] = lowest;
            }
        }
    }

    /// The same of triangles that take longer to read than to wait for memory: each is read once.
    template <class Read>
    void write_each_once(const Read& read, std::size_t begin, std::uint64_t crossed) {
        for (; crossed != 0; crossed &= crossed - 1) {
            const RoundedTriangle triangle = read(begin + static_cast<std::size_t>(std::countr_zero(crossed)));
            const PlaneRange cut = triangle.planes();
            if (!cut.meets(tier)) {
                continue;
            }
            const std::uint32_t at = take_place(cut);
            const std::uint8_t lowest = triangle.write(records[at], cut.end);
            if (lowest_corners != nullptr) {
                lowest_corners[at] = lowest;
            }
        }
    }
};

/// The second read, see TriangleSource::scatter(): scatter_block(begin, crossed, records) writes the records of a block's
/// triangles with a bit in `crossed` that the tier takes.
template <class ScatterBlock>
std::size_t scatter_blocks(const ThreadShares& shares, const Parallel& parallel, Buckets& buckets, PlaneRange tier,
                           std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins,
                           ScatterBlock scatter_block) {
    const std::size_t planes = reach_end.size() - 1;
    buckets.tier_begin = buckets.list_begin[tier.first];
    std::atomic<std::uint32_t> reaching_in = buckets.list_of(tier.end);
    buckets.records.resize_discarding(reaching_in + (tier.first > 0 ? buckets.reaching_into(tier.first) : 0));
    buckets.lowest_corners.resize_discarding(origins ? buckets.records.size() : 0);
    std::atomic<std::size_t> reaching_count = 0;
    parallel.run(shares.count, [&](std::size_t share, int) {
        ShareRecords records{buckets.records.data(),
                             counters_of(buckets, share, planes, 0),
                             origins ? buckets.lowest_corners.data() : nullptr,
                             reach_end.data(),
                             ReachingWriter(reaching, reaching_count),
                             tier,
                             buckets.tier_begin,
                             reaching_in};
        shares.for_each_block(share, parallel, [&](std::size_t begin, std::size_t) {
            if (const CrossedBlock& block = buckets.crossed[begin / block_triangles]; block.planes.meets(tier)) {
                scatter_block(begin, block.mask, records);
            }
        });
        records.reaching.flush();
    });
    return reaching_count;
}

}  // namespace lamella
