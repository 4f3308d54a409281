#include "io/stream/memory_model.hpp"

#include <algorithm>

#include "io/stream/file_box.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/grid/blocks.hpp"

namespace lamella {

namespace {

// Bytes that are held,
constexpr std::uint64_t a_chunk_triangle = sizeof(CrossedTriangle) + 2;  // a thread, and a buffer
constexpr std::uint64_t a_chunk = sizeof(FileChunk) + sizeof(Bounds);
constexpr std::uint64_t a_plane = 112;          // the planes of the whole, twice, their heights, and lists
constexpr std::uint64_t a_plane_a_thread = 24;  // counts and stripes of the pass
constexpr std::uint64_t a_kept = sizeof(CrossedTriangle);
constexpr std::uint64_t a_cut = sizeof(Reaching) + sizeof(std::uint32_t);  // one that reaches beyond its band, and a seed
constexpr std::uint64_t an_active = 300;        // of the widest layer, a thread: slots, links, walks, points, contours
constexpr std::uint64_t a_segment = 20;         // points and contours that are put aside
constexpr std::uint64_t most_parcel = 3 << 19;  // a thread
constexpr std::uint64_t most_aside = std::uint64_t{160} << 20;
constexpr std::uint64_t a_thread = 256 << 10;  // bands, kernels, first growth of arrays

/// How much bands put aside depends on the threads' pace: ranges are planned for a little less.
constexpr std::uint64_t planned_share(std::uint64_t budget) noexcept {
    return budget - budget / 24;
}

}  // namespace

MemoryModel::MemoryModel(std::uint64_t budget, int threads, const TriangleFile& file)
    : budget_(budget),
      threads_(static_cast<std::uint64_t>(threads)),
      file_triangles_(file.triangles()),
      resident_(file.resident_bytes()),
      free_(budget_ - std::min(budget_, resident_)),
      chunk_triangle_(a_chunk_triangle + file.buffer_bytes()) {}

std::size_t MemoryModel::chunk_of(std::uint64_t budget) const noexcept {
    constexpr std::uint64_t most = 8192;
    const std::uint64_t share = budget / (16 * threads_ * chunk_triangle_) / block_triangles * block_triangles;
    return static_cast<std::size_t>(std::clamp<std::uint64_t>(share, block_triangles, most));
}

std::uint64_t MemoryModel::fixed_of(std::uint64_t budget) const noexcept {
    const std::uint64_t chunk = chunk_of(budget);
    return threads_ * (chunk_triangle_ * chunk + a_thread) + (file_triangles_ / chunk + 1) * a_chunk +
           planes_ * (a_plane + a_plane_a_thread * (threads_ + 1));
}

/// In `parts` of `of` of what the tables leave.
std::size_t MemoryModel::kept_within(std::uint64_t parts, std::uint64_t of, bool cut_at_once) const noexcept {
    const std::uint64_t fixed = fixed_of(free_);
    const std::uint64_t left = free_ > fixed ? free_ - fixed : 0;
    const std::uint64_t least = 4 * threads_ * chunk_triangles();  // with which the pass can go on
    const std::uint64_t fit = left / of * parts / (a_kept + (cut_at_once ? a_cut + a_segment : 0));
    return static_cast<std::size_t>(std::min(file_triangles_ + least, std::max(least, fit)));
}

/// Of one call of the engine.
std::uint64_t MemoryModel::cutting(const LayerSpan& span, std::uint64_t segments, std::uint64_t widest) const noexcept {
    const auto threads = static_cast<std::uint64_t>(span.threads);
    const std::uint64_t parcels = threads * std::min(most_parcel, a_segment * segments);
    const std::uint64_t aside = threads > 1 ? std::min(most_aside, a_segment * segments) : 0;
    return a_cut * span.triangles + an_active * widest * threads + parcels + aside;
}

std::optional<LayerSpan> MemoryModel::longest(const PlaneCounts& counts, PlaneIndex begin, PlaneIndex end,
                                              std::uint64_t kept) const {
    const std::uint64_t reaching = counts.reaching_into(begin);
    const std::uint64_t fixed = fixed_of(free_);
    for (int threads = static_cast<int>(threads_); threads >= 1; threads /= 2) {
        LayerSpan span{begin, begin, threads, reaching};
        std::uint64_t active = reaching + counts.ended(begin);
        std::uint64_t segments = 0;
        std::uint64_t widest = 0;
        for (PlaneIndex plane = begin; plane < end; ++plane) {
            LayerSpan longer = span;
            longer.end = plane + 1;
            longer.triangles += counts.starting(plane);
            active += counts.starting(plane);
            active -= counts.ended(plane);
            segments += active;
            widest = std::max(widest, active);
            const std::uint64_t held = a_kept * std::max(kept, longer.triangles);
            if (fixed + held + cutting(longer, segments, widest) > planned_share(free_)) {
                break;
            }
            span = longer;
        }
        if (span.end > begin) {
            return span;
        }
    }
    return std::nullopt;
}

std::uint64_t MemoryModel::least_budget(std::uint64_t widest) const noexcept {
    const std::uint64_t needed = a_kept * widest + cutting({0, 1, 1, widest}, widest, widest);
    std::uint64_t budget = needed;
    while (planned_share(budget) < needed + fixed_of(budget)) {
        budget += budget / 32 + 4096;
    }
    return budget + resident_;
}

}  // namespace lamella
