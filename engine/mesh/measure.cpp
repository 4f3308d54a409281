// Box, area and volume of a mesh, and the scale of its grid.
#include "mesh/check/finders.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

/// Sums are made per chunk and then over the chunks in order, so that they do not depend on threads.
constexpr std::size_t chunk_triangles = 8192;

struct VectorMm {
    double x = 0;
    double y = 0;
    double z = 0;
};

VectorMm operator-(const VectorMm& a, const VectorMm& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
double dot(const VectorMm& a, const VectorMm& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
VectorMm cross(const VectorMm& a, const VectorMm& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Fills in volume, as the sum of tetrahedra to the middle of the box, so near that little cancels, and area.
void add_faces(const MeshView& mesh, const Placing& placing, const Parallel& parallel, MeshCheck& check) {
    struct Sums {
        double six_volumes = 0;
        double two_areas = 0;
    };
    const auto& [low, high] = check.box;
    const VectorMm middle{(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
    const std::size_t chunks = (mesh.triangle_count + chunk_triangles - 1) / chunk_triangles;
    const PlacedReader read(mesh, placing);
    std::vector<Sums> parts(chunks);
    parallel.run(chunks, [&](std::size_t chunk, int) {
        Sums part;
        const std::size_t end = std::min(mesh.triangle_count, (chunk + 1) * chunk_triangles);
        for (std::size_t t = chunk * chunk_triangles; t != end; ++t) {
            const RawTriangle raw = read(t);
            const VectorMm a{raw.v[0], raw.v[1], raw.v[2]};
            const VectorMm normal =
                cross(VectorMm{raw.v[3], raw.v[4], raw.v[5]} - a, VectorMm{raw.v[6], raw.v[7], raw.v[8]} - a);
            part.six_volumes += dot(a - middle, normal);
            part.two_areas += std::sqrt(dot(normal, normal));
        }
        parts[chunk] = part;
    });
    Sums sum;
    for (const Sums& part : parts) {
        sum.six_volumes += part.six_volumes;
        sum.two_areas += part.two_areas;
    }
    check.volume_mm3 = sum.six_volumes / 6;
    check.area_mm2 = sum.two_areas / 2;
}

constexpr double fewest_units = 1 << 20;  ///< along the diagonal
constexpr double coarsest_step = 0.1;     ///< as a share of a detail

/// From the power of two below `value` to the next number of that type.
double number_step(double value, Number number) noexcept {
    return value == 0 ? 0 : std::ldexp(1.0, std::ilogb(value) - (number == Number::f32 ? 23 : 52));
}

}  // namespace

void measure_mesh(const MeshView& mesh, const Frame& frame, const Parallel& parallel, double progress, MeshCheck& check) {
    parallel.begin_stage(progress / 2);
    const SharedFrame chosen = choose_frame(mesh, frame, false, {}, parallel);
    check.box = box_of(chosen.bounds);
    check.triangles = mesh.triangle_count;
    check.grid_mm = chosen.unit.mm;
    parallel.begin_stage(progress);
    add_faces(mesh, placing_of(mesh, frame), parallel, check);
}

MeshScale judge_scale(const Box& box, Number number, double grid_mm, double detail_mm) noexcept {
    const auto& [low, high] = box;
    MeshScale scale;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        scale.farthest_mm = std::max({scale.farthest_mm, std::abs(low[axis]), std::abs(high[axis])});
    }
    scale.diagonal_mm = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    scale.number_step_mm = number_step(scale.farthest_mm, number);
    scale.finest_grid_mm = finest_unit(scale.farthest_mm);
    scale.coarse_grid = scale.diagonal_mm < fewest_units * grid_mm;
    scale.coarse_numbers = scale.number_step_mm > coarsest_step * detail_mm;
    return scale;
}

}  // namespace lamella
