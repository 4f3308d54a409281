// The memory that slicing a range of layers takes, and which ranges fit a budget.
#pragma once

#include <optional>

#include "io/stream/chunk_scan.hpp"
#include "slicing/bands/bands.hpp"

namespace lamella {

/// Layers that are cut in one call.
struct LayerSpan {
    PlaneIndex begin = 0;
    PlaneIndex end = 0;
    int threads = 1;
    std::uint64_t triangles = 0;  ///< that planes of the range cut
};

/// Measured: see tests/input/test_slice_file.cpp, which holds the engine's memory against it.
class MemoryModel {
public:
    MemoryModel(std::uint64_t budget, int threads, const TriangleFile& file)
        : budget_(budget),
          threads_(static_cast<std::uint64_t>(threads)),
          file_triangles_(file.triangles()),
          resident_(file.resident_bytes()),
          free_(budget_ - std::min(budget_, resident_)),
          chunk_triangle_(a_chunk_triangle + file.buffer_bytes()) {}

    std::uint64_t budget() const noexcept { return budget_; }
    /// True if what stays in memory leaves anything of it.
    bool holds_resident() const noexcept { return free_ > 0; }
    /// Triangles that are read at once.
    std::size_t chunk_triangles() const noexcept { return chunk_of(free_); }
    /// From here on the tables of so many planes count.
    void set_planes(std::uint64_t planes, bool with_slabs) noexcept {
        planes_ = planes;
        a_slab_ = with_slabs ? 2 * sizeof(Slab) : 0;
    }
    /// Triangles that may be kept so that as many can be cut at once and a part is left for the sweep.
    std::size_t well_kept() const noexcept { return kept_within(7, 8, true); }
    /// Triangles that may be kept so that a quarter of them or so can be cut at once.
    std::size_t most_kept() const noexcept { return kept_within(3, 4, false); }

    /// The longest range from plane `begin` up to at most `end` that fits while `kept` triangles are held, or, where that is
    /// 0, those of the range alone; on as many threads as fit. Nothing if not even one layer does.
    std::optional<LayerSpan> longest(const PlaneCounts& counts, PlaneIndex begin, PlaneIndex end, std::uint64_t kept) const {
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

    /// The least budget for `triangles` in the widest layer, one of one layer being cut at a time.
    std::uint64_t least_budget(std::uint64_t widest) const noexcept {
        const std::uint64_t needed = a_kept * widest + cutting({0, 1, 1, widest}, widest, widest);
        std::uint64_t budget = needed;
        while (planned_share(budget) < needed + fixed_of(budget)) {
            budget += budget / 32 + 4096;
        }
        return budget + resident_;
    }

private:
    // Bytes that are held,
    static constexpr std::uint64_t a_chunk_triangle = sizeof(CrossedTriangle) + 2;  // a thread, and a buffer
    static constexpr std::uint64_t a_chunk = sizeof(FileChunk) + sizeof(Bounds);
    static constexpr std::uint64_t a_plane = 112;          // the planes of the whole, twice, their heights, and lists
    static constexpr std::uint64_t a_plane_a_thread = 24;  // counts and stripes of the pass
    static constexpr std::uint64_t a_kept = sizeof(CrossedTriangle);
    static constexpr std::uint64_t a_cut =
        sizeof(Reaching) + sizeof(std::uint32_t);    // one that reaches beyond its band, and a seed
    static constexpr std::uint64_t an_active = 300;  // of the widest layer, a thread: slots, links, walks, points, contours
    static constexpr std::uint64_t a_segment = 20;   // points and contours that are put aside
    static constexpr std::uint64_t most_room = 3 << 19;  // a thread, for the layers that it hands over
    static constexpr std::uint64_t most_aside = std::uint64_t{160} << 20;
    static constexpr std::uint64_t a_thread = 256 << 10;  // bands, kernels, first growth of arrays

    /// How much bands put aside depends on the threads' pace: ranges are planned for a little less.
    static constexpr std::uint64_t planned_share(std::uint64_t budget) noexcept { return budget - budget / 24; }

    std::size_t chunk_of(std::uint64_t budget) const noexcept {
        constexpr std::uint64_t most = 8192;
        const std::uint64_t share = budget / (16 * threads_ * chunk_triangle_) / block_triangles * block_triangles;
        return static_cast<std::size_t>(std::clamp<std::uint64_t>(share, block_triangles, most));
    }

    std::uint64_t fixed_of(std::uint64_t budget) const noexcept {
        const std::uint64_t chunk = chunk_of(budget);
        return threads_ * (chunk_triangle_ * chunk + a_thread) + (file_triangles_ / chunk + 1) * a_chunk +
               planes_ * (a_plane + a_slab_ + a_plane_a_thread * (threads_ + 1));
    }

    /// In `parts` of `of` of what the tables leave.
    std::size_t kept_within(std::uint64_t parts, std::uint64_t of, bool cut_at_once) const noexcept {
        const std::uint64_t fixed = fixed_of(free_);
        const std::uint64_t left = free_ > fixed ? free_ - fixed : 0;
        const std::uint64_t least = 4 * threads_ * chunk_triangles();  // with which the pass can go on
        const std::uint64_t fit = left / of * parts / (a_kept + (cut_at_once ? a_cut + a_segment : 0));
        return static_cast<std::size_t>(std::min(file_triangles_ + least, std::max(least, fit)));
    }

    /// Bytes of one call of the engine.
    std::uint64_t cutting(const LayerSpan& span, std::uint64_t segments, std::uint64_t widest) const noexcept {
        const auto threads = static_cast<std::uint64_t>(span.threads);
        const std::uint64_t rooms = threads * std::min(most_room, a_segment * segments);
        const std::uint64_t aside = threads > 1 ? std::min(most_aside, a_segment * segments) : 0;
        return a_cut * span.triangles + an_active * widest * threads + rooms + aside;
    }

    std::uint64_t budget_;
    std::uint64_t threads_;
    std::uint64_t file_triangles_;
    std::uint64_t resident_;        ///< bytes of vertices
    std::uint64_t free_;            ///< what they leave of the budget
    std::uint64_t chunk_triangle_;  ///< bytes that are held for each triangle that is read at once
    std::uint64_t planes_ = 0;
    std::uint64_t a_slab_ = 0;  // given ones, twice
};

}  // namespace lamella
