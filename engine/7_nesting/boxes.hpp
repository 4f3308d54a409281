// Bounding boxes in groups of lanes, and a tree of them for the sweep over starts.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <memory_resource>
#include <vector>

#include "lamella/grid.hpp"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace lamella::nesting {

/// Four boxes that begin left of any point asked for: what remains to be compared.
struct BoxQuad {
    static constexpr std::int32_t nowhere = std::numeric_limits<std::int32_t>::min();
    alignas(16) std::int32_t max_x[4] = {nowhere, nowhere, nowhere, nowhere};
    alignas(16) std::int32_t min_y[4] = {};
    alignas(16) std::int32_t max_y[4] = {};

    void set(std::size_t lane, Point box_min, Point box_max) noexcept {
        max_x[lane] = box_max.x;
        min_y[lane] = box_min.y;
        max_y[lane] = box_max.y;
    }
    /// Bit i: `point` lies strictly inside box i.
    unsigned around(Point point) const noexcept {
#if defined(__SSE2__)
        const __m128i x = _mm_set1_epi32(point.x);
        const __m128i y = _mm_set1_epi32(point.y);
        const auto load = [](const std::int32_t* lanes) { return _mm_load_si128(reinterpret_cast<const __m128i*>(lanes)); };
        const __m128i inside_y = _mm_and_si128(_mm_cmpgt_epi32(y, load(min_y)), _mm_cmpgt_epi32(load(max_y), y));
        const __m128i inside = _mm_and_si128(_mm_cmpgt_epi32(load(max_x), x), inside_y);
        return static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(inside)));
#else
        unsigned bits = 0;
        for (int i = 0; i < 4; ++i) {
            bits |= static_cast<unsigned>(max_x[i] > point.x && min_y[i] < point.y && point.y < max_y[i]) << i;
        }
        return bits;
#endif
    }
};

/// The boxes that begin left of a line which sweeps towards +x, 16 to a node, in the order of their y: nodes know the extent
/// of what has been added below them and the last of it. Boxes that lie apart are told apart by y, those passed by the line
/// by their max_x, and in deep nests the last added is the innermost.
class BoxTree {
public:
    explicit BoxTree(std::pmr::memory_resource* memory) : nodes_(memory), levels_(memory) {}

    /// Empty, with room for `count` boxes at places 0 to count - 1. Throws std::bad_alloc.
    void reset(std::uint32_t count);
    /// Adds a box at `place`; `rank` ascends from call to call.
    void add(std::uint32_t place, std::int32_t rank, Point box_min, Point box_max) noexcept;
    /// The largest rank whose box lies strictly around `point`, or -1.
    std::int32_t last_around(Point point) const noexcept;
    /// Appends to `found` all ranks whose boxes lie strictly around `point`, in an unspecified but reproducible order.
    /// Looks at `patience` nodes at most, and takes off those looked at.
    void all_around(Point point, std::size_t& patience, std::pmr::vector<std::int32_t>& found) const;

private:
    static constexpr std::uint32_t quads = 4;
    static constexpr std::uint32_t fan_out = 4 * quads;
    struct Node {
        BoxQuad boxes[quads];
        std::int32_t last[fan_out];  // rank of the box, or the last rank below
        std::uint32_t latest;        // the slot where `last` is largest
    };
    struct Level {
        std::uint32_t first_node;
        std::uint32_t nodes;
    };
    const Node& node_at(std::size_t level, std::uint32_t node) const noexcept {
        return nodes_[levels_[level].first_node + node];
    }
    static unsigned slots_around(const Node& node, Point point) noexcept;
    static std::uint32_t latest_slot(const Node& node, unsigned slots) noexcept;
    void search_last(std::size_t level, std::uint32_t node, Point point, std::int32_t& best) const noexcept;
    void search_all(std::size_t level, std::uint32_t node, Point point, std::size_t& patience,
                    std::pmr::vector<std::int32_t>& found) const;

    std::pmr::vector<Node> nodes_;
    std::pmr::vector<Level> levels_;  // from the leaves up
};

}  // namespace lamella::nesting
