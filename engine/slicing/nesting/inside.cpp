#include "slicing/nesting/inside.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

#include "base/vector.hpp"

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

/// Adds sixteen points. One vector takes the y's of two vectors of points.
LAMELLA_AVX512_INLINE void add_levels(Levels& levels, __m512i low, __m512i high, __m512i level, unsigned shift) noexcept {
    const __m512i y_lanes = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    const __m512i ys = _mm512_permutex2var_epi32(low, y_lanes, high);
    levels.above |= std::uint64_t{_mm512_cmpgt_epi32_mask(ys, level)} << shift;
    levels.at |= std::uint64_t{_mm512_cmpeq_epi32_mask(ys, level)} << shift;
}

LAMELLA_AVX512_INLINE Levels levels_of_64(const Point* points, __m512i level) noexcept {
    Levels levels;
    for (unsigned i = 0; i < 64; i += 16) {
        add_levels(levels, _mm512_loadu_si512(points + i), _mm512_loadu_si512(points + i + 8), level, i);
    }
    return levels;
}

/// Fewer than 64.
LAMELLA_AVX512_INLINE Levels levels_of_few(const Point* points, unsigned count, __m512i level) noexcept {
    Levels levels;
    for (unsigned i = 0; i < count; i += 16) {
        const unsigned lanes = 2 * (count - i);
        const std::uint32_t loaded = lanes >= 32 ? 0xffffffffU : (1U << lanes) - 1;
        add_levels(levels, _mm512_maskz_loadu_epi32(static_cast<__mmask16>(loaded), points + i),
                   _mm512_maskz_loadu_epi32(static_cast<__mmask16>(loaded >> 16), points + i + 8), level, i);
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

#endif

}  // namespace

std::span<const Form<AddEdges>> add_edges_forms() noexcept {
    static constexpr Form<AddEdges> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx512, add_edges_avx512},
        {InstructionSet::avx2, add_edges_avx2},
#endif
        {InstructionSet::portable, add_edges_portable}};
    return forms;
}

namespace {

/// Up to so many queries are tested one by one.
constexpr std::uint32_t few_queries = 16;

/// Those of a few edges that reach a step with a point.
struct Reaches {
    static constexpr std::uint32_t most = 128;

    std::uint32_t edge[most];   ///< from points[edge[i]] to points[edge[i] + 1]
    std::uint32_t begin[most];  ///< the points whose steps it reaches
    std::uint32_t end[most];

    /// Of the `count` <= most edges from points[0] to points[count]. Returns how many. No branch on whether an edge reaches
    /// a point: it would be mispredicted.
    std::size_t find(const QuerySteps& steps, const Point* points, std::uint32_t count) noexcept {
        std::size_t found = 0;
        std::uint32_t from = steps.ends[steps.of(points[0].y)];
        std::uint32_t to = steps.ends[steps.of(points[0].y) + 1];
        for (std::uint32_t e = 0; e < count; ++e) {
            const std::uint32_t step = steps.of(points[e + 1].y);
            const std::uint32_t next_from = steps.ends[step];
            const std::uint32_t next_to = steps.ends[step + 1];
            edge[found] = e;
            begin[found] = from < next_from ? from : next_from;
            end[found] = to < next_to ? next_to : to;
            found += begin[found] < end[found] ? 1U : 0U;
            from = next_from;
            to = next_to;
        }
        return found;
    }
};

}  // namespace

void ManyInside::test(const Point* points, std::uint32_t count, Vector<std::uint32_t>& inside) {
    if (queries_.empty()) {
        return;
    }
    const QuerySteps steps = sort_by_step();
    const Point closing[] = {points[count - 1], points[0]};
    add_edges(steps, points, count - 1);
    add_edges(steps, closing, 1);
    for (const Query& query : by_y_) {
        if (query.winding.strictly_inside()) {
            inside.push_back(query.number);
        }
    }
}

/// Sorts the queries by y into by_y_. There are several times as many steps as queries, so most hold one or none.
QuerySteps ManyInside::sort_by_step() {
    constexpr std::size_t fewest_steps = 64;
    constexpr std::size_t most_steps = std::size_t{1} << 14;
    std::int32_t low = grid_limit;
    std::int32_t high = -grid_limit;
    for (const Query& query : queries_) {
        low = std::min(low, query.winding.query().y);
        high = std::max(high, query.winding.query().y);
    }
    const std::size_t count = std::clamp(std::bit_ceil(8 * queries_.size()), fewest_steps, most_steps);
    const auto range = static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low);
    const int shift = std::max(0, static_cast<int>(std::bit_width(range)) - std::countr_zero(count));
    ends_.assign(count + 3, 0);
    // A 64th of the range beyond it: far within 32 bits.
    const QuerySteps steps{low - (1 << shift), high + (1 << shift), shift, ends_.data()};
    std::uint32_t longest = 0;
    for (const Query& query : queries_) {
        longest = std::max(longest, ++ends_[steps.of(query.winding.query().y) + 1]);
    }
    std::exclusive_scan(ends_.begin(), ends_.end(), ends_.begin(), 0U);
    by_y_.resize(queries_.size());
    for (const Query& query : queries_) {
        by_y_[ends_[steps.of(query.winding.query().y) + 1]++] = query;
    }
    if (longest > few_queries) {
        sort_long_steps();
    }
    for (std::size_t i = 1; i < by_y_.size(); ++i) {  // only short steps are still unsorted
        for (std::size_t place = i; place > 0 && lower(by_y_[place], by_y_[place - 1]); --place) {
            std::swap(by_y_[place], by_y_[place - 1]);
        }
    }
    return steps;
}

void ManyInside::sort_long_steps() {
    for (std::size_t step = 0; step + 1 < ends_.size(); ++step) {
        if (ends_[step + 1] - ends_[step] > few_queries) {
            std::sort(by_y_.begin() + ends_[step], by_y_.begin() + ends_[step + 1], lower);
        }
    }
}

/// Adds the edges from points[0] to points[count] to the queries whose steps they reach. Those of a run that reach one are
/// found first.
void ManyInside::add_edges(const QuerySteps& steps, const Point* points, std::uint32_t count) {
    Reaches reaches;
    for (std::uint32_t first = 0; first < count; first += Reaches::most) {
        const Point* run = points + first;
        std::size_t met = 0;
        const std::size_t reaching = reaches.find(steps, run, std::min(count - first, Reaches::most));
        for (std::size_t i = 0; i < reaching; ++i) {
            const Point* edge = run + reaches.edge[i];
            add_edge(edge[0], edge[1], reaches.begin[i], reaches.end[i]);
            met += reaches.end[i] - reaches.begin[i];
        }
        worker_.spend(Reaches::most + met);
    }
}

/// Adds the edge to by_y_[begin] to by_y_[end].
inline void ManyInside::add_edge(Point a, Point b, std::uint32_t begin, std::uint32_t end) {
    auto from = by_y_.begin() + begin;
    auto to = by_y_.begin() + end;
    if (end - begin > few_queries) {
        const auto [low, high] = std::minmax(a.y, b.y);
        from = std::partition_point(from, to, [low = low](const Query& query) { return query.winding.query().y < low; });
        to = std::partition_point(from, to, [high = high](const Query& query) { return query.winding.query().y <= high; });
    }
    for (; from != to; ++from) {
        from->winding.add(a, b);
    }
}

}  // namespace lamella::nesting
