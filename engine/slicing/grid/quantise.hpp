// Triangles read from the caller's memory and rounded to the grid (paper 3.1), one at a time. They are not stored: most
// triangles of a fine mesh meet no plane, and a rounded copy of them would cost more than slicing. Vertices that triangles
// share are another matter: see buckets/mesh_source.hpp.
#pragma once

#include <array>

#include "base/rounding.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "slicing/grid/placed_reader.hpp"

namespace lamella {

using GridTriangle = std::array<GridVertex, 3>;

inline bool is_degenerate(const GridTriangle& t) noexcept {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// mm to the even grid. Division, not multiplication by a reciprocal: units that are no power of two must round alike
/// everywhere.
inline std::int32_t to_even_grid(double mm, double unit_mm) noexcept {
    return 2 * round_to_int(mm / (2 * unit_mm));
}

#ifdef __SSE2__
/// Each argument holds x, y, z and an unused lane. Every vertex is written by one store: a load that spans two stores would
/// wait until both have reached the cache.
inline void store_vertices(GridTriangle& grid, __m128i first, __m128i second, __m128i third) noexcept {
    static_assert(sizeof(GridTriangle) == 9 * sizeof(std::int32_t), "nine coordinates without padding");
    auto* out = reinterpret_cast<std::int32_t*>(grid.data());
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), first);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 3), second);
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out + 6), third);
    out[8] = _mm_cvtsi128_si32(_mm_shuffle_epi32(third, _MM_SHUFFLE(2, 2, 2, 2)));
}
#endif

/// Any mesh, transform and unit.
class GeneralReader {
public:
    GeneralReader(const MeshView& mesh, const Placing& placing, double unit_mm) noexcept
        : placed_(mesh, placing), unit_mm_(unit_mm) {}

    GridTriangle operator()(std::size_t t) const noexcept {
        GridTriangle grid;
#ifdef __SSE2__
        store_vertices(grid, even_vertex(t, 0), even_vertex(t, 1), even_vertex(t, 2));
#else
        const RawTriangle raw = placed_(t);
        for (std::size_t i = 0; i < 3; ++i) {
            grid[i] = {to_even_grid(raw.v[3 * i], unit_mm_), to_even_grid(raw.v[3 * i + 1], unit_mm_),
                       to_even_grid(raw.v[3 * i + 2], unit_mm_)};
        }
#endif
        return grid;
    }

private:
#ifdef __SSE2__
    /// to_even_grid() of a vertex.
    __m128i even_vertex(std::size_t t, std::size_t corner) const noexcept {
        const auto [xy, z] = placed_.vertex(t, corner);
        const __m128d spacing = _mm_set1_pd(2 * unit_mm_);
        const __m128i half =
            _mm_unpacklo_epi64(_mm_cvtpd_epi32(_mm_div_pd(xy, spacing)), _mm_cvtpd_epi32(_mm_div_pd(z, spacing)));
        return _mm_add_epi32(half, half);
    }
#endif

    PlacedReader placed_;
    double unit_mm_;
};

#ifdef __SSE2__
/// Float vertices, no transform, a unit that is a power of two: scaling is then exact in float, and a vertex is one
/// multiplication and one conversion. Nothing is read beyond a triangle:
///
///     x0 y0 z0 x1 y1 z1 x2 y2 z2
///     [---a-----]    [---c-----]
///              [---b-----]
class FloatReader {
public:
    FloatReader(const MeshView& mesh, double unit_mm) noexcept
        : mesh_(mesh), scale_(_mm_set1_ps(static_cast<float>(1 / (2 * unit_mm)))) {}

    GridTriangle operator()(std::size_t t) const noexcept { return mesh_.indices == nullptr ? soup(t) : indexed(t); }

private:
    __m128i round_even(__m128 mm) const noexcept {
        const __m128i half = _mm_cvtps_epi32(_mm_mul_ps(mm, scale_));
        return _mm_add_epi32(half, half);
    }

    GridTriangle soup(std::size_t t) const noexcept {
        const auto* at = reinterpret_cast<const float*>(mesh_.vertex_at(t));
        const __m128 c = _mm_loadu_ps(at + 5);
        GridTriangle grid;
        store_vertices(grid, round_even(_mm_loadu_ps(at)), round_even(_mm_loadu_ps(at + 3)),
                       round_even(_mm_shuffle_ps(c, c, _MM_SHUFFLE(3, 3, 2, 1))));
        return grid;
    }

    __m128i vertex(std::size_t index) const noexcept {
        const std::byte* at = mesh_.vertex_at(index);
        return round_even(_mm_movelh_ps(load_two_floats(at), load_float(at + 2 * sizeof(float))));
    }

    GridTriangle indexed(std::size_t t) const noexcept {
        GridTriangle grid;
        store_vertices(grid, vertex(mesh_.vertex_of(t, 0)), vertex(mesh_.vertex_of(t, 1)), vertex(mesh_.vertex_of(t, 2)));
        return grid;
    }

    MeshView mesh_;
    __m128 scale_;
};
#endif

/// Calls use(reader) with the fastest reader for this input; all give the same grid triangles.
template <class Use>
decltype(auto) with_reader(const MeshView& mesh, const Placing& placing, double unit_mm, Use&& use) {
#ifdef __SSE2__
    int exponent = 0;
    if (mesh.vertex_type == Number::f32 && placing.transform.is_identity() && std::frexp(unit_mm, &exponent) == 0.5) {
        return use(FloatReader(mesh, unit_mm));
    }
#endif
    return use(GeneralReader(mesh, placing, unit_mm));
}

}  // namespace lamella
