#include "slicing/nesting/query_steps.hpp"

#include <algorithm>
#include <bit>

namespace lamella::nesting {

namespace {

/// No branch on whether an edge reaches a point: it would be mispredicted.
std::size_t sift_portable(const QuerySteps& steps, const Point* points, std::uint32_t count, Reaches& reaches) noexcept {
    std::size_t found = 0;
    std::uint32_t begin = steps.ends[steps.of(points[0].y)];
    std::uint32_t end = steps.ends[steps.of(points[0].y) + 1];
    for (std::uint32_t edge = 0; edge < count; ++edge) {
        const std::uint32_t step = steps.of(points[edge + 1].y);
        const std::uint32_t next_begin = steps.ends[step];
        const std::uint32_t next_end = steps.ends[step + 1];
        reaches.edge[found] = edge;
        reaches.begin[found] = begin < next_begin ? begin : next_begin;
        reaches.end[found] = end < next_end ? next_end : end;
        found += reaches.begin[found] < reaches.end[found] ? 1 : 0;
        begin = next_begin;
        end = next_end;
    }
    return found;
}

#ifdef LAMELLA_X86_FORMS

/// y of points[0] to points[15]; zero where `lanes` has no bit.
LAMELLA_AVX512_INLINE __m512i sixteen_y(const Point* points, __mmask16 lanes) noexcept {
    const __m512i y_lanes = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    const __m512i low = _mm512_maskz_loadu_epi64(static_cast<__mmask8>(lanes), points);
    const __m512i high = _mm512_maskz_loadu_epi64(static_cast<__mmask8>(lanes >> 8), points + 8);
    return _mm512_permutex2var_epi32(low, y_lanes, high);
}

LAMELLA_AVX512_INLINE __m512i gather(const std::uint32_t* table, __m512i index) noexcept {
    return _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), all_lanes, index, table, 4);
}

/// Stores those of sixteen numbers with a bit in `lanes`. Writes a full vector: `to` needs 16 spare elements.
LAMELLA_AVX512_INLINE void store_some(std::uint32_t* to, __mmask16 lanes, __m512i numbers) noexcept {
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(lanes, numbers));
}

/// Sixteen edges a step: the steps of their second ends, shifted by a lane for the first.
LAMELLA_AVX512 std::size_t sift_avx512(const QuerySteps& steps, const Point* points, std::uint32_t count,
                                       Reaches& reaches) noexcept {
    const __m512i low = _mm512_set1_epi32(steps.low);
    const __m512i high = _mm512_set1_epi32(steps.high);
    const __m128i shift = _mm_cvtsi32_si128(steps.shift);
    const std::uint32_t first_step = steps.of(points[0].y);
    __m512i begin_before = _mm512_set1_epi32(static_cast<int>(steps.ends[first_step]));
    __m512i end_before = _mm512_set1_epi32(static_cast<int>(steps.ends[first_step + 1]));
    __m512i edge = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    std::size_t found = 0;
    for (std::uint32_t i = 0; i < count; i += 16) {
        const std::uint32_t left = count - i;
        const auto lanes = static_cast<__mmask16>(left >= 16 ? 0xFFFFU : (1U << left) - 1);
        const __m512i y = sixteen_y(points + i + 1, lanes);
        const __m512i within = _mm512_maskz_min_epi32(all_lanes, high, _mm512_maskz_max_epi32(all_lanes, low, y));
        const __m512i step = _mm512_maskz_srl_epi32(all_lanes, _mm512_sub_epi32(within, low), shift);
        const __m512i begin = gather(steps.ends, step);
        const __m512i end = gather(steps.ends + 1, step);
        const __m512i from =
            _mm512_maskz_min_epi32(all_lanes, begin, _mm512_maskz_alignr_epi32(all_lanes, begin, begin_before, 15));
        const __m512i to = _mm512_maskz_max_epi32(all_lanes, end, _mm512_maskz_alignr_epi32(all_lanes, end, end_before, 15));
        const __mmask16 reaching = _mm512_mask_cmplt_epi32_mask(lanes, from, to);
        store_some(reaches.edge + found, reaching, edge);
        store_some(reaches.begin + found, reaching, from);
        store_some(reaches.end + found, reaching, to);
        found += static_cast<std::size_t>(std::popcount(static_cast<unsigned>(reaching)));
        edge = _mm512_add_epi32(edge, _mm512_set1_epi32(16));
        begin_before = begin;
        end_before = end;
    }
    _mm256_zeroupper();
    return found;
}

#endif

}  // namespace

std::span<const Form<SiftEdges>> sift_edges_forms() noexcept {
    static constexpr Form<SiftEdges> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx512, sift_avx512},
#endif
        {InstructionSet::portable, sift_portable}};
    return forms;
}

}  // namespace lamella::nesting
