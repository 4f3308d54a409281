// Triangles read from the caller's memory and rounded to the grid (paper 3.1), one at a time. They are not stored: most
// triangles of a fine mesh meet no plane, and a rounded copy of them would cost more than slicing. Vertices that triangles
// share are another matter: see buckets/mesh_source.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/rounding.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"

namespace lamella {

// Triangles read from the caller's memory, and moved by the transform.

/// Vertices of one triangle as doubles.
struct RawTriangle {
    double v[9];
};

#ifdef __SSE2__
/// From any alignment.
inline __m128d load_double(const std::byte* at) noexcept {
    double value;
    std::memcpy(&value, at, sizeof value);
    return _mm_set_sd(value);
}
inline __m128 load_float(const std::byte* at) noexcept {
    float value;
    std::memcpy(&value, at, sizeof value);
    return _mm_set_ss(value);
}
inline __m128 load_two_floats(const std::byte* at) noexcept {
    return _mm_castpd_ps(load_double(at));
}
#endif

/// From a mesh's coordinates to the space of planes and points.
struct Placing {
    Transform transform{};
    bool as_mesh_numbers = false;  ///< see Frame
};

/// The frame's transform, after the mesh's own unit has become mm.
inline Placing placing_of(const MeshView& mesh, const Frame& frame) noexcept {
    const bool in_mm = mesh.mm_per_unit == 1;
    return {in_mm ? frame.transform : frame.transform * Transform::scale(mesh.mm_per_unit), frame.as_mesh_numbers};
}

/// The same of a part, which `placement` moves first.
inline Placing placing_of(const MeshView& mesh, Frame frame, const Transform& placement) noexcept {
    frame.transform = frame.transform * placement;
    return placing_of(mesh, frame);
}

/// The type of coordinates that are placed, to which heights are rounded too.
inline Number placed_number(const MeshView& mesh, const Placing& placing) noexcept {
    const bool as_mesh = placing.transform.is_identity() || placing.as_mesh_numbers;
    return as_mesh && mesh.vertex_type == Number::f32 ? Number::f32 : Number::f64;
}

/// Any MeshView, placed. Every product is rounded and sums run from left to right, in vectors as without: the
/// bytes are those of a host's matrix of the same type times the vertex. Precondition: indices have been checked against
/// vertex_count.
class PlacedReader {
public:
    PlacedReader(const MeshView& mesh, const Placing& placing) noexcept
        : mesh_(mesh), identity_(placing.transform.is_identity()), in_floats_(placed_number(mesh, placing) == Number::f32) {
        for (std::size_t column = 0; column < 4; ++column) {
            for (std::size_t row = 0; row < 3; ++row) {
                doubles_[column][row] = placing.transform.m[4 * row + column];
                floats_[column][row] = static_cast<float>(doubles_[column][row]);
            }
        }
    }

    Number number() const noexcept { return mesh_.vertex_type; }

    RawTriangle operator()(std::size_t t) const noexcept {
        RawTriangle raw;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            place(t, corner, raw.v + 3 * corner);
        }
        return raw;
    }

    /// One vertex: x, y, z.
    std::array<double, 3> corner(std::size_t t, std::size_t corner) const noexcept {
        std::array<double, 3> xyz;
        place(t, corner, xyz.data());
        return xyz;
    }

#ifdef __SSE2__
    struct Vertex {
        __m128d xy;
        __m128d z;  ///< and an unused lane
    };

    Vertex vertex(std::size_t t, std::size_t corner) const noexcept {
        if (number() == Number::f64) {
            const std::byte* at = vertex_at(t, corner, 3 * sizeof(double));
            const Vertex given{_mm_loadu_pd(reinterpret_cast<const double*>(at)), load_double(at + 2 * sizeof(double))};
            return identity_ ? given : moved(given);
        }
        if (number() != Number::f32) {
            const Vertex given =
                number() == Number::i32 ? of_integers<std::int32_t>(t, corner) : of_integers<std::int64_t>(t, corner);
            return identity_ ? given : moved(given);
        }
        const std::byte* at = vertex_at(t, corner, 3 * sizeof(float));
        const __m128 given = _mm_movelh_ps(load_two_floats(at), load_float(at + 2 * sizeof(float)));
        if (in_floats_) {
            return in_doubles(identity_ ? given : moved(given));
        }
        return moved(in_doubles(given));
    }
#endif

private:
    template <class Number>
    using Columns = std::array<std::array<Number, 4>, 4>;  // the last row is unused

    /// Where a vertex of `vertex_bytes` lies.
    const std::byte* vertex_at(std::size_t t, std::size_t corner, std::size_t vertex_bytes) const noexcept {
        return mesh_.indices != nullptr ? mesh_.vertex_at(mesh_.vertex_of(t, corner))
                                        : mesh_.vertex_at(t) + corner * vertex_bytes;
    }

#ifdef __SSE2__
    void place(std::size_t t, std::size_t corner, double* to) const noexcept {
        const Vertex placed = vertex(t, corner);
        _mm_storeu_pd(to, placed.xy);
        _mm_store_sd(to + 2, placed.z);
    }

    template <class Integer>
    Vertex of_integers(std::size_t t, std::size_t corner) const noexcept {
        Integer xyz[3];
        std::memcpy(xyz, vertex_at(t, corner, sizeof xyz), sizeof xyz);
        return {_mm_set_pd(static_cast<double>(xyz[1]), static_cast<double>(xyz[0])),
                _mm_set_sd(static_cast<double>(xyz[2]))};
    }

    static Vertex in_doubles(__m128 xyz) noexcept {
        return {_mm_cvtps_pd(xyz), _mm_cvtps_pd(_mm_movehl_ps(xyz, xyz))};
    }

    __m128 moved(__m128 v) const noexcept {
        const auto product = [this](std::size_t column, __m128 number) {
            return _mm_mul_ps(_mm_loadu_ps(floats_[column].data()), number);
        };
        const __m128 xy = _mm_add_ps(product(0, _mm_shuffle_ps(v, v, _MM_SHUFFLE(0, 0, 0, 0))),
                                     product(1, _mm_shuffle_ps(v, v, _MM_SHUFFLE(1, 1, 1, 1))));
        const __m128 xyz = _mm_add_ps(xy, product(2, _mm_shuffle_ps(v, v, _MM_SHUFFLE(2, 2, 2, 2))));
        return _mm_add_ps(xyz, _mm_loadu_ps(floats_[3].data()));
    }

    Vertex moved(const Vertex& v) const noexcept {
        const __m128d x = _mm_unpacklo_pd(v.xy, v.xy);
        const __m128d y = _mm_unpackhi_pd(v.xy, v.xy);
        const __m128d z = _mm_unpacklo_pd(v.z, v.z);
        const auto rows = [&](std::size_t first) {
            const auto column = [&](std::size_t c) { return _mm_loadu_pd(doubles_[c].data() + first); };
            const __m128d xy = _mm_add_pd(_mm_mul_pd(column(0), x), _mm_mul_pd(column(1), y));
            return _mm_add_pd(_mm_add_pd(xy, _mm_mul_pd(column(2), z)), column(3));
        };
        return {rows(0), rows(2)};
    }
#else
    void place(std::size_t t, std::size_t corner, double* to) const noexcept {
        switch (number()) {
            case Number::f32:
                read<float>(t, corner, to);
                break;
            case Number::f64:
                read<double>(t, corner, to);
                break;
            case Number::i32:
                read<std::int32_t>(t, corner, to);
                break;
            case Number::i64:
                read<std::int64_t>(t, corner, to);
                break;
        }
        if (!identity_) {
            in_floats_ ? move(floats_, to) : move(doubles_, to);
        }
    }

    template <class T>
    void read(std::size_t t, std::size_t corner, double* to) const noexcept {
        T xyz[3];
        std::memcpy(xyz, vertex_at(t, corner, sizeof xyz), sizeof xyz);
        std::transform(xyz, xyz + 3, to, [](T number) { return static_cast<double>(number); });
    }

    template <class Number>
    static void move(const Columns<Number>& columns, double* p) noexcept {
        const auto x = static_cast<Number>(p[0]);
        const auto y = static_cast<Number>(p[1]);
        const auto z = static_cast<Number>(p[2]);
        for (std::size_t row = 0; row < 3; ++row) {
            p[row] = columns[0][row] * x + columns[1][row] * y + columns[2][row] * z + columns[3][row];
        }
    }
#endif

    MeshView mesh_;
    bool identity_;
    bool in_floats_;
    Columns<double> doubles_{};
    Columns<float> floats_{};
};

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
