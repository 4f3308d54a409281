#include "slicing/contours/kernels.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "base/numbers.hpp"
#include "base/system/processor.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella {

namespace {

// --- Portable

void pierce_portable(const EdgeArrays& edges, std::int32_t z, std::size_t count, Point* points) {
    for (std::size_t e = 0; e < count; ++e) {
        const auto rise = static_cast<double>(std::int64_t{z} - edges.z[e]);
        points[e] = {edges.x[e] + round_move(edges.slope_x[e] * rise), edges.y[e] + round_move(edges.slope_y[e] * rise)};
    }
}

RingFacts trace_portable(const Point* points, const std::uint32_t* slots, std::size_t count, Point* ring) {
    return facts_of(count, [=](std::size_t i) { return ring[i] = points[slots[i]]; });
}

std::size_t select_equal_portable(const std::uint32_t* values, std::size_t count, std::uint32_t value,
                                  std::uint32_t* indices) {
    std::size_t found = 0;
    for (std::size_t i = 0; i < count; ++i) {
        indices[found] = static_cast<std::uint32_t>(i);
        found += values[i] == value ? 1 : 0;
    }
    return found;
}

constexpr Kernels portable{pierce_portable, trace_portable, select_equal_portable};

#if defined(LAMELLA_X86_FORMS) || defined(LAMELLA_NEON_FORMS)

/// True if all differences within the box fit the 32-bit halves that vector multiplication takes.
bool fits_halves(const RingFacts& facts) {
    return width_of(facts.box) <= INT32_MAX && height_of(facts.box) <= INT32_MAX;
}

/// The points from `whole` on, which do not fill a vector that another follows.
inline void add_rest(const Point* points, const std::uint32_t* slots, std::size_t whole, std::size_t count, Point* ring,
                     RingFacts& facts) {
    const Point first = points[slots[0]];
    Point last = points[slots[whole > 0 ? whole - 1 : count - 1]];
    for (std::size_t i = whole; i < count; ++i) {
        const Point point = points[slots[i]];
        const Point next = i + 1 < count ? points[slots[i + 1]] : first;
        ring[i] = point;
        facts.box.include({point, point});
        facts.has_repeats = facts.has_repeats || point == next;
        facts.twice_area += Int128{std::int64_t{point.x} - first.x} * (std::int64_t{next.y} - last.y);
        last = point;
    }
}

#endif
#ifdef LAMELLA_X86_FORMS

// --- AVX2: four edges, four points a step

LAMELLA_AVX2 __m128i four_ints(const std::int32_t* at) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at));
}

/// Where four edges pierce, along one axis.
LAMELLA_AVX2 __m128i pierce_four(const std::int32_t* from, const double* slopes, __m256d rise) {
    const __m256d room = _mm256_set1_pd(tie_room);
    const __m256d by = _mm256_add_pd(_mm256_mul_pd(_mm256_loadu_pd(slopes), rise), room);
    return _mm_add_epi32(four_ints(from), _mm256_cvtpd_epi32(_mm256_sub_pd(by, room)));
}

LAMELLA_AVX2 void pierce_avx2(const EdgeArrays& edges, std::int32_t z, std::size_t count, Point* points) {
    const __m128i plane = _mm_set1_epi32(z);
    for (std::size_t e = 0; e < count; e += 4) {
        const __m256d rise = _mm256_cvtepi32_pd(_mm_sub_epi32(plane, four_ints(edges.z + e)));
        const __m128i xs = pierce_four(edges.x + e, edges.slope_x + e, rise);
        const __m128i ys = pierce_four(edges.y + e, edges.slope_y + e, rise);
        auto* out = reinterpret_cast<__m128i*>(points + e);
        _mm_storeu_si128(out, _mm_unpacklo_epi32(xs, ys));
        _mm_storeu_si128(out + 1, _mm_unpackhi_epi32(xs, ys));
    }
}

LAMELLA_AVX2 __m256i load_points(const Point* at) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
}

/// Folds four lanes of lowest and highest points and of sums into `facts`.
LAMELLA_AVX2 void finish_facts(RingFacts& facts, __m256i low, __m256i high, __m256i low_sum, __m256i high_sum) {
    const auto point = [](__m128i lane) { return bits_as<Point>(_mm_cvtsi128_si64(lane)); };
    const __m128i low2 = _mm_min_epi32(_mm256_castsi256_si128(low), _mm256_extracti128_si256(low, 1));
    const __m128i high2 = _mm_max_epi32(_mm256_castsi256_si128(high), _mm256_extracti128_si256(high, 1));
    facts.box.low = point(_mm_min_epi32(low2, _mm_unpackhi_epi64(low2, low2)));
    facts.box.high = point(_mm_max_epi32(high2, _mm_unpackhi_epi64(high2, high2)));
    const __m128i low_sum2 = _mm_add_epi64(_mm256_castsi256_si128(low_sum), _mm256_extracti128_si256(low_sum, 1));
    const __m128i high_sum2 = _mm_add_epi64(_mm256_castsi256_si128(high_sum), _mm256_extracti128_si256(high_sum, 1));
    const std::int64_t low_half = _mm_cvtsi128_si64(_mm_add_epi64(low_sum2, _mm_unpackhi_epi64(low_sum2, low_sum2)));
    const std::int64_t high_half = _mm_cvtsi128_si64(_mm_add_epi64(high_sum2, _mm_unpackhi_epi64(high_sum2, high_sum2)));
    facts.twice_area = (Int128{high_half} << 32) + Int128{static_cast<std::uint64_t>(low_half)};
}

/// Points [at, at + 4) of the ring.
LAMELLA_AVX2 __m256i gather_four(const Point* points, const std::uint32_t* slots) {
    const __m128i at = _mm_loadu_si128(reinterpret_cast<const __m128i*>(slots));
    return _mm256_i32gather_epi64(reinterpret_cast<const long long*>(points), at, sizeof(Point));
}

/// The first point with the given x, from `from` on, or count.
LAMELLA_AVX2 std::size_t find_x_avx2(const Point* ring, std::size_t from, std::size_t count, std::int32_t x) {
    const __m256i wanted = _mm256_set1_epi64x(static_cast<std::uint32_t>(x));
    for (; from + 4 <= count; from += 4) {
        const __m256i same = _mm256_cmpeq_epi32(load_points(ring + from), wanted);
        const int bits = _mm256_movemask_ps(_mm256_castsi256_ps(same)) & 0x55;  // the x halves
        if (bits != 0) {
            return from + static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(bits))) / 2;
        }
    }
    for (; from < count && ring[from].x != x; ++from) {
    }
    return from;
}

template <class FindX>
void find_smallest(const Point* ring, std::size_t count, RingFacts& facts, const FindX& find_x) {
    const std::int32_t x = facts.box.low.x;
    facts.smallest = find_x(ring, 0, count, x);
    for (std::size_t i = find_x(ring, facts.smallest + 1, count, x); i < count; i = find_x(ring, i + 1, count, x)) {
        if (ring[i].y <= ring[facts.smallest].y) {
            facts.many_smallest = ring[i].y == ring[facts.smallest].y;
            facts.smallest = facts.many_smallest ? facts.smallest : i;
        }
    }
}

/// Four points a step, as in trace_avx512, for rings that fill a vector; points left over are taken one by one. AVX2 has
/// no arithmetic shift of 64 bits: products are biased by 2^63 to be unsigned, and the bias is taken off at the end.
LAMELLA_AVX2 RingFacts trace_avx2(const Point* points, const std::uint32_t* slots, std::size_t count, Point* ring) {
    if (count < 8) {
        return trace_portable(points, slots, count, ring);
    }
    const Point first = points[slots[0]];
    const __m256i origin = _mm256_set1_epi64x(bits_as<std::int64_t>(first));
    const __m256i bias = _mm256_set1_epi64x(INT64_MIN);
    const __m256i low_half = _mm256_set1_epi64x(0xFFFFFFFF);
    __m256i low = origin;
    __m256i high = origin;
    __m256i repeats = _mm256_setzero_si256();
    __m256i low_sum = _mm256_setzero_si256();
    __m256i high_sum = _mm256_setzero_si256();
    __m256i before = _mm256_set1_epi64x(bits_as<std::int64_t>(points[slots[count - 1]]));
    __m256i here = gather_four(points, slots);
    const std::size_t whole = (count - 4) / 4 * 4;  // a whole vector follows each
    for (std::size_t i = 0; i < whole; i += 4) {
        const __m256i next = gather_four(points, slots + i + 4);
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(ring + i), here);
        // Neighbours by shifting registers: loading them back would wait for the stores.
        const __m256i after = _mm256_permute4x64_epi64(_mm256_blend_epi32(here, next, 0x03), 0x39);
        const __m256i previous = _mm256_permute4x64_epi64(_mm256_blend_epi32(here, before, 0xC0), 0x93);
        low = _mm256_min_epi32(low, here);
        high = _mm256_max_epi32(high, here);
        repeats = _mm256_or_si256(repeats, _mm256_cmpeq_epi64(here, after));
        const __m256i dy = _mm256_srli_epi64(_mm256_sub_epi32(after, previous), 32);
        const __m256i product = _mm256_xor_si256(_mm256_mul_epi32(_mm256_sub_epi32(here, origin), dy), bias);
        low_sum = _mm256_add_epi64(low_sum, _mm256_and_si256(product, low_half));
        high_sum = _mm256_add_epi64(high_sum, _mm256_srli_epi64(product, 32));
        before = here;
        here = next;
    }
    RingFacts facts{};
    facts.has_repeats = _mm256_testz_si256(repeats, repeats) == 0;
    finish_facts(facts, low, high, low_sum, high_sum);
    facts.twice_area -= Int128{whole} << 63;
    add_rest(points, slots, whole, count, ring, facts);
    find_smallest(ring, count, facts, find_x_avx2);
    return fits_halves(facts) ? facts : trace_portable(points, slots, count, ring);
}

/// Row `bits`: the positions of its set bits, lowest first.
///
///     bits 0b00100101    0 2 5 - - - - -
using BitPositions = std::array<std::array<std::uint8_t, 8>, 256>;

constexpr BitPositions make_bit_positions() {
    BitPositions positions{};
    for (std::size_t bits = 0; bits < positions.size(); ++bits) {
        std::size_t found = 0;
        for (std::uint8_t bit = 0; bit < 8; ++bit) {
            if ((bits >> bit & 1) != 0) {
                positions[bits][found++] = bit;
            }
        }
    }
    return positions;
}

constexpr BitPositions bit_positions = make_bit_positions();

LAMELLA_AVX2 std::size_t select_equal_avx2(const std::uint32_t* values, std::size_t count, std::uint32_t value,
                                           std::uint32_t* indices) {
    const __m256i wanted = _mm256_set1_epi32(static_cast<int>(value));
    std::size_t found = 0;
    std::size_t i = 0;
    for (; i + 8 <= count; i += 8) {
        const __m256i same = _mm256_cmpeq_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(values + i)), wanted);
        const auto bits = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(same)));
        // No branch on how many there are: it would often be mispredicted.
        const __m128i row = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(bit_positions[bits].data()));
        const __m256i selected = _mm256_add_epi32(_mm256_cvtepu8_epi32(row), _mm256_set1_epi32(static_cast<int>(i)));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(indices + found), selected);
        found += static_cast<std::size_t>(std::popcount(bits));
    }
    for (; i < count; ++i) {
        indices[found] = static_cast<std::uint32_t>(i);
        found += values[i] == value ? 1 : 0;
    }
    return found;
}

constexpr Kernels avx2{pierce_avx2, trace_avx2, select_equal_avx2};

// --- AVX-512: eight points a step

LAMELLA_AVX512 __m512i gather_eight(const Point* points, const std::uint32_t* slots) {
    const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(slots));
    return _mm512_mask_i32gather_epi64(_mm512_setzero_si512(), 0xFF, at, points, sizeof(Point));
}

LAMELLA_AVX512 __m256i lower_half(__m512i v) {
    return _mm512_maskz_extracti64x4_epi64(0xF, v, 0);
}
LAMELLA_AVX512 __m256i upper_half(__m512i v) {
    return _mm512_maskz_extracti64x4_epi64(0xF, v, 1);
}

/// As find_x_avx2(), eight points a step.
LAMELLA_AVX512 std::size_t find_x_avx512(const Point* ring, std::size_t from, std::size_t count, std::int32_t x) {
    const __m512i wanted = _mm512_set1_epi64(static_cast<std::uint32_t>(x));
    for (; from + 8 <= count; from += 8) {
        const unsigned bits = _mm512_mask_cmpeq_epi32_mask(0x5555, _mm512_loadu_si512(ring + from), wanted);  // the x halves
        if (bits != 0) {
            return from + static_cast<std::size_t>(std::countr_zero(bits)) / 2;
        }
    }
    return find_x_avx2(ring, from, count, x);
}

/// Eight points a step. Neighbours come from shifting the vectors before and after into this one, not from loading them
/// back from the ring, which would wait for the stores; x lies in the low half of each 64-bit lane and y in the high one:
///
///     before  [ .. .. .. .. .. .. .. a ]  here  [ b c d e f g h i ]  next  [ j .. .. .. .. .. .. .. ]
///     previous                                  [ a b c d e f g h ]
///     after                                     [ c d e f g h i j ]
LAMELLA_AVX512 RingFacts trace_avx512(const Point* points, const std::uint32_t* slots, std::size_t count, Point* ring) {
    const __m512i first = _mm512_set1_epi64(bits_as<std::int64_t>(points[slots[0]]));
    const __m512i low_half = _mm512_set1_epi64(0xFFFFFFFF);
    __m512i low = first;
    __m512i high = first;
    __m512i low_sum = _mm512_setzero_si512();
    __m512i high_sum = _mm512_setzero_si512();
    unsigned repeats = 0;
    __m512i before = _mm512_set1_epi64(bits_as<std::int64_t>(points[slots[count - 1]]));
    __m512i here = gather_eight(points, slots);
    for (std::size_t i = 0; i < count; i += 8) {
        const std::size_t left = count - i;
        const auto lanes = static_cast<__mmask8>(left >= 8 ? 0xFF : (1U << left) - 1);
        const __m512i next = left > 8 ? gather_eight(points, slots + i + 8) : first;
        here = _mm512_mask_blend_epi64(lanes, first, here);  // the first point follows the last
        _mm512_storeu_si512(ring + i, here);
        const __m512i previous = _mm512_maskz_alignr_epi64(0xFF, here, before, 7);
        const __m512i after = _mm512_maskz_alignr_epi64(0xFF, next, here, 1);
        low = _mm512_maskz_min_epi32(0xFFFF, low, here);
        high = _mm512_maskz_max_epi32(0xFFFF, high, here);
        repeats |= _mm512_mask_cmpeq_epi64_mask(lanes, here, after);
        const __m512i dy = _mm512_maskz_srli_epi64(0xFF, _mm512_sub_epi32(after, previous), 32);
        const __m512i product = _mm512_maskz_mul_epi32(0xFF, _mm512_sub_epi32(here, first), dy);
        low_sum = _mm512_add_epi64(low_sum, _mm512_and_si512(product, low_half));
        high_sum = _mm512_add_epi64(high_sum, _mm512_maskz_srai_epi64(0xFF, product, 32));
        before = here;
        here = next;
    }
    RingFacts facts{};
    facts.has_repeats = repeats != 0;
    finish_facts(facts, _mm256_min_epi32(lower_half(low), upper_half(low)),
                 _mm256_max_epi32(lower_half(high), upper_half(high)),
                 _mm256_add_epi64(lower_half(low_sum), upper_half(low_sum)),
                 _mm256_add_epi64(lower_half(high_sum), upper_half(high_sum)));
    find_smallest(ring, count, facts, find_x_avx512);
    return fits_halves(facts) ? facts : trace_portable(points, slots, count, ring);
}

LAMELLA_AVX512 std::size_t select_equal_avx512(const std::uint32_t* values, std::size_t count, std::uint32_t value,
                                               std::uint32_t* indices) {
    const __m512i wanted = _mm512_set1_epi32(static_cast<int>(value));
    __m512i index = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    std::size_t found = 0;
    const auto take = [&](__mmask16 same) LAMELLA_AVX512 {
        // No branch on whether there is one: it would often be mispredicted.
        _mm512_storeu_si512(indices + found, _mm512_maskz_compress_epi32(same, index));
        found += static_cast<std::size_t>(std::popcount(same));
        index = _mm512_add_epi32(index, _mm512_set1_epi32(16));
    };
    std::size_t i = 0;
    for (; i + 16 <= count; i += 16) {
        take(_mm512_cmpeq_epi32_mask(_mm512_loadu_si512(values + i), wanted));
    }
    const auto rest = static_cast<__mmask16>((1U << (count - i)) - 1);
    take(_mm512_mask_cmpeq_epi32_mask(rest, _mm512_maskz_loadu_epi32(rest, values + i), wanted));
    return found;
}

constexpr Kernels avx512{pierce_avx2, trace_avx512, select_equal_avx512};

#elif defined(LAMELLA_NEON_FORMS)

// --- NEON: two edges, four points a step. Its speed is not measured.

/// Where two edges pierce, along one axis.
int32x2_t pierce_two(const std::int32_t* from, const double* slopes, float64x2_t rise) {
    const float64x2_t room = vdupq_n_f64(tie_room);
    const float64x2_t by = vsubq_f64(vaddq_f64(vmulq_f64(vld1q_f64(slopes), rise), room), room);
    return vadd_s32(vld1_s32(from), vmovn_s64(vcvtnq_s64_f64(by)));
}

void pierce_neon(const EdgeArrays& edges, std::int32_t z, std::size_t count, Point* points) {
    for (std::size_t e = 0; e < count; e += 2) {
        const float64x2_t rise = vcvtq_f64_s64(vsubl_s32(vdup_n_s32(z), vld1_s32(edges.z + e)));
        const int32x2x2_t pierced{
            {pierce_two(edges.x + e, edges.slope_x + e, rise), pierce_two(edges.y + e, edges.slope_y + e, rise)}};
        vst2_s32(reinterpret_cast<std::int32_t*>(points + e), pierced);  // a macro of Clang, which takes no braces
    }
}

int32x4x2_t gather_four(const Point* points, const std::uint32_t* slots) {
    const auto at = [=](int i) { return vld1_s32(reinterpret_cast<const std::int32_t*>(points + slots[i])); };
    const int32x4_t low = vcombine_s32(at(0), at(1));
    const int32x4_t high = vcombine_s32(at(2), at(3));
    return {{vuzp1q_s32(low, high), vuzp2q_s32(low, high)}};
}

/// Sums of products in two halves: 2^31 products of 64 bits fit.
struct HalfSums {
    uint64x2_t low = vdupq_n_u64(0);
    int64x2_t high = vdupq_n_s64(0);

    void add(int64x2_t products) {
        low = vaddw_u32(low, vmovn_u64(vreinterpretq_u64_s64(products)));
        high = vaddw_s32(high, vshrn_n_s64(products, 32));
    }
    Int128 sum() const { return (Int128{vaddvq_s64(high)} << 32) + Int128{vaddvq_u64(low)}; }
};

/// Of points [begin, end), those with the least x.
void note_smallest(const Point* ring, std::size_t begin, std::size_t end, std::size_t none, RingFacts& facts) {
    for (std::size_t i = begin; i < end; ++i) {
        if (ring[i].x == facts.box.low.x && (facts.smallest == none || ring[i].y <= ring[facts.smallest].y)) {
            facts.many_smallest = facts.smallest != none && ring[i].y == ring[facts.smallest].y;
            facts.smallest = facts.many_smallest ? facts.smallest : i;
        }
    }
}

/// Four points a step, as trace_avx512 has eight, with x and y in a vector each.
RingFacts trace_neon(const Point* points, const std::uint32_t* slots, std::size_t count, Point* ring) {
    constexpr std::size_t lanes = 4;
    if (count < 2 * lanes) {
        return trace_portable(points, slots, count, ring);
    }
    const Point first = points[slots[0]];
    const Point last = points[slots[count - 1]];
    int32x4x2_t before{{vdupq_n_s32(last.x), vdupq_n_s32(last.y)}};
    int32x4x2_t here = gather_four(points, slots);
    int32x4x2_t low{{vdupq_n_s32(first.x), vdupq_n_s32(first.y)}};
    int32x4x2_t high = low;
    uint32x4_t repeats = vdupq_n_u32(0);
    HalfSums sums;
    const std::size_t whole = (count - lanes) / lanes * lanes;  // a whole vector follows each
    for (std::size_t i = 0; i < whole; i += lanes) {
        const int32x4x2_t next = gather_four(points, slots + i + lanes);
        vst2q_s32(reinterpret_cast<std::int32_t*>(ring + i), here);
        const int32x4_t after_y = vextq_s32(here.val[1], next.val[1], 1);
        const uint32x4_t same_x = vceqq_s32(here.val[0], vextq_s32(here.val[0], next.val[0], 1));
        repeats = vorrq_u32(repeats, vandq_u32(same_x, vceqq_s32(here.val[1], after_y)));
        for (int axis = 0; axis < 2; ++axis) {
            low.val[axis] = vminq_s32(low.val[axis], here.val[axis]);
            high.val[axis] = vmaxq_s32(high.val[axis], here.val[axis]);
        }
        const int32x4_t dx = vsubq_s32(here.val[0], vdupq_n_s32(first.x));
        const int32x4_t dy = vsubq_s32(after_y, vextq_s32(before.val[1], here.val[1], 3));
        sums.add(vmull_s32(vget_low_s32(dx), vget_low_s32(dy)));
        sums.add(vmull_high_s32(dx, dy));
        before = here;
        here = next;
    }
    RingFacts facts{};
    facts.box = {{vminvq_s32(low.val[0]), vminvq_s32(low.val[1])}, {vmaxvq_s32(high.val[0]), vmaxvq_s32(high.val[1])}};
    facts.has_repeats = vmaxvq_u32(repeats) != 0;
    facts.twice_area = sums.sum();
    add_rest(points, slots, whole, count, ring, facts);
    facts.smallest = count;
    const int32x4_t lowest_x = vdupq_n_s32(facts.box.low.x);
    for (std::size_t i = 0; i < count; i += lanes) {
        const std::size_t end = std::min(count, i + lanes);
        if (end == count ||
            vmaxvq_u32(vceqq_s32(vld2q_s32(reinterpret_cast<std::int32_t*>(ring + i)).val[0], lowest_x)) != 0) {
            note_smallest(ring, i, end, count, facts);
        }
    }
    return fits_halves(facts) ? facts : trace_portable(points, slots, count, ring);
}

constexpr Kernels neon{pierce_neon, trace_neon, select_equal_portable};

#endif

}  // namespace

std::span<const Form<Kernels>> kernel_forms() noexcept {
    static constexpr Form<Kernels> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx512, avx512},
        {InstructionSet::avx2, avx2},
#elif defined(LAMELLA_NEON_FORMS)
        {InstructionSet::neon, neon},
#endif
        {InstructionSet::portable, portable}};
    return forms;
}

}  // namespace lamella
