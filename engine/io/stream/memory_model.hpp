// What slicing a range of layers takes, and which ranges fit a budget.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/stream/triangle_file.hpp"
#include "io/stream/triangle_store.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// Layers that are cut in one call.
struct LayerSpan {
    PlaneIndex begin = 0;
    PlaneIndex end = 0;
    int threads = 1;
    std::uint64_t triangles = 0;  ///< that planes of the range cut
};

/// Measured: see tests/input/test_slice_file.cpp and test_slice_ply.cpp, which holds the engine's memory against it.
class MemoryModel {
public:
    MemoryModel(std::uint64_t budget, int threads, const TriangleFile& file);

    std::uint64_t budget() const noexcept { return budget_; }
    /// Whether what stays in memory leaves anything of it.
    bool holds_resident() const noexcept { return free_ > 0; }
    /// Triangles that are read at once.
    std::size_t chunk_triangles() const noexcept { return chunk_of(free_); }
    /// From here on the tables of so many planes count.
    void set_planes(std::uint64_t planes) noexcept { planes_ = planes; }
    /// Triangles that may be kept so that as many can be cut at once and a part is left for the sweep.
    std::size_t well_kept() const noexcept { return kept_within(7, 8, true); }
    /// Triangles that may be kept so that a quarter of them or so can be cut at once.
    std::size_t most_kept() const noexcept { return kept_within(3, 4, false); }

    /// The longest range from plane `begin` up to at most `end` that fits while `kept` triangles are held, or, where that is
    /// 0, those of the range alone; on as many threads as fit. Nothing if not even one layer does.
    std::optional<LayerSpan> longest(const PlaneCounts& counts, PlaneIndex begin, PlaneIndex end, std::uint64_t kept) const;

    /// The least budget for `triangles` in the widest layer, one of one layer being cut at a time.
    std::uint64_t least_budget(std::uint64_t widest) const noexcept;

private:
    std::size_t kept_within(std::uint64_t parts, std::uint64_t of, bool cut_at_once) const noexcept;
    std::size_t chunk_of(std::uint64_t budget) const noexcept;
    std::uint64_t fixed_of(std::uint64_t budget) const noexcept;
    std::uint64_t cutting(const LayerSpan& span, std::uint64_t segments, std::uint64_t widest) const noexcept;

    std::uint64_t budget_;
    std::uint64_t threads_;
    std::uint64_t file_triangles_;
    std::uint64_t resident_;        ///< bytes of vertices
    std::uint64_t free_;            ///< what they leave of the budget
    std::uint64_t chunk_triangle_;  ///< bytes that are held for each triangle that is read at once
    std::uint64_t planes_ = 0;
};

}  // namespace lamella
