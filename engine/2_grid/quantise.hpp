// Stage 2: triangles read from the caller's memory and rounded to the grid (paper 3.1), one at a time and never stored:
// most triangles of a fine mesh meet no plane, and a quantised copy of them would cost more than slicing.
#pragma once

#include <array>
#include <cstring>

#include "base/rounding.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"

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

/// Vertices of one triangle as doubles in the caller's space.
struct RawTriangle {
    double v[9];
};

/// Any MeshView, number by number. Precondition: indices have been checked against vertex_count.
class RawReader {
public:
    explicit RawReader(const MeshView& mesh) noexcept : mesh_(mesh) {}

    RawTriangle operator()(std::size_t t) const noexcept {
        return mesh_.number == Number::f32 ? read<float>(t) : read<double>(t);
    }

private:
    template <class T>
    RawTriangle read(std::size_t t) const noexcept {
        RawTriangle raw;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::byte* at = mesh_.indices != nullptr ? mesh_.vertices + mesh_.indices[3 * t + corner] * mesh_.stride
                                                           : mesh_.vertices + t * mesh_.stride + corner * 3 * sizeof(T);
            T xyz[3];
            std::memcpy(xyz, at, sizeof xyz);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                raw.v[3 * corner + axis] = static_cast<double>(xyz[axis]);
            }
        }
        return raw;
    }

    MeshView mesh_;
};

inline void apply(const Transform& transform, RawTriangle& t) noexcept {
    const auto& m = transform.m;
    for (int corner = 0; corner < 3; ++corner) {
        double* p = t.v + 3 * corner;
        const double x = p[0];
        const double y = p[1];
        const double z = p[2];
        for (std::size_t row = 0; row < 3; ++row) {
            p[row] = m[4 * row] * x + m[4 * row + 1] * y + m[4 * row + 2] * z + m[4 * row + 3];
        }
    }
}

/// Any mesh, transform and unit.
class GeneralReader {
public:
    GeneralReader(const MeshView& mesh, const Transform& transform, double unit_mm) noexcept
        : raw_(mesh), transform_(transform), identity_(transform.is_identity()), unit_mm_(unit_mm) {}

    GridTriangle operator()(std::size_t t) const noexcept {
        RawTriangle raw = raw_(t);
        if (!identity_) {
            apply(transform_, raw);
        }
        GridTriangle grid;
        for (std::size_t i = 0; i < 3; ++i) {
            grid[i] = {to_even_grid(raw.v[3 * i], unit_mm_), to_even_grid(raw.v[3 * i + 1], unit_mm_),
                       to_even_grid(raw.v[3 * i + 2], unit_mm_)};
        }
        return grid;
    }

private:
    RawReader raw_;
    Transform transform_;
    bool identity_;
    double unit_mm_;
};

#ifdef __SSE2__
/// Float vertices, no transform, a unit that is a power of two: scaling is then exact in float, and nine coordinates are
/// three multiplications and three conversions. Two vectors overlap so that nothing is read beyond the triangle:
///
///     x0 y0 z0 x1 y1 z1 x2 y2 z2
///     [---a-----] [---b-----]
///                    [---c-----]
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
        return from_floats(reinterpret_cast<const float*>(mesh_.vertices + t * mesh_.stride));
    }

    GridTriangle indexed(std::size_t t) const noexcept {
        float xyz[9];
        for (std::size_t corner = 0; corner < 3; ++corner) {
            std::memcpy(xyz + 3 * corner, mesh_.vertices + mesh_.indices[3 * t + corner] * mesh_.stride, 3 * sizeof(float));
        }
        return from_floats(xyz);
    }

    GridTriangle from_floats(const float* at) const noexcept {
        GridTriangle grid;
        auto* out = reinterpret_cast<std::int32_t*>(grid.data());
        static_assert(sizeof(GridTriangle) == 9 * sizeof(std::int32_t), "nine coordinates without padding");
        _mm_storeu_si128(reinterpret_cast<__m128i*>(out), round_even(_mm_loadu_ps(at)));
        _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 4), round_even(_mm_loadu_ps(at + 4)));
        _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 5), round_even(_mm_loadu_ps(at + 5)));
        return grid;
    }

    MeshView mesh_;
    __m128 scale_;
};
#endif

/// Calls use(reader) with the fastest reader for this input; all give the same grid triangles.
template <class Use>
decltype(auto) with_reader(const MeshView& mesh, const Transform& transform, double unit_mm, Use&& use) {
#ifdef __SSE2__
    int exponent = 0;
    if (mesh.number == Number::f32 && transform.is_identity() && std::frexp(unit_mm, &exponent) == 0.5) {
        return use(FloatReader(mesh, unit_mm));
    }
#endif
    return use(GeneralReader(mesh, transform, unit_mm));
}

}  // namespace lamella
