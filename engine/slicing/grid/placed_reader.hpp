// Triangles read from the caller's memory, and moved by the transform.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/rounding.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"

namespace lamella {

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

}  // namespace lamella
