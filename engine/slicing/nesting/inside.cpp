#include "slicing/nesting/inside.hpp"

#include <bit>
#include <numeric>

namespace lamella::nesting {

namespace {

void add_edges_portable(Winding& winding, const Point* points, std::uint32_t count) noexcept {
    const std::int32_t y = winding.query().y;
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((points[i].y > y) != (points[i + 1].y > y) || points[i].y == y) {
            winding.add(points[i], points[i + 1]);
        }
    }
}

/// Without a branch, as no predictor knows which edges reach a point's step.
std::size_t sift_portable(const LevelSteps& steps, const Point* points, std::uint32_t count,
                          ReachingEdges& reaching) noexcept {
    std::size_t found = 0;
    std::uint32_t step = steps.of(points[0].y);
    for (std::uint32_t edge = 0; edge < count; ++edge) {
        const std::uint32_t next = steps.of(points[edge + 1].y);
        reaching.edge[found] = edge;
        reaching.first[found] = steps.firsts[std::min(step, next)];
        reaching.last[found] = steps.firsts[std::max(step, next) + 1];
        found += reaching.first[found] < reaching.last[found] ? 1 : 0;
        step = next;
    }
    return found;
}

#ifdef LAMELLA_X86_FORMS

/// Lanes are x0 y0 x1 y1 x2 y2 x3 y3; a double's sign is a y lane's, so movemask_pd reads the four answers for y.
LAMELLA_AVX2_INLINE unsigned y_bits(__m256i lanes) noexcept {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_castsi256_pd(lanes)));
}

LAMELLA_AVX2_INLINE __m256i four_points(const Point* points) noexcept {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(points));
}

/// Which of the 16 edges from points[0] to points[16] must be added:
///     bit i of `above` = point i lies above the query's y;   above ^ (above >> 1) = edge (i, i+1) straddles it.
/// Points at exactly that y are rare, so one test of all four quads comes first.
LAMELLA_AVX2_INLINE unsigned edges_at(const Point* points, std::int32_t y) noexcept {
    const __m256i level = _mm256_set1_epi32(y);
    const __m256i quads[4] = {four_points(points), four_points(points + 4), four_points(points + 8),
                              four_points(points + 12)};
    __m256i at[4];
    unsigned above = static_cast<unsigned>(points[16].y > y) << 16;
    for (int quad = 0; quad < 4; ++quad) {
        above |= y_bits(_mm256_cmpgt_epi32(quads[quad], level)) << (4 * quad);
        at[quad] = _mm256_cmpeq_epi32(quads[quad], level);
    }
    unsigned edges = (above ^ above >> 1) & 0xffffU;
    if (y_bits(_mm256_or_si256(_mm256_or_si256(at[0], at[1]), _mm256_or_si256(at[2], at[3]))) != 0) {
        edges |= y_bits(at[0]) | y_bits(at[1]) << 4 | y_bits(at[2]) << 8 | y_bits(at[3]) << 12;
    }
    return edges;
}

LAMELLA_AVX2 void add_edges_avx2(Winding& winding, const Point* points, std::uint32_t count) noexcept {
    if (count < 16) {
        add_edges_portable(winding, points, count);
        return;
    }
    Winding sum = winding;  // a copy stays in registers
    const std::int32_t y = sum.query().y;
    for (std::uint32_t i = 0; i < count; i += 16) {
        const std::uint32_t first = std::min(i, count - 16);  // the last run overlaps the one before
        for (unsigned edges = edges_at(points + first, y) >> (i - first) << (i - first); edges != 0; edges &= edges - 1) {
            const Point* edge = points + first + std::countr_zero(edges);
            sum.add(edge[0], edge[1]);
        }
    }
    winding = sum;
    _mm256_zeroupper();  // the caller runs the narrow instructions of the baseline
}

/// For up to 64 points, bit i for point i: whether it lies above the query's y, and whether at it.
struct Levels {
    std::uint64_t above = 0;
    std::uint64_t at = 0;
};

/// Bits for the first `count` lanes of sixteen, or all.
LAMELLA_AVX512_INLINE __mmask16 first_lanes(unsigned count) noexcept {
    return static_cast<__mmask16>(count >= lanes_of_512 ? all_lanes : (1U << count) - 1);
}

/// y of points[0] to points[15]; zero where `lanes` has no bit.
LAMELLA_AVX512_INLINE __m512i sixteen_y(const Point* points, __mmask16 lanes) noexcept {
    const __m512i y_lanes = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    const __m512i low = _mm512_maskz_loadu_epi64(static_cast<__mmask8>(lanes), points);
    const __m512i high = _mm512_maskz_loadu_epi64(static_cast<__mmask8>(lanes >> 8), points + 8);
    return _mm512_permutex2var_epi32(low, y_lanes, high);
}

/// Adds sixteen points.
LAMELLA_AVX512_INLINE void add_levels(Levels& levels, __m512i ys, __m512i level, unsigned shift) noexcept {
    levels.above |= std::uint64_t{_mm512_cmpgt_epi32_mask(ys, level)} << shift;
    levels.at |= std::uint64_t{_mm512_cmpeq_epi32_mask(ys, level)} << shift;
}

LAMELLA_AVX512_INLINE Levels levels_of_64(const Point* points, __m512i level) noexcept {
    Levels levels;
    for (unsigned i = 0; i < 64; i += lanes_of_512) {
        add_levels(levels, sixteen_y(points + i, all_lanes), level, i);
    }
    return levels;
}

/// Fewer than 64.
LAMELLA_AVX512_INLINE Levels levels_of_few(const Point* points, unsigned count, __m512i level) noexcept {
    Levels levels;
    for (unsigned i = 0; i < count; i += lanes_of_512) {
        add_levels(levels, sixteen_y(points + i, first_lanes(count - i)), level, i);
    }
    return levels;
}

/// The same with 64 edges a step, sifted without a branch.
LAMELLA_AVX512 void add_edges_avx512(Winding& winding, const Point* points, std::uint32_t count) noexcept {
    Winding sum = winding;
    const __m512i level = _mm512_set1_epi32(sum.query().y);
    for (std::uint32_t i = 0; i < count; i += 64) {
        const unsigned edges = std::min(count - i, 64U);
        const Levels levels = edges == 64 ? levels_of_64(points + i, level) : levels_of_few(points + i, edges, level);
        const std::uint64_t looked_at = ~std::uint64_t{0} >> (64 - edges);
        const std::uint64_t above = levels.above & looked_at;
        const std::uint64_t behind = points[i + edges].y > sum.query().y ? 1 : 0;
        std::uint64_t wanted = (above ^ (above >> 1 | behind << (edges - 1))) | (levels.at & looked_at);
        for (; wanted != 0; wanted &= wanted - 1) {
            const Point* edge = points + i + std::countr_zero(wanted);
            sum.add(edge[0], edge[1]);
        }
    }
    winding = sum;
    _mm256_zeroupper();
}

LAMELLA_AVX512_INLINE __m512i gather(const std::uint32_t* table, __m512i index) noexcept {
    return _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), all_lanes, index, table, 4);
}

LAMELLA_AVX512_INLINE void store_some(std::uint32_t* to, __mmask16 lanes, __m512i numbers) noexcept {
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(lanes, numbers));
}

/// Sixteen edges at a time: where their second ends lie, moved by a lane for the first.
LAMELLA_AVX512 std::size_t sift_avx512(const LevelSteps& steps, const Point* points, std::uint32_t count,
                                       ReachingEdges& reaching) noexcept {
    const __m512i low = _mm512_set1_epi32(steps.low);
    const __m512i high = _mm512_set1_epi32(steps.high);
    const __m512i up = _mm512_set1_epi32((1 << steps.shift) - 1);
    const std::uint32_t step_before = steps.of(points[0].y);
    __m512i first_before = _mm512_set1_epi32(static_cast<int>(steps.firsts[step_before]));
    __m512i last_before = _mm512_set1_epi32(static_cast<int>(steps.firsts[step_before + 1]));
    __m512i edge = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    std::size_t found = 0;
    for (std::uint32_t i = 0; i < count; i += 16) {
        const __mmask16 lanes = first_lanes(count - i);
        const __m512i y = sixteen_y(points + i + 1, lanes);
        const __m512i within = _mm512_maskz_min_epi32(all_lanes, high, _mm512_maskz_max_epi32(all_lanes, low, y));
        const __m512i above_low = _mm512_add_epi32(_mm512_sub_epi32(within, low), up);
        const __m512i step = _mm512_maskz_srl_epi32(all_lanes, above_low, _mm_cvtsi32_si128(steps.shift));
        const __m512i first = gather(steps.firsts, step);
        const __m512i last = gather(steps.firsts + 1, step);
        const __m512i from =
            _mm512_maskz_min_epi32(all_lanes, first, _mm512_maskz_alignr_epi32(all_lanes, first, first_before, 15));
        const __m512i to =
            _mm512_maskz_max_epi32(all_lanes, last, _mm512_maskz_alignr_epi32(all_lanes, last, last_before, 15));
        const __mmask16 reach = _mm512_mask_cmplt_epi32_mask(lanes, from, to);
        store_some(reaching.edge.data() + found, reach, edge);
        store_some(reaching.first.data() + found, reach, from);
        store_some(reaching.last.data() + found, reach, to);
        found += static_cast<std::size_t>(std::popcount(static_cast<unsigned>(reach)));
        edge = _mm512_add_epi32(edge, _mm512_set1_epi32(16));
        first_before = first;
        last_before = last;
    }
    _mm256_zeroupper();
    return found;
}

#elif defined(LAMELLA_NEON_FORMS)

/// Sixteen edges a step: most lie above the query or below it. Its speed is not measured.
void add_edges_neon(Winding& winding, const Point* points, std::uint32_t count) noexcept {
    constexpr std::uint32_t step = 16;
    const auto ys_from = [=](std::uint32_t i) {
        return vld2q_s32(reinterpret_cast<const std::int32_t*>(points + i)).val[1];
    };
    const std::int32_t y = winding.query().y;
    std::uint32_t i = 0;
    for (; i + step <= count; i += step) {
        const int32x4_t ys[] = {ys_from(i), ys_from(i + 4), ys_from(i + 8), ys_from(i + 12)};
        const int32x4_t low = vminq_s32(vminq_s32(ys[0], ys[1]), vminq_s32(ys[2], ys[3]));
        const int32x4_t high = vmaxq_s32(vmaxq_s32(ys[0], ys[1]), vmaxq_s32(ys[2], ys[3]));
        const std::int32_t last = points[i + step].y;
        if (std::min(last, vminvq_s32(low)) <= y && y <= std::max(last, vmaxvq_s32(high))) {
            add_edges_portable(winding, points + i, step);
        }
    }
    add_edges_portable(winding, points + i, count - i);
}

#endif

}  // namespace

std::span<const Form<AddEdges>> add_edges_forms() noexcept {
    static constexpr Form<AddEdges> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx512, add_edges_avx512},
        {InstructionSet::avx2, add_edges_avx2},
#elif defined(LAMELLA_NEON_FORMS)
        {InstructionSet::neon, add_edges_neon},
#endif
        {InstructionSet::portable, add_edges_portable}};
    return forms;
}

std::span<const Form<SiftEdges>> sift_edges_forms() noexcept {
    static constexpr Form<SiftEdges> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx512, sift_avx512},
#endif
        {InstructionSet::portable, sift_portable}};
    return forms;
}

LevelSteps ManyInside::sort_by_step() {
    const auto [lowest, highest] =
        std::minmax_element(queries_.begin(), queries_.end(), [](const Query& a, const Query& b) { return a.y() < b.y(); });
    const auto width = [](auto number) { return static_cast<int>(std::bit_width(static_cast<std::uint64_t>(number))); };
    const int shift = std::max(0, width(std::int64_t{highest->y()} - lowest->y()) - width(4 * queries_.size()));
    LevelSteps steps{lowest->y() - 1, highest->y() + (1 << shift), shift};
    // Counted one step too far, and summed, the counts are where a step begins; each query moves that up to its end.
    firsts_.assign(steps.of(steps.high) + 3, 0);
    for (const Query& query : queries_) {
        ++firsts_[steps.of(query.y()) + 2];
    }
    std::partial_sum(firsts_.begin(), firsts_.end(), firsts_.begin());
    by_step_.resize(queries_.size());
    for (const Query& query : queries_) {
        by_step_[firsts_[steps.of(query.y()) + 1]++] = query;
    }
    steps.firsts = firsts_.data();
    return steps;
}

void ManyInside::test(const Point* points, std::uint32_t count, Vector<std::uint32_t>& inside,
                      Vector<std::uint32_t>* touching) {
    const LevelSteps steps = sort_by_step();
    const Point end = points[count - 1];
    const auto [low, high] = std::minmax({steps.of(end.y), steps.of(points[0].y)});
    add_edge(end, points[0], steps.firsts[low], steps.firsts[high + 1]);
    ReachingEdges reaching;
    for (std::uint32_t begin = 0; begin + 1 < count; begin += ReachingEdges::most) {
        const Point* const run = points + begin;
        const std::size_t found = sift_edges_(steps, run, std::min(count - 1 - begin, ReachingEdges::most), reaching);
        worker_.spend(ReachingEdges::most);
        for (std::size_t i = 0; i < found; ++i) {
            const Point* const edge = run + reaching.edge[i];
            add_edge(edge[0], edge[1], reaching.first[i], reaching.last[i]);
        }
    }
    for (const Query& query : by_step_) {
        if (query.winding.strictly_inside()) {
            inside.push_back(query.number);
        } else if (touching != nullptr && query.winding.on_boundary()) {
            touching->push_back(query.number);
        }
    }
}

inline void ManyInside::add_edge(Point from, Point to, std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t query = first; query < last; ++query) {
        by_step_[query].winding.add(from, to);
    }
    worker_.spend(last - first);
}

}  // namespace lamella::nesting
