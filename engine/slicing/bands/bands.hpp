// The planes cut into z-bands, each of which one thread sweeps (Algorithm 1), and for each band its seeds: the triangles
// that reach into it from below.
//
//     planes      0 1 2 3 | 4 5 6 7 | 8 9 ...
//     triangle      [-----------]            in the list of plane 1, and a seed of the second band
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "base/distribute.hpp"
#include "base/vector.hpp"
#include "slicing/buckets/triangle_source.hpp"

namespace lamella {

struct Band {
    PlaneIndex first;
    PlaneIndex last;  ///< one past
    std::uint64_t segments;
    bool wide = false;  ///< a single plane that all threads work on together
};

/// Bands whose records are in memory together.
struct Tier {
    PlaneRange planes;
    std::uint64_t records;  ///< of triangles that these cut
    std::size_t first_band = 0;
    std::size_t last_band = 0;  ///< one past
};

struct BandPlan {
private:
    const Memory* memory_;

public:
    explicit BandPlan(const Memory* memory) : memory_(memory) {}

    Vector<Band> bands{memory_};
    Vector<Tier> tiers{memory_};           ///< all bands, in their order
    Vector<PlaneIndex> band_end{memory_};  ///< k + 1: the end of each plane's band, and k
    Array<Reaching> reaching{memory_};  ///< room for the triangles that scatter_triangles() finds to reach beyond their band
    Distributed<std::uint32_t> seeds{memory_};  ///< indices of records, by band

    /// Of a tier.
    std::uint64_t most_records() const noexcept {
        const auto fewer = [](const Tier& a, const Tier& b) { return a.records < b.records; };
        return tiers.empty() ? 0 : std::max_element(tiers.begin(), tiers.end(), fewer)->records;
    }

    /// Cuts the planes into bands of about equal work if `asked_planes` is 0, and ends a band where so many of its edges
    /// have ended that passing over their slots would cost more than to begin anew. Otherwise bands have `asked_planes`
    /// planes. A band of more than one plane has at most `most_segments`. Both limits are doubled until there are at most
    /// 2^21 seeds, or at most as many as crossed triangles. Makes `band_end`, and makes `reaching` large enough. O(k) for
    /// each try. Tiers are thirds of the records, where few reach from one into the next and few blocks are read twice.
    void cut(const Buckets& buckets, PlaneIndex planes, int asked_planes, int threads,
             std::uint64_t most_segments = no_limit);
    static constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();

    /// Finds every band's seeds in the first `reaching_count` of `reaching`. O(k + reaching_count + seeds); a seed has at
    /// least one segment in its band. Throws Stopped.
    void find_seeds(PlaneIndex planes, std::size_t reaching_count, const Parallel& parallel);

    /// Releases the memory of the seeds if it is large. To be called when all bands are swept.
    void forget_many_seeds();

private:
    void cut_once(const Buckets& buckets, PlaneIndex planes, std::uint64_t most_planes, int threads,
                  std::uint64_t most_segments);

    void cut_tiers(const Buckets& buckets, PlaneIndex planes, bool asked);

    Vector<std::uint32_t> band_of_{memory_};  // of each plane; scratch of find_seeds()
};

}  // namespace lamella
