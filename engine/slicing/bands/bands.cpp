#include "slicing/bands/bands.hpp"

#include <algorithm>
#include <numeric>

#include "base/parallel.hpp"

namespace lamella {

namespace {

/// A band has at least so many segments if threads allow: about 2 MB of points, which stay in a core's cache until placed.
constexpr std::uint64_t least_segments = 1 << 18;
/// A band has at least so much work: some 20 us, for less than which no other thread is worth waking.
constexpr std::uint64_t least_work = 1 << 12;
/// A triangle that enters costs as much as so many segments: its edges are looked up and its links written.
constexpr std::uint64_t segments_per_entry = 24;
/// A band has at least so much work for each seed. A seed costs what a triangle that enters does: a twenty-fifth of it.
constexpr std::uint64_t work_per_seed = 25 * segments_per_entry;
/// So many slots that a plane passes over, since their edges have ended, cost as much as a segment.
constexpr std::uint64_t ended_per_segment = 8;

std::uint64_t entering_at(const Buckets& buckets, PlaneIndex plane) noexcept {
    return buckets.list_begin[plane + 1] - buckets.list_begin[plane];
}

/// All threads work on a plane together if it is large, and either a sixteenth of all segments or mostly of triangles that
/// enter there. Keeping links from plane to plane gains little there, and bands would leave threads without work.
bool is_wide(const Buckets& buckets, PlaneIndex plane) noexcept {
    constexpr std::uint32_t large = 1 << 18;
    constexpr std::uint64_t few = 16;
    const std::uint64_t segments = buckets.segments[plane];
    return segments >= large && (few * segments >= buckets.segment_count || 2 * entering_at(buckets, plane) >= segments);
}

std::uint64_t work_of(const Buckets& buckets, PlaneIndex plane) noexcept {
    return buckets.segments[plane] + segments_per_entry * entering_at(buckets, plane);
}

/// Large arrays are released: only very many bands or tall triangles need them.
template <class T>
void give_back_many(Array<T>& array) {
    constexpr std::size_t many_bytes = std::size_t{1} << 23;
    if (array.capacity() * sizeof(T) > many_bytes) {
        array = Array<T>(array.memory());
    }
}

}  // namespace

void BandPlan::cut(const Buckets& buckets, PlaneIndex planes, int asked_planes, int threads, std::uint64_t most_segments) {
    constexpr std::uint64_t few_seeds = 1 << 21;
    const std::uint64_t crossed = buckets.list_begin[planes] - buckets.list_begin[0];
    auto most_planes = static_cast<std::uint64_t>(asked_planes);
    cut_tiers(buckets, planes, asked_planes > 0);
    for (;; most_planes *= 2, most_segments *= 2) {
        most_segments = most_segments < buckets.segment_count ? most_segments : no_limit / 2;
        cut_once(buckets, planes, most_planes, threads, most_segments);
        const auto add = [&](std::uint64_t sum, const Band& band) { return sum + buckets.reaching_into(band.first); };
        const std::uint64_t seeds = std::accumulate(bands.begin(), bands.end(), std::uint64_t{0}, add);
        const bool as_work_asks = most_segments >= buckets.segment_count && (most_planes == 0 || most_planes >= planes);
        if (as_work_asks || seeds <= std::max(crossed, few_seeds)) {
            reaching.resize_discarding(std::min(seeds, crossed));
            break;
        }
    }
    band_end.assign(std::size_t{planes} + 1, planes);
    for (const Band& band : bands) {
        std::fill(band_end.begin() + band.first, band_end.begin() + band.last, band.last);
    }
}

/// Where bands are asked for, a small mesh too is cut into tiers, whatever reaches into them and in whatever order it lies.
void BandPlan::cut_tiers(const Buckets& buckets, PlaneIndex planes, bool asked) {
    constexpr std::uint64_t parts = 3;
    constexpr std::uint64_t least_records = 1 << 18;  // 12 MB
    const std::uint64_t crossed = buckets.list_begin[planes];
    const bool is_small = asked && crossed < least_records;
    const std::uint64_t enough = std::max(crossed / parts, is_small ? 1 : least_records);
    const auto tier_of = [&buckets](PlaneIndex first, PlaneIndex end) {
        const std::uint64_t own = buckets.list_begin[end] - buckets.list_begin[first];
        return Tier{{first, end}, own + (first > 0 ? buckets.reaching_into(first) : 0)};
    };
    tiers.clear();
    PlaneIndex first = 0;
    for (PlaneIndex plane = 1; plane < planes; ++plane) {
        const std::uint64_t own = buckets.list_begin[plane] - buckets.list_begin[first];
        const std::uint64_t rest = crossed - buckets.list_begin[plane];
        if (own >= enough && 2 * rest >= enough && (is_small || 4 * buckets.reaching_into(plane) <= enough)) {
            tiers.push_back(tier_of(first, plane));
            first = plane;
        }
    }
    tiers.push_back(tier_of(first, planes));
    if (tiers.size() == 1) {
        return;
    }
    // Blocks that are read, of a sample: planes of all are more than one thread should look at.
    constexpr std::size_t enough_blocks = 1 << 12;
    const std::size_t stride = 1 + buckets.crossed.size() / enough_blocks;
    std::size_t looked_at = 0;
    std::size_t reads = 0;
    for (std::size_t block = 0; block < buckets.crossed.size(); block += stride) {
        const auto reads_it = [&](const Tier& tier) { return buckets.crossed[block].planes.meets(tier.planes); };
        reads += static_cast<std::size_t>(std::count_if(tiers.begin(), tiers.end(), reads_it));
        ++looked_at;
    }
    const bool is_read_again = !is_small && 10 * reads > 13 * looked_at;
    if (buckets.crossed.empty() || is_read_again) {
        tiers.assign(1, tier_of(0, planes));
    }
}

/// Bands of `most_planes` planes, or by their work where that is 0. Many threads get more bands than seeds would pay for.
/// Of several tiers, in each of which threads wait for the last band, they become smaller towards the end.
void BandPlan::cut_once(const Buckets& buckets, PlaneIndex planes, std::uint64_t most_planes, int threads,
                        std::uint64_t most_segments) {
    bands.clear();
    const auto work_in = [&buckets](PlaneRange range) {
        const std::uint32_t* const segments = buckets.segments.data();
        const std::uint64_t entering = buckets.list_begin[range.end] - buckets.list_begin[range.first];
        return std::accumulate(segments + range.first, segments + range.end, segments_per_entry * entering);
    };
    const std::uint64_t all_work = work_in({0, planes});
    // Several bands for each thread even out those that take longer; on one thread they only serve the cache.
    const auto shares = static_cast<std::uint64_t>(threads);
    const std::uint64_t share = std::max(all_work / (16 * shares) + 1, least_work);
    Band band{0, 0, 0, false};
    Tier* tier = tiers.data();
    std::uint64_t left = work_in(tier->planes);  // of the tier, from the band's first plane on
    std::uint64_t work = 0;
    std::uint64_t most_active = 0;  // segments of a plane of the band
    std::uint64_t ended = 0;        // slots passed over, were the band to go on
    for (PlaneIndex plane = 0; plane < planes; ++plane) {
        const std::uint64_t segments = buckets.segments[plane];
        const std::uint64_t most =
            std::clamp(work_per_seed * segments, std::min(share, least_segments), std::max(share, least_segments));
        const std::uint64_t fair = (tiers.size() == 1 ? all_work / 3 : left / 2) / shares;
        const std::uint64_t least = std::min(std::max(most / 8, 8 * least_work), most);
        const std::uint64_t enough = threads == 1 ? most : std::clamp(fair, least, most);
        ended += most_active - std::min(most_active, segments);
        const bool is_sparse = ended / ended_per_segment > least_work + segments_per_entry * buckets.reaching_into(plane);
        const bool has_points = band.segments >= most_segments || segments > most_segments - band.segments;
        const bool has_work = most_planes > 0 ? plane - band.first >= most_planes : work >= enough || is_sparse;
        const bool wide = is_wide(buckets, plane);
        const bool is_tier_end = plane == tier->planes.end;
        if ((has_points || has_work || wide || band.wide || is_tier_end) && plane > band.first) {
            bands.push_back(band);
            left -= work;
            if (is_tier_end) {
                tier->last_band = bands.size();
                (++tier)->first_band = bands.size();
                left = work_in(tier->planes);
            }
            band = {plane, plane, 0, false};
            work = most_active = ended = 0;
        }
        band.last = plane + 1;
        band.wide = wide;
        band.segments += segments;
        work += work_of(buckets, plane);
        most_active = std::max(most_active, segments);
    }
    if (planes > 0) {
        bands.push_back(band);
    }
    tier->last_band = bands.size();
}

void BandPlan::find_seeds(PlaneIndex planes, std::size_t reaching_count, const Parallel& parallel) {
    constexpr std::size_t seed_work = 4;  // its place waits for memory
    band_of_.resize(planes);
    for (std::uint32_t b = 0; b < bands.size(); ++b) {
        std::fill(band_of_.begin() + bands[b].first, band_of_.begin() + bands[b].last, b);
    }
    const auto each_seed = [&](std::size_t begin, std::size_t end, const auto& use) {
        StopPace pace;
        pace.follow(parallel.stop());
        for (const Reaching& triangle : reaching.span().subspan(begin, end - begin)) {
            const std::uint32_t first = band_of_[triangle.first] + 1;
            const std::uint32_t last = band_of_[triangle.last - 1];
            for (std::uint32_t b = first; b <= last; ++b) {
                use(b, triangle.record);
            }
            pace.spend(1 + seed_work * (last + 1 - first));
        }
    };
    distribute(reaching_count, bands.size(), parallel, each_seed, seeds);
    if (tiers.size() == 1) {
        give_back_many(reaching);
    }
}

void BandPlan::forget_many_seeds() {
    give_back_many(reaching);
    give_back_many(seeds.items);
}

}  // namespace lamella
