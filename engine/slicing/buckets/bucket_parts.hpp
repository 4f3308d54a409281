// What counting and scattering share, whatever they read triangles from: the parts that threads work on, their counters, and
// the prefix sums between the two reads.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/grid/blocks.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// So long a part of the mesh is gone through in a millisecond or so, after which the host is asked whether to end.
inline constexpr std::size_t blocks_between_stops = 512;

/// Triangles in as many parts as there are threads, cut between blocks.
struct BucketParts {
    std::size_t triangles;
    std::size_t count;

    BucketParts(std::size_t triangle_count, const Parallel& parallel)
        : triangles(triangle_count),
          count(std::min<std::size_t>(static_cast<std::size_t>(parallel.threads()), (triangle_count >> 12) + 1)) {}
    std::size_t blocks() const noexcept { return block_count(triangles); }
    std::size_t begin_block(std::size_t part) const noexcept { return blocks() * part / count; }
};

/// Calls use(part, begin, end) for every block of `parts`: parts by different threads. A part of the triangles mostly has
/// the vertices of the same part of the vertices, so that what a core has written, it reads again.
template <class Use>
void for_each_block(const BucketParts& parts, const Parallel& parallel, Use use) {
    parallel.run(parts.count, [&](std::size_t part, int) {
        for (std::size_t block = parts.begin_block(part); block < parts.begin_block(part + 1); ++block) {
            if (block % blocks_between_stops == 0) {
                parallel.stop_if_asked();
            }
            const std::size_t begin = block * block_triangles;
            use(part, begin, std::min(begin + block_triangles, parts.triangles));
        }
    });
}

/// Numbers of one part, two rows of them, by plane:
///
///     row          while counting                           while scattering
///     0            triangles that it cuts first             where the part's next such record goes
///     1            triangles that the plane below cut last  -
inline std::uint32_t* counters_of(Buckets& buckets, std::size_t part, std::size_t planes, std::size_t row) noexcept {
    return buckets.counters.data() + (2 * part + row) * (planes + 1);
}

struct PartCounts {
    std::uint32_t* starting;
    std::uint32_t* ended;

    PartCounts(Buckets& buckets, std::size_t part, std::size_t planes)
        : starting(counters_of(buckets, part, planes, 0)), ended(counters_of(buckets, part, planes, 1)) {}
};

struct PartCursors {
    std::uint32_t* next_record;

    PartCursors(Buckets& buckets, std::size_t part, std::size_t planes)
        : next_record(counters_of(buckets, part, planes, 0)) {}
};

/// Where parts write down triangles that reach beyond their bands: each part a buffer at a time, as cores that write side by
/// side wait for each other's cache lines.
class ReachingOutput {
public:
    ReachingOutput(std::span<Reaching> room, std::size_t parts) : room_(room), buffers_(parts) {}

    void add(std::size_t part, const Reaching& triangle) noexcept {
        Buffer& buffer = buffers_[part];
        if (buffer.count == buffer.triangles.size()) {
            write(buffer);
            buffer.count = 0;
        }
        buffer.triangles[buffer.count++] = triangle;
    }
    /// All parts are done. Returns how many triangles there are.
    std::size_t finish() noexcept {
        buffers_.for_each([this](const Buffer& buffer) { write(buffer); });
        return count_.load(std::memory_order_relaxed);
    }

private:
    struct Buffer {
        std::array<Reaching, 256> triangles;
        std::size_t count = 0;
    };

    void write(const Buffer& buffer) noexcept {
        const std::size_t at = count_.fetch_add(buffer.count, std::memory_order_relaxed);
        assert(at + buffer.count <= room_.size());
        std::copy_n(buffer.triangles.begin(), buffer.count, room_.begin() + static_cast<std::ptrdiff_t>(at));
    }

    std::span<Reaching> room_;
    PerWorker<Buffer> buffers_;
    std::atomic<std::size_t> count_ = 0;
};

/// Turns counts into where lists begin, for all and for each of `parts`, and sums up the segments.
void sum_up(const PlaneSet& planes, std::size_t parts, Buckets& buckets);

/// Makes room for the counters of `parts` and for what sum_up() gives.
void make_counters(const PlaneSet& planes, std::size_t parts, Buckets& buckets);

}  // namespace lamella
