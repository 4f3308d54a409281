#include "7_nesting/inside.hpp"

#include <bit>

#if defined(__x86_64__) && defined(__GNUC__)
#define LAMELLA_AVX2 1
#define LAMELLA_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline
#include <immintrin.h>
#endif

namespace lamella::nesting {

void add_edges_portable(Winding& winding, const Point* points, std::uint32_t count) noexcept {
    for (std::uint32_t i = 0; i < count; ++i) {
        winding.add(points[i], points[i + 1]);
    }
}

#ifdef LAMELLA_AVX2

namespace {

/// Lanes are x0 y0 x1 y1 x2 y2 x3 y3; a double's sign is a y lane's, so movemask_pd reads the four answers for y.
LAMELLA_AVX2_INLINE unsigned y_bits(__m256i lanes) noexcept {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_castsi256_pd(lanes)));
}

LAMELLA_AVX2_INLINE __m256i four_points(const Point* points) noexcept {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(points));
}

/// Which of the 16 edges from points[0] to points[16] must be shown:
///     bit i of `above` = point i lies above the query's y;   above ^ (above >> 1) = edge (i, i+1) straddles it.
/// Points at that very y are rare, so the four quads are first asked together.
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

__attribute__((target("avx2"))) void add_edges_avx2(Winding& winding, const Point* points, std::uint32_t count) noexcept {
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

/// The same with 16 points a step: compared lanes arrive as bits, x and y by turns, and the y bits are picked out.
__attribute__((target("avx512f,avx512vl,bmi2"))) unsigned edges_at_512(const Point* points, std::int32_t y) noexcept {
    const __m512i level = _mm512_set1_epi32(y);
    const __m512i low = _mm512_loadu_si512(points);
    const __m512i high = _mm512_loadu_si512(points + 8);
    const auto y_lanes = [](unsigned first, unsigned second) __attribute__((target("bmi2"))) {
        return _pext_u32(first | second << 16, 0xaaaaaaaaU);
    };
    const unsigned above = y_lanes(_mm512_cmpgt_epi32_mask(low, level), _mm512_cmpgt_epi32_mask(high, level)) |
                           static_cast<unsigned>(points[16].y > y) << 16;
    const unsigned at = y_lanes(_mm512_cmpeq_epi32_mask(low, level), _mm512_cmpeq_epi32_mask(high, level));
    return ((above ^ above >> 1) & 0xffffU) | at;
}

__attribute__((target("avx512f,avx512vl,bmi2"))) void add_edges_avx512(Winding& winding, const Point* points,
                                                                       std::uint32_t count) noexcept {
    if (count < 16) {
        add_edges_portable(winding, points, count);
        return;
    }
    Winding sum = winding;
    const std::int32_t y = sum.query().y;
    for (std::uint32_t i = 0; i < count; i += 16) {
        const std::uint32_t first = std::min(i, count - 16);  // the last run overlaps the one before
        for (unsigned edges = edges_at_512(points + first, y) >> (i - first) << (i - first); edges != 0;
             edges &= edges - 1) {
            const Point* edge = points + first + std::countr_zero(edges);
            sum.add(edge[0], edge[1]);
        }
    }
    winding = sum;
    _mm256_zeroupper();
}

}  // namespace

#endif

AddEdges best_add_edges() noexcept {
#ifdef LAMELLA_AVX2
    if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
        __builtin_cpu_supports("bmi2") != 0) {
        return add_edges_avx512;
    }
    if (__builtin_cpu_supports("avx2") != 0) {
        return add_edges_avx2;
    }
#endif
    return add_edges_portable;
}

namespace {

constexpr std::uint32_t divide_up(std::uint32_t count, std::uint32_t by) noexcept {
    return (count - 1) / by + 1;
}

}  // namespace

std::size_t EdgeIndex::add(const Point* points, std::uint32_t count) {
    const std::size_t handle = extents_.size();
    const std::uint32_t edges = count - 1;  // the closing edge is always looked at
    for (std::uint32_t first = 0; first < edges; first += run_edges) {
        Extent extent{points[first].y, points[first].y};
        const std::uint32_t last = std::min(first + run_edges, edges);
        for (std::uint32_t i = first + 1; i <= last; ++i) {
            extent.low = std::min(extent.low, points[i].y);
            extent.high = std::max(extent.high, points[i].y);
        }
        extents_.push_back(extent);
    }
    std::size_t below = handle;
    for (std::size_t size = extents_.size() - handle; size > runs_per_run; size = extents_.size() - below) {
        const std::size_t end = below + size;
        for (std::size_t first = below; first < end; first += runs_per_run) {
            Extent extent = extents_[first];
            for (std::size_t i = first + 1; i < std::min<std::size_t>(first + runs_per_run, end); ++i) {
                extent.low = std::min(extent.low, extents_[i].low);
                extent.high = std::max(extent.high, extents_[i].high);
            }
            extents_.push_back(extent);
        }
        below = end;
    }
    return handle;
}

bool EdgeIndex::strictly_inside(std::size_t handle, AddEdges add_edges, const Point* points, std::uint32_t count,
                                Point query) const noexcept {
    Winding winding(query);
    const std::uint32_t edges = count - 1;
    // Levels of up to 32 + 4 x 7 bits: the uppermost has at most 16 runs.
    std::uint32_t sizes[8];
    const Extent* levels[8];
    int top = 0;
    sizes[0] = divide_up(edges, run_edges);
    levels[0] = extents_.data() + handle;
    for (; sizes[top] > runs_per_run; ++top) {
        levels[top + 1] = levels[top] + sizes[top];
        sizes[top + 1] = divide_up(sizes[top], runs_per_run);
    }
    // Depth first; `next[level]` walks the runs below the run taken one level up.
    std::uint32_t next[8];
    std::uint32_t end[8];
    int level = top;
    next[top] = 0;
    end[top] = sizes[top];
    while (level <= top) {
        if (next[level] == end[level]) {
            ++level;
            continue;
        }
        const std::uint32_t run = next[level]++;
        const Extent extent = levels[level][run];
        if (query.y < extent.low || extent.high < query.y) {
            continue;
        }
        if (level == 0) {
            const std::uint32_t first = run * run_edges;
            add_edges(winding, points + first, std::min(run_edges, edges - first));
        } else {
            --level;
            next[level] = run * runs_per_run;
            end[level] = std::min(next[level] + runs_per_run, sizes[level]);
        }
    }
    winding.add(points[count - 1], points[0]);
    return winding.strictly_inside();
}

}  // namespace lamella::nesting
