#include "7_nesting/inside.hpp"

#include <algorithm>
#include <bit>

#if defined(__x86_64__) && defined(__GNUC__)
#define LAMELLA_AVX2 1
#include <immintrin.h>
#endif

namespace lamella::nesting {

namespace {

/// Winding number of a contour around a point, by the ray from the point towards +x: an edge that crosses it upwards counts
/// one, downwards minus one. Only edges that straddle the point's y, or begin at it, need be shown.
class Winding {
public:
    explicit Winding(Point query) noexcept : query_(query) {}

    void add(Point a, Point b) noexcept {
        const bool a_above = a.y > query_.y;
        const bool b_above = b.y > query_.y;
        if (a_above != b_above) {
            const int side = side_of(a, b, query_);
            on_boundary_ |= side == 0;
            number_ += (b_above && side > 0) - (a_above && side < 0);
        } else if (a.y == query_.y) {
            const auto [low, high] = std::minmax(a.x, b.x);
            on_boundary_ |= a.x == query_.x || (b.y == query_.y && low <= query_.x && query_.x <= high);
        }
    }
    bool strictly_inside() const noexcept { return number_ != 0 && !on_boundary_; }

private:
    Point query_;
    int number_ = 0;
    bool on_boundary_ = false;
};

/// The edges from `first` on, the closing one included.
bool finish(Winding winding, const Point* points, std::uint32_t first, std::uint32_t count) noexcept {
    for (std::uint32_t i = first; i + 1 < count; ++i) {
        winding.add(points[i], points[i + 1]);
    }
    winding.add(points[count - 1], points[0]);
    return winding.strictly_inside();
}

#ifdef LAMELLA_AVX2

/// Lanes are x0 y0 x1 y1 x2 y2 x3 y3; a double's sign is a y lane's, so movemask_pd reads the four answers for y:
///     bit i = edge (i, i+1) straddles the query's y, or point i lies at it.
__attribute__((target("avx2"))) inline __m256i edges_at(const Point* points, __m256i query) noexcept {
    const __m256i from = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(points));
    const __m256i to = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(points + 1));
    const __m256i straddles = _mm256_xor_si256(_mm256_cmpgt_epi32(from, query), _mm256_cmpgt_epi32(to, query));
    return _mm256_or_si256(straddles, _mm256_cmpeq_epi32(from, query));
}

__attribute__((target("avx2"))) inline unsigned y_bits(__m256i lanes) noexcept {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_castsi256_pd(lanes)));
}

__attribute__((target("avx2"))) bool strictly_inside_avx2(const Point* points, std::uint32_t count, Point query) noexcept {
    Winding winding(query);
    const __m256i level = _mm256_set1_epi32(query.y);
    std::uint32_t i = 0;
    for (; i + 16 < count; i += 16) {
        unsigned bits = y_bits(edges_at(points + i, level)) | y_bits(edges_at(points + i + 4, level)) << 4 |
                        y_bits(edges_at(points + i + 8, level)) << 8 | y_bits(edges_at(points + i + 12, level)) << 12;
        for (; bits != 0; bits &= bits - 1) {
            const Point* edge = points + i + std::countr_zero(bits);
            winding.add(edge[0], edge[1]);
        }
    }
    for (; i + 4 < count; i += 4) {
        for (unsigned bits = y_bits(edges_at(points + i, level)); bits != 0; bits &= bits - 1) {
            const Point* edge = points + i + std::countr_zero(bits);
            winding.add(edge[0], edge[1]);
        }
    }
    return finish(winding, points, i, count);
}

#endif

}  // namespace

bool strictly_inside(const Point* points, std::uint32_t count, Point query) noexcept {
    return finish(Winding(query), points, 0, count);
}

InsideTest best_inside_test() noexcept {
#ifdef LAMELLA_AVX2
    if (__builtin_cpu_supports("avx2") != 0) {
        return strictly_inside_avx2;
    }
#endif
    return strictly_inside;
}

}  // namespace lamella::nesting
