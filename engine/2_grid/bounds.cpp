#include "2_grid/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "2_grid/quantise.hpp"
#include "lamella/grid.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = 1 << 14;  // triangles per task
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A box that grows, and whether something in it was not finite.
struct Partial {
    double min[3] = {infinity, infinity, infinity};
    double max[3] = {-infinity, -infinity, -infinity};
    bool finite = true;

    void add(int axis, double low, double high) noexcept {
        min[axis] = std::min(min[axis], low);
        max[axis] = std::max(max[axis], high);
    }
    void add(const Partial& other) noexcept {
        for (int axis = 0; axis < 3; ++axis) {
            add(axis, other.min[axis], other.max[axis]);
        }
        finite = finite && other.finite;
    }
};

Partial measure_general(const MeshView& mesh, const Transform& transform, std::size_t begin, std::size_t end) {
    const RawReader read(mesh);
    const bool identity = transform.is_identity();
    Partial box;
    double poison = 0;  // times zero: becomes NaN, and stays so, at the first value that is not finite
    for (std::size_t t = begin; t < end; ++t) {
        RawTriangle raw = read(t);
        if (!identity) {
            apply(transform, raw);
        }
        for (int i = 0; i < 9; ++i) {
            box.add(i % 3, raw.v[i], raw.v[i]);
            poison += raw.v[i] * 0.0;
        }
    }
    box.finite = poison == 0;
    return box;
}

#ifdef __SSE2__
/// Float soup without a transform, three vectors a triangle as in FloatReader.
Partial measure_float_soup(const MeshView& mesh, std::size_t begin, std::size_t end) {
    constexpr int axis_of_lane[3][4] = {{0, 1, 2, 0}, {1, 2, 0, 1}, {2, 0, 1, 2}};
    constexpr int offset[3] = {0, 4, 5};
    __m128 low[3];
    __m128 high[3];
    for (int v = 0; v < 3; ++v) {
        low[v] = _mm_set1_ps(std::numeric_limits<float>::infinity());
        high[v] = _mm_set1_ps(-std::numeric_limits<float>::infinity());
    }
    __m128 poison[3] = {_mm_setzero_ps(), _mm_setzero_ps(), _mm_setzero_ps()};  // one each: a sum waits for the one before
    for (std::size_t t = begin; t < end; ++t) {
        const auto* at = reinterpret_cast<const float*>(mesh.vertices + t * mesh.stride);
        for (int v = 0; v < 3; ++v) {
            const __m128 value = _mm_loadu_ps(at + offset[v]);
            low[v] = _mm_min_ps(low[v], value);
            high[v] = _mm_max_ps(high[v], value);
            poison[v] = _mm_add_ps(poison[v], _mm_mul_ps(value, _mm_setzero_ps()));
        }
    }
    Partial box;
    for (int v = 0; v < 3; ++v) {
        float lows[4];
        float highs[4];
        _mm_storeu_ps(lows, low[v]);
        _mm_storeu_ps(highs, high[v]);
        for (int lane = 0; lane < 4; ++lane) {
            box.add(axis_of_lane[v][lane], static_cast<double>(lows[lane]), static_cast<double>(highs[lane]));
        }
    }
    const __m128 sum = _mm_add_ps(poison[0], _mm_add_ps(poison[1], poison[2]));
    box.finite = _mm_movemask_ps(_mm_cmpeq_ps(sum, _mm_setzero_ps())) == 0xF;
    return box;
}
#endif

Partial measure_range(const MeshView& mesh, const Transform& transform, std::size_t begin, std::size_t end) {
#ifdef __SSE2__
    if (mesh.number == Number::f32 && mesh.indices == nullptr && transform.is_identity()) {
        return measure_float_soup(mesh, begin, end);
    }
#endif
    return measure_general(mesh, transform, begin, end);
}

std::string axis_text(int i) {
    return std::string("vertex ") + std::to_string(i / 3) + ", " + "xyz"[i % 3];
}

/// Finds the triangle that made the measurement unusable. Serial: it runs once, on input that is refused.
Error first_bad_coordinate(const MeshView& mesh, const Transform& transform) {
    const RawReader read(mesh);
    for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
        RawTriangle raw = read(t);
        apply(transform, raw);
        for (int i = 0; i < 9; ++i) {
            if (!(std::abs(raw.v[i]) <= largest_coordinate_mm)) {
                const char* what = std::isfinite(raw.v[i]) ? " is beyond 1e9 mm" : " is not finite";
                return {Code::bad_coordinate, "triangle " + std::to_string(t) + ", " + axis_text(i) + what,
                        static_cast<std::int64_t>(t)};
            }
        }
    }
    return {Code::bad_coordinate, "a coordinate is not finite or beyond 1e9 mm"};
}

/// The first triangle with an index that names no vertex, or -1.
std::int64_t first_bad_index(const MeshView& mesh, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
        const std::uint32_t* corner = mesh.indices + 3 * t;
        if (std::max({corner[0], corner[1], corner[2]}) >= mesh.vertex_count) {
            return static_cast<std::int64_t>(t);
        }
    }
    return -1;
}

}  // namespace

Result<Bounds> measure_bounds(const MeshView& mesh, const Transform& transform, const Parallel& parallel) {
    if (mesh.triangle_count == 0) {
        return Error{Code::empty_mesh, "the mesh has no triangles"};
    }
    if (mesh.triangle_count >= std::numeric_limits<std::uint32_t>::max()) {
        return Error{Code::invalid_argument, "the mesh has more than 2^32 - 2 triangles"};
    }
    const auto workers = static_cast<std::size_t>(parallel.threads());
    std::vector<Partial> partial(workers);
    std::vector<std::int64_t> bad_index(workers, std::numeric_limits<std::int64_t>::max());
    parallel.run_ranges(mesh.triangle_count, grain, [&](std::size_t begin, std::size_t end, int worker) {
        const auto w = static_cast<std::size_t>(worker);
        if (mesh.indices != nullptr) {
            if (const std::int64_t bad = first_bad_index(mesh, begin, end); bad >= 0) {
                bad_index[w] = std::min(bad_index[w], bad);
                return;
            }
        }
        partial[w].add(measure_range(mesh, transform, begin, end));
    });
    if (const std::int64_t bad = *std::min_element(bad_index.begin(), bad_index.end());
        bad != std::numeric_limits<std::int64_t>::max()) {
        return Error{Code::invalid_argument, "triangle " + std::to_string(bad) + " has an index beyond the last vertex",
                     bad};
    }
    Partial all;
    for (const Partial& p : partial) {
        all.add(p);
    }
    Bounds bounds{};
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        bounds.min_mm[axis] = all.min[axis];
        bounds.max_mm[axis] = all.max[axis];
        largest = std::max({largest, std::abs(all.min[axis]), std::abs(all.max[axis])});
    }
    if (!all.finite || !(largest <= largest_coordinate_mm)) {
        return first_bad_coordinate(mesh, transform);
    }
    return bounds;
}

Result<double> choose_unit(const Bounds& bounds, double asked_mm) {
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        largest = std::max({largest, std::abs(bounds.min_mm[axis]), std::abs(bounds.max_mm[axis])});
    }
    if (asked_mm == 0) {
        double unit = default_unit_mm;
        while (largest > unit * grid_limit) {
            unit *= 2;
        }
        return unit;
    }
    if (!(asked_mm > 0) || !(asked_mm <= largest_coordinate_mm) || asked_mm < 1e-15) {
        return Error{Code::invalid_argument, "the grid unit must be between 1e-15 and 1e9 mm"};
    }
    // Rounding moves a vertex by up to a unit; the limit keeps two of room.
    if (largest / asked_mm > grid_limit - 2) {
        return Error{Code::bad_coordinate, "the mesh reaches " + std::to_string(largest) + " mm, which a grid unit of " +
                                               std::to_string(asked_mm) + " mm cannot hold in 32 bits"};
    }
    return asked_mm;
}

}  // namespace lamella
