#include "4_bucket/bucket.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "4_bucket/z_scan.hpp"

namespace lamella {

namespace {

constexpr std::size_t word_bits = 64;

/// The mesh in as many parts as there are threads, cut between words of the mask.
struct Parts {
    std::size_t triangles;
    std::size_t count;

    Parts(std::size_t triangle_count, const Parallel& parallel)
        : triangles(triangle_count),
          count(std::min<std::size_t>(static_cast<std::size_t>(parallel.threads()), (triangle_count >> 12) + 1)) {}
    std::size_t words() const noexcept { return (triangles + word_bits - 1) / word_bits; }
    std::size_t begin_word(std::size_t part) const noexcept { return words() * part / count; }
};

/// Counters of one part: triangles by first plane, and by the plane past their last.
struct PartCounters {
    std::uint32_t* first;
    std::uint32_t* last;

    PartCounters(Buckets& buckets, std::size_t part, std::size_t planes)
        : first(buckets.counters.data() + part * 2 * (planes + 1)), last(first + planes + 1) {}
};

/// The count of one part.
template <class Reader>
class PartCount {
public:
    PartCount(const Reader& read, const ZScan& scan, const PlaneSet& planes, PartCounters counters)
        : read_(read), scan_(scan), planes_(planes), counters_(counters) {
        std::fill_n(counters_.first, 2 * (std::size_t{planes.size()} + 1), 0U);
    }

    /// Triangles [begin, end), at most 64; returns which of them planes cut.
    std::uint64_t count(std::size_t begin, std::size_t end) {
        return scan_.usable() && end - begin == word_bits ? count_scanned(begin) : count_each(begin, end);
    }

    std::uint64_t degenerate() const noexcept { return degenerate_; }

private:
    std::uint64_t count_each(std::size_t begin, std::size_t end) {
        std::uint64_t mask = 0;
        for (std::size_t t = begin; t < end; ++t) {
            const GridTriangle v = read_(t);
            if (is_degenerate(v)) {
                ++degenerate_;
                continue;
            }
            const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
            const PlaneIndex first = planes_.first_above(low, hint_);
            hint_ = first;
            if (planes_.z(first) < high) {
                add(first, planes_.first_above(high, first));
                mask |= std::uint64_t{1} << (t - begin);
            }
        }
        return mask;
    }

    std::uint64_t count_scanned(std::size_t begin) {
        ZBlock block;
        scan_(begin, block);
        for (std::uint64_t level = block.level_edge; level != 0; level &= level - 1) {
            const int t = __builtin_ctzll(level);
            if (is_degenerate(read_(begin + static_cast<std::size_t>(t)))) {
                ++degenerate_;
                block.crossed &= ~(std::uint64_t{1} << t);
            }
        }
        for (std::uint64_t crossed = block.crossed; crossed != 0; crossed &= crossed - 1) {
            const int t = __builtin_ctzll(crossed);
            add(block.first[t], planes_.first_above(block.high[t], block.first[t]));
        }
        return block.crossed;
    }

    void add(PlaneIndex first, PlaneIndex last) {
        ++counters_.first[first];
        ++counters_.last[last];
    }

    const Reader& read_;
    const ZScan& scan_;
    const PlaneSet& planes_;
    PartCounters counters_;
    std::uint64_t degenerate_ = 0;
    PlaneIndex hint_ = 0;
};

/// The order of three vertices by height, and whether it is an odd permutation of them: then the facet walks the long edge
/// upwards. Indexed by (z1 < z0) + 2 (z2 < z1) + 4 (z2 < z0): comparisons without branches, since nothing predicts them.
struct HeightOrder {
    std::uint8_t lower, middle, upper, odd;
};
constexpr HeightOrder height_orders[8] = {
    {0, 1, 2, 0}, {1, 0, 2, 1}, {0, 2, 1, 1}, {0, 1, 2, 0}, {0, 1, 2, 0}, {1, 2, 0, 0}, {2, 0, 1, 0}, {2, 1, 0, 1},
};

CrossedTriangle order_by_height(const GridTriangle& v, std::uint32_t triangle) noexcept {
    const unsigned index = (v[1].z < v[0].z ? 1U : 0U) + (v[2].z < v[1].z ? 2U : 0U) + (v[2].z < v[0].z ? 4U : 0U);
    const HeightOrder& order = height_orders[index];
    return {v[order.lower], v[order.middle], v[order.upper], triangle, order.odd != 0 ? 0U : 1U << 31, 0};
}

template <class Reader>
void scatter_part(const Reader& read, const PlaneSet& planes, const Parts& parts, std::size_t part, Buckets& buckets) {
    PartCounters counters(buckets, part, planes.size());
    PlaneIndex hint = 0;
    for (std::size_t word = parts.begin_word(part); word < parts.begin_word(part + 1); ++word) {
        for (std::uint64_t mask = buckets.crossed_mask[word]; mask != 0; mask &= mask - 1) {
            const std::size_t t = word * word_bits + static_cast<std::size_t>(__builtin_ctzll(mask));
            CrossedTriangle record = order_by_height(read(t), static_cast<std::uint32_t>(t));
            const PlaneIndex first = planes.first_above(record.lower.z, hint);
            const PlaneIndex middle = planes.first_above(record.middle.z, first);
            hint = first;
            record.middle_and_sense |= middle;
            record.last = planes.first_above(record.upper.z, middle);
            buckets.records[counters.first[first]++] = record;
        }
    }
}

/// Turns counts into list beginnings, for all and for each part, and sums up the segments.
void prefix_sums(const PlaneSet& planes, const Parts& parts, Buckets& buckets) {
    const std::size_t k = planes.size();
    std::uint32_t begin = 0;
    std::int64_t active = 0;
    buckets.segment_count = 0;
    for (std::size_t plane = 0; plane < k; ++plane) {
        buckets.list_begin[plane] = begin;
        for (std::size_t part = 0; part < parts.count; ++part) {
            PartCounters counters(buckets, part, k);
            active += counters.first[plane];
            active -= counters.last[plane];
            begin += std::exchange(counters.first[plane], begin);
        }
        buckets.segments[plane] = static_cast<std::uint32_t>(active);
        buckets.segment_count += static_cast<std::uint64_t>(active);
    }
    buckets.list_begin[k] = begin;
}

}  // namespace

void count_crossings(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                     const Parallel& parallel, Buckets& buckets) {
    const Parts parts(mesh.triangle_count, parallel);
    const std::size_t k = planes.size();
    buckets.crossed_mask.resize_discarding(parts.words());
    buckets.counters.resize_discarding(parts.count * 2 * (k + 1));
    buckets.list_begin.resize_discarding(k + 1);
    buckets.segments.resize_discarding(k);
    std::vector<std::uint64_t> degenerate(parts.count);
    const ZScan scan(mesh, transform, unit_mm, planes);
    with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        parallel.run(parts.count, [&](std::size_t part, int) {
            PartCount counter(read, scan, planes, PartCounters(buckets, part, k));
            for (std::size_t word = parts.begin_word(part); word < parts.begin_word(part + 1); ++word) {
                const std::size_t begin = word * word_bits;
                buckets.crossed_mask[word] = counter.count(begin, std::min(begin + word_bits, parts.triangles));
            }
            degenerate[part] = counter.degenerate();
        });
    });
    buckets.degenerate = std::accumulate(degenerate.begin(), degenerate.end(), std::uint64_t{0});
    prefix_sums(planes, parts, buckets);
}

void scatter_triangles(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                       const Parallel& parallel, Buckets& buckets) {
    const Parts parts(mesh.triangle_count, parallel);
    buckets.records.resize_discarding(buckets.list_begin[planes.size()]);
    with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        parallel.run(parts.count, [&](std::size_t part, int) { scatter_part(read, planes, parts, part, buckets); });
    });
}

}  // namespace lamella
