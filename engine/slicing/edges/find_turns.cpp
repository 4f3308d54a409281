#include "slicing/edges/find_turns.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "base/numbers.hpp"

namespace lamella {

namespace {

/// The directions in which a path has gone since it last turned, 0 if neither way.
class Heading {
public:
    bool turns_at(Point from, Point to) noexcept {
        const int right = sign_of(std::int64_t{to.x} - from.x);
        const int up = sign_of(std::int64_t{to.y} - from.y);
        const bool turns = right * right_ < 0 || up * up_ < 0;
        right_ = right != 0 || turns ? right : right_;
        up_ = up != 0 || turns ? up : up_;
        return turns;
    }
    bool is_slanting() const noexcept { return right_ != 0 && up_ != 0; }
    /// Bit 0: right, bit 1: up. Precondition: slanting.
    unsigned bits() const noexcept { return (right_ > 0 ? 1U : 0U) | (up_ > 0 ? 2U : 0U); }
    void set(unsigned bits) noexcept {
        right_ = (bits & 1U) != 0 ? 1 : -1;
        up_ = (bits & 2U) != 0 ? 1 : -1;
    }

private:
    int right_ = 0;
    int up_ = 0;
};

std::size_t find_turns_portable(const Point* points, std::size_t edges, std::uint32_t* out) {
    std::size_t found = 0;
    Heading heading;
    for (std::size_t e = 0; e < edges; ++e) {
        out[found] = static_cast<std::uint32_t>(e);
        found += heading.turns_at(points[e], points[e + 1]) ? 1 : 0;
    }
    return found;
}

#ifdef LAMELLA_X86_FORMS

LAMELLA_AVX2_INLINE __m256i lanes_at(const void* at) {
    return _mm256_loadu_si256(static_cast<const __m256i*>(at));
}
LAMELLA_AVX2_INLINE unsigned greater(__m256i a, __m256i b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b))));
}

/// Two bits an edge, of turn_lanes edges: whether x ascends, and y; whether it descends.
struct Directions {
    std::uint64_t ascends = 0;
    std::uint64_t descends = 0;
};

LAMELLA_AVX2_INLINE Directions directions_of(const Point* points) {
    constexpr std::size_t step = 4;
    Directions all;
    for (std::size_t e = 0; e < turn_lanes; e += step) {
        const __m256i here = lanes_at(points + e);
        const __m256i next = lanes_at(points + e + 1);
        all.ascends |= std::uint64_t{greater(next, here)} << (2 * e);
        all.descends |= std::uint64_t{greater(here, next)} << (2 * e);
    }
    return all;
}

/// The edges [0, edges) that follow one another in both directions: writes `first` + edge for those before which the path
/// turns. Precondition: `heading` is slanting, as are all these edges.
LAMELLA_AVX2_INLINE std::size_t write_turns(std::uint64_t ascends, std::size_t edges, Heading& heading, std::size_t first,
                                            std::uint32_t* out) {
    constexpr std::uint64_t bits_of_x = 0x5555'5555'5555'5555;
    const std::uint64_t used = ~std::uint64_t{0} >> (64 - 2 * edges);
    const std::uint64_t changes = (ascends ^ (ascends << 2 | heading.bits())) & used;
    std::size_t found = 0;
    for (std::uint64_t turns = (changes | changes >> 1) & bits_of_x; turns != 0; turns &= turns - 1) {
        out[found++] = static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(std::countr_zero(turns)) / 2;
    }
    heading.set(static_cast<unsigned>(ascends >> (2 * edges - 2)) & 3U);
    return found;
}

/// Edges along an axis are taken one by one, with the seven beside them.
LAMELLA_AVX2 std::size_t find_turns_avx2(const Point* points, std::size_t edges, std::uint32_t* out) {
    constexpr std::size_t step = 8;
    std::size_t found = 0;
    Heading heading;
    if (edges > 0) {
        heading.turns_at(points[0], points[1]);
    }
    for (std::size_t e = 0; e < edges; e += turn_lanes) {
        const Directions directions = directions_of(points + e);
        const std::size_t count = std::min(edges - e, turn_lanes);
        const std::uint64_t upright = ~(directions.ascends | directions.descends) & ~std::uint64_t{0} >> (64 - 2 * count);
        if (upright == 0 && heading.is_slanting()) {
            found += write_turns(directions.ascends, count, heading, e, out + found);
            continue;
        }
        for (std::size_t i = 0; i < count; i += step) {
            const std::size_t few = std::min(count - i, step);
            if ((upright >> (2 * i) & 0xFFFF) == 0 && heading.is_slanting()) {
                found += write_turns(directions.ascends >> (2 * i), few, heading, e + i, out + found);
                continue;
            }
            for (std::size_t k = e + i; k < e + i + few; ++k) {
                out[found] = static_cast<std::uint32_t>(k);
                found += heading.turns_at(points[k], points[k + 1]) ? 1 : 0;
            }
        }
    }
    return found;
}

#endif

}  // namespace

std::span<const Form<FindTurns>> find_turns_forms() noexcept {
    static constexpr Form<FindTurns> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx2, find_turns_avx2},
#endif
        {InstructionSet::portable, find_turns_portable}};
    return forms;
}

}  // namespace lamella
