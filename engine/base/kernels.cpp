#include "base/kernels.hpp"

#include <algorithm>
#include <bit>

#include "base/rounding.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define LAMELLA_X86_KERNELS
#include <immintrin.h>
#endif

namespace lamella {

namespace {

// --- Portable
// -----------------------------------------------------------------------------------------------------------------

void pierce_portable(const EdgeArrays& edges, double z, std::size_t count, Point* points) {
    for (std::size_t e = 0; e < count; ++e) {
        const double rise = z - edges.z[e];
        points[e] = {round_to_int(edges.x[e] + edges.slope_x[e] * rise), round_to_int(edges.y[e] + edges.slope_y[e] * rise)};
    }
}

RingFacts examine_portable(const Point* ring, std::size_t count) {
    RingFacts facts{ring[0], ring[0], false};
    for (std::size_t i = 0; i < count; ++i) {
        facts.box_min = {std::min(facts.box_min.x, ring[i].x), std::min(facts.box_min.y, ring[i].y)};
        facts.box_max = {std::max(facts.box_max.x, ring[i].x), std::max(facts.box_max.y, ring[i].y)};
        facts.has_repeats = facts.has_repeats || ring[i] == ring[i + 1];
    }
    return facts;
}

/// How many products x · dy can be summed in 64 bits: |x| relative to the box and |dy| are bounded by its sides.
std::size_t products_per_block(const RingFacts& facts) {
    const auto width = static_cast<std::uint64_t>(std::int64_t{facts.box_max.x} - facts.box_min.x);
    const auto height = static_cast<std::uint64_t>(std::int64_t{facts.box_max.y} - facts.box_min.y);
    return std::size_t{1} << std::clamp(
               63 - static_cast<int>(std::bit_width(width)) - static_cast<int>(std::bit_width(height)), 0, 30);
}

/// Sum over i of x[i] · (y[i + 1] - y[i - 1]): one product a point.
Int128 twice_area_portable(const Point* ring, std::size_t count, const RingFacts& facts) {
    const std::size_t block = products_per_block(facts);
    const std::int64_t origin = facts.box_min.x;
    Int128 total = 0;
    for (std::size_t begin = 0; begin < count; begin += block) {
        std::int64_t sum = 0;
        const std::size_t end = std::min(count, begin + block);
        for (std::size_t i = begin; i < end; ++i) {
            sum += (ring[i].x - origin) * (std::int64_t{ring[i + 1].y} - ring[i - std::size_t{1}].y);
        }
        total += sum;
    }
    return total;
}

std::size_t find_x_portable(const Point* ring, std::size_t from, std::size_t count, std::int32_t x) {
    for (; from < count && ring[from].x != x; ++from) {
    }
    return from;
}

constexpr Kernels portable{pierce_portable, examine_portable, twice_area_portable, find_x_portable};

#ifdef LAMELLA_X86_KERNELS

#define LAMELLA_AVX2 __attribute__((target("avx2")))
#define LAMELLA_AVX512 __attribute__((target("avx512f,avx512vl,avx2")))

// --- AVX2: four edges, four points a step
// ---------------------------------------------------------------------------------------

LAMELLA_AVX2 void pierce_avx2(const EdgeArrays& edges, double z, std::size_t count, Point* points) {
    const __m256d plane = _mm256_set1_pd(z);
    for (std::size_t e = 0; e < count; e += 4) {
        const __m256d rise = _mm256_sub_pd(plane, _mm256_loadu_pd(edges.z + e));
        const __m256d x =
            _mm256_add_pd(_mm256_loadu_pd(edges.x + e), _mm256_mul_pd(_mm256_loadu_pd(edges.slope_x + e), rise));
        const __m256d y =
            _mm256_add_pd(_mm256_loadu_pd(edges.y + e), _mm256_mul_pd(_mm256_loadu_pd(edges.slope_y + e), rise));
        const __m128i xs = _mm256_cvtpd_epi32(x);
        const __m128i ys = _mm256_cvtpd_epi32(y);
        auto* out = reinterpret_cast<__m128i*>(points + e);
        _mm_storeu_si128(out, _mm_unpacklo_epi32(xs, ys));
        _mm_storeu_si128(out + 1, _mm_unpackhi_epi32(xs, ys));
    }
}

LAMELLA_AVX2 __m256i load_points(const Point* at) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
}

LAMELLA_AVX2 RingFacts examine_avx2(const Point* ring, std::size_t count) {
    if (count < 4) {
        return examine_portable(ring, count);
    }
    __m256i low = load_points(ring);
    __m256i high = low;
    __m256i repeats = _mm256_setzero_si256();
    // The last step overlaps the one before it: looking twice at a point changes nothing.
    for (std::size_t i = 0;;) {
        const __m256i here = load_points(ring + i);
        low = _mm256_min_epi32(low, here);
        high = _mm256_max_epi32(high, here);
        repeats = _mm256_or_si256(repeats, _mm256_cmpeq_epi64(here, load_points(ring + i + 1)));
        if (i + 4 == count) {
            break;
        }
        i = std::min(i + 4, count - 4);
    }
    Point lows[4];
    Point highs[4];
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(lows), low);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(highs), high);
    RingFacts facts{lows[0], highs[0], _mm256_testz_si256(repeats, repeats) == 0};
    for (int i = 1; i < 4; ++i) {
        facts.box_min = {std::min(facts.box_min.x, lows[i].x), std::min(facts.box_min.y, lows[i].y)};
        facts.box_max = {std::max(facts.box_max.x, highs[i].x), std::max(facts.box_max.y, highs[i].y)};
    }
    return facts;
}

LAMELLA_AVX2 Int128 twice_area_avx2(const Point* ring, std::size_t count, const RingFacts& facts) {
    // Differences must fit the 32-bit halves that are multiplied.
    if (std::int64_t{facts.box_max.x} - facts.box_min.x > INT32_MAX ||
        std::int64_t{facts.box_max.y} - facts.box_min.y > INT32_MAX) {
        return twice_area_portable(ring, count, facts);
    }
    const std::size_t block = std::max<std::size_t>(products_per_block(facts), 4) / 4 * 4;
    const __m256i origin = _mm256_set1_epi64x(static_cast<std::uint32_t>(facts.box_min.x));
    const std::size_t whole = products_per_block(facts) >= 4 ? count / 4 * 4 : 0;
    Int128 total = 0;
    for (std::size_t begin = 0; begin < whole; begin += block) {
        __m256i sums = _mm256_setzero_si256();
        const std::size_t end = std::min(whole, begin + block);
        for (std::size_t i = begin; i < end; i += 4) {
            //  x in the low half of each 64-bit lane, y in the high one: multiply takes low halves
            const __m256i x = _mm256_sub_epi32(load_points(ring + i), origin);
            const __m256i dy = _mm256_sub_epi32(load_points(ring + i + 1), load_points(ring + i - 1));
            sums = _mm256_add_epi64(sums, _mm256_mul_epi32(x, _mm256_srli_epi64(dy, 32)));
        }
        std::int64_t lanes[4];
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(lanes), sums);
        total += Int128{lanes[0]} + lanes[1] + lanes[2] + lanes[3];
    }
    for (std::size_t i = whole; i < count; ++i) {
        const std::int64_t x = std::int64_t{ring[i].x} - facts.box_min.x;
        total += Int128{x} * (std::int64_t{ring[i + 1].y} - ring[i - std::size_t{1}].y);
    }
    return total;
}

LAMELLA_AVX2 std::size_t find_x_avx2(const Point* ring, std::size_t from, std::size_t count, std::int32_t x) {
    const __m256i wanted = _mm256_set1_epi64x(static_cast<std::uint32_t>(x));
    for (; from + 4 <= count; from += 4) {
        const __m256i same = _mm256_cmpeq_epi32(load_points(ring + from), wanted);
        const int bits = _mm256_movemask_ps(_mm256_castsi256_ps(same)) & 0x55;  // the x halves
        if (bits != 0) {
            return from + static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(bits))) / 2;
        }
    }
    return find_x_portable(ring, from, count, x);
}

constexpr Kernels avx2{pierce_avx2, examine_avx2, twice_area_avx2, find_x_avx2};

// --- AVX-512: eight edges a step; rings are too short to gain by it
// ---------------------------------------------------------------

LAMELLA_AVX512 void pierce_avx512(const EdgeArrays& edges, double z, std::size_t count, Point* points) {
    const __m512d plane = _mm512_set1_pd(z);
    for (std::size_t e = 0; e < count; e += 8) {
        const __m512d rise = _mm512_sub_pd(plane, _mm512_loadu_pd(edges.z + e));
        const __m512d x =
            _mm512_add_pd(_mm512_loadu_pd(edges.x + e), _mm512_mul_pd(_mm512_loadu_pd(edges.slope_x + e), rise));
        const __m512d y =
            _mm512_add_pd(_mm512_loadu_pd(edges.y + e), _mm512_mul_pd(_mm512_loadu_pd(edges.slope_y + e), rise));
        // 64-bit lanes of y << 32 | x are points as they lie in memory. (Masked forms: GCC 12 warns about the plain ones.)
        const __m512i xs = _mm512_maskz_cvtepu32_epi64(0xFF, _mm512_maskz_cvtpd_epi32(0xFF, x));
        const __m512i ys = _mm512_maskz_cvtepu32_epi64(0xFF, _mm512_maskz_cvtpd_epi32(0xFF, y));
        _mm512_storeu_si512(points + e, _mm512_or_si512(xs, _mm512_maskz_slli_epi64(0xFF, ys, 32)));
    }
}

constexpr Kernels avx512{pierce_avx512, examine_avx2, twice_area_avx2, find_x_avx2};

#endif

}  // namespace

const Kernels& portable_kernels() noexcept {
    return portable;
}

const Kernels& kernels_for_this_cpu() noexcept {
#ifdef LAMELLA_X86_KERNELS
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) {
        return avx512;
    }
    if (__builtin_cpu_supports("avx2")) {
        return avx2;
    }
#endif
    return portable;
}

}  // namespace lamella
