// Triangles read from the caller's memory and rounded to the grid (paper 3.1), one at a time. They are not stored: most
// triangles of a fine mesh meet no plane, and a rounded copy of them would cost more than slicing. Vertices that triangles
// share are another matter: see buckets/mesh_source.hpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/system/lanes.hpp"
#include "base/system/processor.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"

namespace lamella {

// Triangles read from the caller's memory, and moved by the transform.

/// Vertices of one triangle as doubles.
struct RawTriangle {
    double v[9];
};

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
        const auto& m = placing.transform.m;
        for (std::size_t c = 0; c < 4; ++c) {
            doubles_[c] = {TwoDoubles{m[c], m[4 + c]}, TwoDoubles{m[8 + c], 0}};
            floats_[c] = FourFloats{static_cast<float>(m[c]), static_cast<float>(m[4 + c]), static_cast<float>(m[8 + c]), 0};
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

    struct Vertex {
        TwoDoubles xy;
        TwoDoubles z;  ///< and an unused lane
    };

    Vertex vertex(std::size_t t, std::size_t corner) const noexcept {
        if (number() == Number::f64) {
            return placed(in_doubles<double>(t, corner));
        }
        if (number() != Number::f32) {
            return placed(number() == Number::i32 ? in_doubles<std::int32_t>(t, corner)
                                                  : in_doubles<std::int64_t>(t, corner));
        }
        return in_floats_ && !identity_ ? moved_in_floats(t, corner) : placed(in_doubles<float>(t, corner));
    }

private:
    /// Gives x, y and z of a corner one by one: a copy of all three would be stored before it is loaded.
    template <class T>
    auto coordinates(std::size_t t, std::size_t corner) const noexcept {
        const std::byte* const at = mesh_.indices != nullptr ? mesh_.vertex_at(mesh_.vertex_of(t, corner))
                                                             : mesh_.vertex_at(t) + corner * 3 * sizeof(T);
        return [at](std::size_t axis) {
            T value;
            std::memcpy(&value, at + axis * sizeof value, sizeof value);
            return value;
        };
    }

    template <class T>
    Vertex in_doubles(std::size_t t, std::size_t corner) const noexcept {
        const auto given = coordinates<T>(t, corner);
        return {TwoDoubles{static_cast<double>(given(0)), static_cast<double>(given(1))},
                TwoDoubles{static_cast<double>(given(2)), 0}};
    }

    Vertex placed(const Vertex& given) const noexcept { return identity_ ? given : moved(given); }

    void place(std::size_t t, std::size_t corner, double* to) const noexcept {
        const Vertex placed = vertex(t, corner);
        std::memcpy(to, &placed.xy, sizeof placed.xy);
        to[2] = placed.z[0];
    }

    Vertex moved_in_floats(std::size_t t, std::size_t corner) const noexcept {
        const auto given = coordinates<float>(t, corner);
        const FourFloats at = floats_[0] * given(0) + floats_[1] * given(1) + floats_[2] * given(2) + floats_[3];
        return {TwoDoubles{at[0], at[1]}, TwoDoubles{at[2], 0}};
    }

    Vertex moved(const Vertex& v) const noexcept {
        const TwoDoubles x{v.xy[0], v.xy[0]};
        const TwoDoubles y{v.xy[1], v.xy[1]};
        const TwoDoubles z{v.z[0], v.z[0]};
        const auto& d = doubles_;
        return {d[0].xy * x + d[1].xy * y + d[2].xy * z + d[3].xy, d[0].z * x + d[1].z * y + d[2].z * z + d[3].z};
    }

    MeshView mesh_;
    bool identity_;
    bool in_floats_;
    // The columns of the matrix:
    std::array<Vertex, 4> doubles_{};
    std::array<FourFloats, 4> floats_{};
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

/// Reads triangles of any mesh onto the grid. `multiplies`: the unit is a power of two, which has an exact reciprocal.
template <bool multiplies = false>
class GridReader {
public:
    GridReader(const MeshView& mesh, const Placing& placing, double unit_mm) noexcept
        : placed_(mesh, placing), scale_(multiplies ? 1 / (2 * unit_mm) : 2 * unit_mm) {}

    GridTriangle operator()(std::size_t t) const noexcept { return {vertex(t, 0), vertex(t, 1), vertex(t, 2)}; }

private:
    /// to_even_grid() of a vertex.
    GridVertex vertex(std::size_t t, std::size_t corner) const noexcept {
        const auto half = [this](TwoDoubles mm) { return multiplies ? mm * scale_ : mm / scale_; };
        const auto [xy, z] = placed_.vertex(t, corner);
        const TwoDoubles half_xy = half(xy);
        return {2 * round_to_int(half_xy[0]), 2 * round_to_int(half_xy[1]), 2 * round_to_int(half(z)[0])};
    }

    PlacedReader placed_;
    double scale_;
};

#ifdef LAMELLA_SSE2
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
        float xyz[3];
        std::memcpy(xyz, mesh_.vertex_at(index), sizeof xyz);
        return round_even(_mm_setr_ps(xyz[0], xyz[1], xyz[2], 0));
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
    if constexpr (!small_code) {
        int exponent = 0;
        if (std::frexp(unit_mm, &exponent) == 0.5) {
#ifdef LAMELLA_SSE2
            if (mesh.vertex_type == Number::f32 && placing.transform.is_identity()) {
                return use(FloatReader(mesh, unit_mm));
            }
#endif
            return use(GridReader<true>(mesh, placing, unit_mm));
        }
    }
    return use(GridReader<false>(mesh, placing, unit_mm));
}

}  // namespace lamella
