// Box, area and volume, counts of edges, and the scale of the grid.
#include "lamella/mesh/inspect.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "lamella/mesh/scale.hpp"
#include "mesh/measure.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"

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

struct Measure {
    double six_volumes = 0;
    double two_areas = 0;
};

/// Volume as the sum of tetrahedra to the middle of the box: near, so that little cancels.
Measure measure(const MeshView& mesh, const Transform& transform, const VectorMm& middle, const Parallel& parallel) {
    const std::size_t chunks = (mesh.triangle_count + chunk_triangles - 1) / chunk_triangles;
    const PlacedReader read(mesh, transform);
    std::vector<Measure> parts(chunks);
    parallel.run(chunks, [&](std::size_t chunk, int) {
        Measure part;
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
    Measure sum;
    for (const Measure& part : parts) {
        sum.six_volumes += part.six_volumes;
        sum.two_areas += part.two_areas;
    }
    return sum;
}

Result<MeshInfo> inspect_or_throw(const MeshView& mesh, const InspectOptions& options) {
    const Parallel parallel(options.control);
    Result<MeshInfo> info = measure_mesh(mesh, options.transform, options.unit_mm, parallel, 0.1);
    if (!info) {
        return info;
    }
    parallel.begin_stage(0.99, 6);
    count_edges(mesh, options.transform, parallel, *info);
    if (info->degenerate == info->triangles) {
        return all_collapsed(info->triangles, info->unit_mm);
    }
    parallel.finish();
    return info;
}

constexpr double fewest_units = 1 << 20;  ///< along the diagonal
constexpr double coarsest_step = 0.1;     ///< of a detail

/// From the power of two below `value` to the next number of that type.
double number_step(double value, CoordinateType number) noexcept {
    return value == 0 ? 0 : std::ldexp(1.0, std::ilogb(value) - (number == CoordinateType::f32 ? 23 : 52));
}

}  // namespace

Result<MeshInfo> measure_mesh(const MeshView& mesh, const Transform& transform, double asked_mm, const Parallel& parallel,
                              double progress) {
    parallel.begin_stage(progress / 2);
    BlockTable blocks(nullptr);
    const Result<Bounds> bounds = measure_bounds(mesh, transform, asked_mm, parallel, blocks);
    if (!bounds) {
        return bounds.error();
    }
    const Bounds& box = bounds.value();
    const Result<ChosenUnit> unit = choose_unit(box, asked_mm);
    if (!unit) {
        return unit.error();
    }
    parallel.begin_stage(progress);
    const VectorMm middle{(box.min_mm[0] + box.max_mm[0]) / 2, (box.min_mm[1] + box.max_mm[1]) / 2,
                          (box.min_mm[2] + box.max_mm[2]) / 2};
    const Measure measured = measure(mesh, transform, middle, parallel);
    MeshInfo info;
    std::copy(std::begin(box.min_mm), std::end(box.min_mm), info.min_mm);
    std::copy(std::begin(box.max_mm), std::end(box.max_mm), info.max_mm);
    info.volume_mm3 = measured.six_volumes / 6;
    info.area_mm2 = measured.two_areas / 2;
    info.triangles = mesh.triangle_count;
    info.unit_mm = unit->mm;
    return info;
}

Result<MeshInfo> inspect(const MeshView& mesh, const InspectOptions& options) noexcept {
    return guarded(options.control, [&] { return inspect_or_throw(mesh, options); });
}

MeshScale judge_scale(const double (&min_mm)[3], const double (&max_mm)[3], CoordinateType number, double unit_mm,
                      double detail_mm) noexcept {
    MeshScale scale;
    for (int axis = 0; axis < 3; ++axis) {
        scale.farthest_mm = std::max({scale.farthest_mm, std::abs(min_mm[axis]), std::abs(max_mm[axis])});
    }
    scale.diagonal_mm = std::hypot(max_mm[0] - min_mm[0], max_mm[1] - min_mm[1], max_mm[2] - min_mm[2]);
    scale.number_step_mm = number_step(scale.farthest_mm, number);
    scale.finest_unit_mm = finest_unit(scale.farthest_mm);
    scale.coarse_grid = scale.diagonal_mm < fewest_units * unit_mm;
    scale.coarse_numbers = scale.number_step_mm > coarsest_step * detail_mm;
    return scale;
}

}  // namespace lamella
