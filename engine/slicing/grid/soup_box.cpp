#include "slicing/grid/soup_box.hpp"

#include <cstdint>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/dispatch.hpp"

namespace lamella {

namespace {

constexpr float float_infinity = std::numeric_limits<float>::infinity();

TriangleBlock block_of(const SoupBox& box, bool near) {
    return {static_cast<double>(box.low[2]), static_cast<double>(box.high[2]), near};
}

#ifdef __SSE2__

// --- SSE2, which x86-64 always has: three vectors that cover a triangle and nothing beyond it
//
//     x0 y0 z0 x1 y1 z1 x2 y2 z2
//     [---a-----]
//              [---b-----]
//                    [---c-----]

constexpr int offsets[3] = {0, 3, 5};

/// A SoupBox of each of the nine numbers of a triangle.
struct SseBox {
    __m128 low[3];
    __m128 high[3];

    SseBox() noexcept {
        for (int v = 0; v < 3; ++v) {
            low[v] = _mm_set1_ps(float_infinity);
            high[v] = _mm_set1_ps(-float_infinity);
        }
    }
    void add(int v, __m128 least, __m128 greatest) noexcept {
        low[v] = _mm_min_ps(low[v], least);
        high[v] = _mm_max_ps(high[v], greatest);
    }
    SoupBox by_axis() const noexcept {
        float low9[9];
        float high9[9];
        for (int v = 0; v < 3; ++v) {
            _mm_storeu_ps(low9 + offsets[v], low[v]);
            _mm_storeu_ps(high9 + offsets[v], high[v]);
        }
        SoupBox box{};
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min({low9[axis], low9[axis + 3], low9[axis + 6]});
            box.high[axis] = std::max({high9[axis], high9[axis + 3], high9[axis + 6]});
        }
        return box;
    }
};

/// True if the first three lanes are all within `reach` of 0.
bool all_within(__m128 difference, __m128 reach) {
    const __m128 size = _mm_andnot_ps(_mm_set1_ps(-0.0F), difference);
    return (_mm_movemask_ps(_mm_cmple_ps(size, reach)) & 7) == 7;
}

SoupBox measure_portable(const FloatSoup& soup, std::size_t begin, std::size_t end, TriangleBlock* blocks) {
    const __m128 reach = _mm_set1_ps(soup.near_mm);
    SseBox all;
    __m128 nan = _mm_setzero_ps();
    for (std::size_t block = begin; block < end; ++block) {
        const std::size_t last = std::min(soup.triangle_count, (block + 1) * block_triangles);
        SseBox box;
        bool near = false;
        for (std::size_t t = block * block_triangles; t < last; ++t) {
            prefetch_ahead(soup.vertices + t * soup.stride, 1);
            const auto* at = reinterpret_cast<const float*>(soup.vertices + t * soup.stride);
            __m128 value[3];
            for (int v = 0; v < 3; ++v) {
                value[v] = _mm_loadu_ps(at + offsets[v]);
                box.add(v, value[v], value[v]);
            }
            const __m128 third = _mm_shuffle_ps(value[2], value[2], _MM_SHUFFLE(3, 3, 2, 1));
            near |= all_within(_mm_sub_ps(value[0], value[1]), reach);
            near |= all_within(_mm_sub_ps(value[1], third), reach);
            near |= all_within(_mm_sub_ps(third, value[0]), reach);
            nan = _mm_or_ps(nan, _mm_or_ps(_mm_cmpunord_ps(value[0], value[1]), _mm_cmpunord_ps(value[2], value[2])));
        }
        blocks[block] = block_of(box.by_axis(), near);
        for (int v = 0; v < 3; ++v) {
            all.add(v, box.low[v], box.high[v]);
        }
    }
    SoupBox result = all.by_axis();
    result.has_nan = _mm_movemask_ps(nan) != 0;
    return result;
}

#else

SoupBox measure_portable(const FloatSoup& soup, std::size_t begin, std::size_t end, TriangleBlock* blocks) {
    const SoupBox empty{
        {float_infinity, float_infinity, float_infinity}, {-float_infinity, -float_infinity, -float_infinity}, false};
    SoupBox all = empty;
    for (std::size_t block = begin; block < end; ++block) {
        const std::size_t last = std::min(soup.triangle_count, (block + 1) * block_triangles);
        SoupBox box = empty;
        bool near = false;
        for (std::size_t t = block * block_triangles; t < last; ++t) {
            float v[9];
            std::memcpy(v, soup.vertices + t * soup.stride, sizeof v);
            for (int corner = 0; corner < 9; corner += 3) {
                const float* next = v + (corner + 3) % 9;
                near |= std::abs(v[corner] - next[0]) <= soup.near_mm && std::abs(v[corner + 1] - next[1]) <= soup.near_mm &&
                        std::abs(v[corner + 2] - next[2]) <= soup.near_mm;
            }
            for (int i = 0; i < 9; ++i) {
                box.low[i % 3] = std::min(box.low[i % 3], v[i]);
                box.high[i % 3] = std::max(box.high[i % 3], v[i]);
                all.has_nan |= std::isnan(v[i]);
            }
        }
        blocks[block] = block_of(box, near);
        for (int axis = 0; axis < 3; ++axis) {
            all.low[axis] = std::min(all.low[axis], box.low[axis]);
            all.high[axis] = std::max(all.high[axis], box.high[axis]);
        }
    }
    return all;
}

#endif

#ifdef LAMELLA_X86_FORMS

// --- AVX-512: sixteen triangles at a time, a vector for each of their nine numbers

LAMELLA_AVX512 __m512 least(__m512 a, __m512 b) {
    return _mm512_maskz_min_ps(all_lanes, a, b);
}
LAMELLA_AVX512 __m512 greatest(__m512 a, __m512 b) {
    return _mm512_maskz_max_ps(all_lanes, a, b);
}

LAMELLA_AVX512 __m256 lower_half(__m512 v) {
    return _mm512_maskz_extractf32x8_ps(0xFF, v, 0);
}
LAMELLA_AVX512 __m256 upper_half(__m512 v) {
    return _mm512_maskz_extractf32x8_ps(0xFF, v, 1);
}
LAMELLA_AVX512 float least_of(__m512 v) {
    const __m256 eight = _mm256_min_ps(lower_half(v), upper_half(v));
    const __m128 four = _mm_min_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
    const __m128 two = _mm_min_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_min_ss(two, _mm_shuffle_ps(two, two, 1)));
}
LAMELLA_AVX512 float greatest_of(__m512 v) {
    const __m256 eight = _mm256_max_ps(lower_half(v), upper_half(v));
    const __m128 four = _mm_max_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
    const __m128 two = _mm_max_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_max_ss(two, _mm_shuffle_ps(two, two, 1)));
}

struct AxisBox {
    __m512 low[3];
    __m512 high[3];
};

LAMELLA_AVX512 void add(AxisBox& box, const __m512* v) {
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = least(box.low[axis], least(v[axis], least(v[axis + 3], v[axis + 6])));
        box.high[axis] = greatest(box.high[axis], greatest(v[axis], greatest(v[axis + 3], v[axis + 6])));
    }
}

LAMELLA_AVX512 __mmask16 within(__mmask16 lanes, __m512 a, __m512 b, __m512 reach) {
    const __m512i size = _mm512_and_si512(_mm512_castps_si512(_mm512_sub_ps(a, b)), _mm512_set1_epi32(0x7FFFFFFF));
    return _mm512_mask_cmp_ps_mask(lanes, _mm512_castsi512_ps(size), reach, _CMP_LE_OQ);
}

/// Few edges run along y and z, so the differences in x mostly suffice.
LAMELLA_AVX512 bool any_near(const __m512* v, __m512 reach) {
    const __mmask16 x01 = within(all_lanes, v[0], v[3], reach);
    const __mmask16 x12 = within(all_lanes, v[3], v[6], reach);
    const __mmask16 x20 = within(all_lanes, v[6], v[0], reach);
    if ((x01 | x12 | x20) == 0) {
        return false;
    }
    const auto rest = [&](__mmask16 lanes, int a, int b) LAMELLA_AVX512 {
        return within(within(lanes, v[a + 1], v[b + 1], reach), v[a + 2], v[b + 2], reach);
    };
    return (rest(x01, 0, 3) | rest(x12, 3, 6) | rest(x20, 6, 0)) != 0;
}

LAMELLA_AVX512 unsigned nan_lanes(const __m512* v) {
    unsigned lanes = _mm512_cmp_ps_mask(v[8], v[8], _CMP_UNORD_Q);
    for (int i = 0; i < 8; i += 2) {
        lanes |= _mm512_cmp_ps_mask(v[i], v[i + 1], _CMP_UNORD_Q);
    }
    return lanes;
}

LAMELLA_AVX512 SoupBox measure_avx512(const FloatSoup& soup, std::size_t begin, std::size_t end, TriangleBlock* blocks) {
    const __m512 reach = _mm512_set1_ps(soup.near_mm);
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i stride = _mm512_set1_epi32(static_cast<std::int32_t>(soup.stride));
    const __m512 lowest = _mm512_set1_ps(-float_infinity);
    const __m512 highest = _mm512_set1_ps(float_infinity);
    AxisBox all{{highest, highest, highest}, {lowest, lowest, lowest}};
    unsigned nan = 0;
    for (std::size_t block = begin; block < end; ++block) {
        const std::size_t last = std::min(soup.triangle_count, (block + 1) * block_triangles);
        const __m512 low = all.low[2];
        const __m512 high = all.high[2];
        all.low[2] = highest;
        all.high[2] = lowest;
        bool near = false;
        for (std::size_t t = block * block_triangles; t < last; t += lanes_of_512) {
            // Past the last triangle come copies of it.
            const auto count = static_cast<std::int32_t>(std::min(lanes_of_512, last - t));
            const __m512i lane = _mm512_maskz_min_epi32(all_lanes, lanes, _mm512_set1_epi32(count - 1));
            const __m512i offsets = _mm512_mullo_epi32(lane, stride);
            const std::byte* at = soup.vertices + t * soup.stride;
            prefetch_ahead(at, lanes_of_512 * soup.stride);
            __m512 v[9];
            for (std::size_t i = 0; i < 9; ++i) {
                const auto* number = reinterpret_cast<const float*>(at + i * sizeof(float));
                v[i] = _mm512_mask_i32gather_ps(_mm512_setzero_ps(), all_lanes, offsets, number, 1);
            }
            add(all, v);
            near |= any_near(v, reach);
            nan |= nan_lanes(v);
        }
        blocks[block] = {static_cast<double>(least_of(all.low[2])), static_cast<double>(greatest_of(all.high[2])), near};
        all.low[2] = least(all.low[2], low);
        all.high[2] = greatest(all.high[2], high);
    }
    SoupBox result{};
    for (int axis = 0; axis < 3; ++axis) {
        result.low[axis] = least_of(all.low[axis]);
        result.high[axis] = greatest_of(all.high[axis]);
    }
    result.has_nan = nan != 0;
    return result;
}

#endif

}  // namespace

std::span<const Form<MeasureSoup>> measure_soup_forms() noexcept {
    static constexpr Form<MeasureSoup> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx512, measure_avx512},
#endif
        {InstructionSet::portable, measure_portable}};
    return forms;
}

}  // namespace lamella
