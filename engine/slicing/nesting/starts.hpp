// The starts of a layer's rings in a line, and which of them lie within a box.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella::nesting {

inline constexpr std::uint32_t lanes = 16;

/// Bit i: low < values[i] < high, for sixteen values.
inline unsigned between(const std::int32_t* values, std::int32_t low, std::int32_t high) noexcept {
#if defined(__SSE2__)
    const __m128i lows = _mm_set1_epi32(low);
    const __m128i highs = _mm_set1_epi32(high);
    const auto four = [&](int i) {
        const __m128i value = _mm_loadu_si128(reinterpret_cast<const __m128i*>(values + i));
        return _mm_and_si128(_mm_cmpgt_epi32(value, lows), _mm_cmpgt_epi32(highs, value));
    };
    const __m128i eight = _mm_packs_epi32(four(0), four(4));
    return static_cast<unsigned>(_mm_movemask_epi8(_mm_packs_epi16(eight, _mm_packs_epi32(four(8), four(12)))));
#else
    unsigned bits = 0;
    for (int i = 0; i < static_cast<int>(lanes); ++i) {
        bits |= static_cast<unsigned>(low < values[i] && values[i] < high) << i;
    }
    return bits;
#endif
}

/// The starts by x, compared sixteen at a time. The window of a box is the range of starts whose x lies within the box's:
///
///     starts   [ . . . . . b . . . . . . e . . . ]      b: the first with x > min_x, e: the first with x >= max_x
///
/// Starts can be taken off; windows do not change.
class StartLine {
public:
    explicit StartLine(const Memory* memory) : xs_(memory), ys_(memory) {}

    struct Window {
        std::uint32_t begin;
        std::uint32_t end;
        bool occupied;  // a start in it lies between the y's asked for
        std::uint32_t steps() const noexcept { return (end - begin) / lanes + 1; }
    };

    /// Throws std::bad_alloc.
    void assign(std::span<const SortKey> by_start);
    /// The first start from `from` on that lies right of start `of`.
    std::uint32_t first_right_of(std::uint32_t of, std::uint32_t from) const noexcept;
    /// The starts from `begin` on that lie left of max_x.
    Window window(std::uint32_t begin, std::int32_t max_x, std::int32_t min_y, std::int32_t max_y) const noexcept;
    /// Appends the starts of the window that are left and lie between min_y and max_y to `found`.
    void find(const Window& window, std::int32_t min_y, std::int32_t max_y, Vector<std::uint32_t>& found) const;
    Point at(std::uint32_t start) const noexcept { return {xs_[start], ys_[start]}; }
    void take_off(std::uint32_t start) noexcept { ys_[start] = nowhere; }

private:
    static constexpr std::int32_t nowhere = std::numeric_limits<std::int32_t>::min();
    Vector<std::int32_t> xs_, ys_;  // `lanes` more than there are starts
};

}  // namespace lamella::nesting
