#include "slicing/bands/bands.hpp"

#include <algorithm>
#include <numeric>

#include "base/parallel.hpp"
#include "base/vector.hpp"

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

/// All threads work on a plane together if it is large, and either a sixteenth of all segments or mostly of triangles that
/// enter there. Keeping links from plane to plane gains little there, and bands would leave threads without work.
bool is_wide(const Buckets& buckets, PlaneIndex plane) noexcept {
    constexpr std::uint32_t large = 1 << 18;
    constexpr std::uint64_t few = 16;
    const std::uint64_t segments = buckets.segments[plane];
    const std::uint64_t entering = buckets.list_begin[plane + 1] - buckets.list_begin[plane];
    return segments >= large && (few * segments >= buckets.segment_count || 2 * entering >= segments);
}

std::uint64_t work_of(const Buckets& buckets, PlaneIndex plane) noexcept {
    return buckets.segments[plane] + segments_per_entry * (buckets.list_begin[plane + 1] - buckets.list_begin[plane]);
}

/// The number of triangles that the plane cuts and that entered below it: seeds of a band that begins with it.
std::uint64_t reaching_into(const Buckets& buckets, PlaneIndex plane) noexcept {
    return buckets.segments[plane] - (buckets.list_begin[plane + 1] - buckets.list_begin[plane]);
}

/// At most so many seeds where bands are cut smaller than their work asks for.
std::uint64_t most_seeds_of(const Buckets& buckets, PlaneIndex planes) noexcept {
    constexpr std::uint64_t few_seeds = 1 << 21;
    return std::max<std::uint64_t>(buckets.list_begin[planes] - buckets.list_begin[0], few_seeds);
}

/// See BandPlan::cut().
std::size_t planes_a_band(const Buckets& buckets, PlaneIndex planes, std::size_t asked) {
    const std::uint64_t most_seeds = most_seeds_of(buckets, planes);
    for (;; asked *= 2) {
        std::uint64_t seeds = 0;
        for (std::size_t plane = asked; plane < planes; plane += asked) {
            seeds += reaching_into(buckets, static_cast<PlaneIndex>(plane));
        }
        if (seeds <= most_seeds) {
            return asked;
        }
    }
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
    const std::size_t fixed = asked_planes > 0 ? planes_a_band(buckets, planes, static_cast<std::size_t>(asked_planes)) : 0;
    const auto has_many_seeds = [&] {
        const auto add = [&](std::uint64_t sum, const Band& band) { return sum + reaching_into(buckets, band.first); };
        return std::accumulate(bands.begin(), bands.end(), std::uint64_t{0}, add) > most_seeds_of(buckets, planes);
    };
    cut_once(buckets, planes, fixed, threads, most_segments);
    while (most_segments < buckets.segment_count && has_many_seeds()) {
        most_segments *= 2;
        cut_once(buckets, planes, fixed, threads, most_segments);
    }
    make_room(buckets, planes);
}

void BandPlan::cut_once(const Buckets& buckets, PlaneIndex planes, std::size_t fixed, int threads,
                        std::uint64_t most_segments) {
    bands.clear();
    std::uint64_t all_work = 0;
    for (PlaneIndex plane = 0; plane < planes; ++plane) {
        all_work += work_of(buckets, plane);
    }
    // Several bands for each thread even out those that take longer; on one thread they only serve the cache.
    const std::uint64_t share = std::max(all_work / (16 * static_cast<std::uint64_t>(threads)) + 1, least_work);
    Band band{0, 0, 0, false};
    std::uint64_t work = 0;
    for (PlaneIndex plane = 0; plane < planes; ++plane) {
        const std::uint64_t enough = std::clamp(work_per_seed * buckets.segments[plane], std::min(share, least_segments),
                                                std::max(share, least_segments));
        const bool has_points = band.segments >= most_segments || buckets.segments[plane] > most_segments - band.segments;
        const bool full = has_points || (fixed > 0 ? plane - band.first >= fixed : work >= enough);
        const bool wide = is_wide(buckets, plane);
        if ((full || wide || band.wide) && plane > band.first) {
            bands.push_back(band);
            band = {plane, plane, 0, false};
            work = 0;
        }
        band.last = plane + 1;
        band.wide = wide;
        band.segments += buckets.segments[plane];
        work += work_of(buckets, plane);
    }
    if (planes > 0) {
        bands.push_back(band);
    }
}

void BandPlan::make_room(const Buckets& buckets, PlaneIndex planes) {
    band_end.assign(std::size_t{planes} + 1, planes);
    std::size_t most_reaching = 0;
    for (const Band& band : bands) {
        std::fill(band_end.begin() + band.first, band_end.begin() + band.last, band.last);
        most_reaching += reaching_into(buckets, band.first);
    }
    reaching.resize_discarding(std::min<std::size_t>(most_reaching, buckets.list_begin[planes] - buckets.list_begin[0]));
}

void BandPlan::find_seeds(PlaneIndex planes, std::size_t reaching_count, const StopCheck& stop) {
    constexpr std::size_t seed_work = 4;  // its place waits for memory
    StopPace pace;
    pace.follow(stop);
    const std::span<const Reaching> found{reaching.data(), reaching_count};
    seed_begin.assign(bands.size() + 1, 0);
    seeds.resize_discarding(0);
    if (found.empty()) {
        band_of_.clear();
        change_.clear();
        next_seed_.clear();
        give_back_many(reaching);
        return;
    }
    band_of_.resize(planes);
    for (std::uint32_t b = 0; b < bands.size(); ++b) {
        std::fill(band_of_.begin() + bands[b].first, band_of_.begin() + bands[b].last, b);
    }
    // Count, prefix sum, scatter. A triangle is counted from the band after its first to its last.
    change_.assign(bands.size() + 1, 0);
    pace.in_stretches(0, found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (const Reaching& triangle : found.subspan(begin, end - begin)) {
            ++change_[band_of_[triangle.first] + 1];
            --change_[band_of_[triangle.last - 1] + 1];
        }
    });
    std::int64_t seeds_here = 0;
    for (std::size_t b = 0; b < bands.size(); ++b) {
        seeds_here += change_[b];
        seed_begin[b + 1] = seed_begin[b] + static_cast<std::uint64_t>(seeds_here);
    }
    seeds.resize_discarding(seed_begin.back());
    next_seed_ = seed_begin;
    pace.in_stretches(0, found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (const Reaching& triangle : found.subspan(begin, end - begin)) {
            const std::uint32_t last = band_of_[triangle.last - 1];
            for (std::uint32_t b = band_of_[triangle.first] + 1; b <= last; ++b) {
                seeds[next_seed_[b]++] = triangle.record;
            }
            pace.spend(seed_work * (last - band_of_[triangle.first]));
        }
    });
    give_back_many(reaching);
}

void BandPlan::trim() {
    fit(bands);
    fit(band_end);
    fit(reaching);
    fit(seed_begin);
    fit(seeds);
    fit(band_of_);
    fit(change_);
    fit(next_seed_);
}

void BandPlan::forget_many_seeds() {
    give_back_many(seeds);
}

}  // namespace lamella
