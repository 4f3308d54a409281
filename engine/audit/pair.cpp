#include "audit/pair.hpp"

#include <algorithm>
#include <cmath>

namespace lamella {

namespace {

template <class T>
bool within(std::uint64_t first, std::uint64_t count, const Array<T>& array) {
    return first <= array.size() && count <= array.size() - first;
}

bool fits(const Bounds& bounds, double unit_mm) {
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        largest = std::max({largest, std::abs(bounds.min_mm[axis]), std::abs(bounds.max_mm[axis])});
    }
    return largest <= unit_mm * grid_limit;
}

}  // namespace

Status examine(const SliceResult& result) {
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        if (l > 0 && result.layers[l].plane <= result.layers[l - 1].plane) {
            return Error{ErrorCode::invalid_argument, "the result's planes do not ascend"};
        }
        if (!within(result.layers[l].first_contour, result.layers[l].contour_count, result.contours)) {
            return Error{ErrorCode::invalid_argument, "a layer of the result reaches past its contours"};
        }
    }
    for (const Contour& contour : result.contours) {
        if (!within(contour.first_point, contour.point_count, result.points)) {
            return Error{ErrorCode::invalid_argument, "a contour of the result reaches past its points"};
        }
    }
    return {};
}

Result<Bounds> examine(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel) {
    BlockTable blocks(nullptr);
    Result<Bounds> bounds = measure_bounds(mesh, transform, unit_mm, parallel, blocks);
    if (bounds && !fits(*bounds, unit_mm)) {
        return Error{ErrorCode::invalid_argument, "the mesh does not fit the result's grid"};
    }
    return bounds;
}

Result<Bounds> examine(const MeshView& mesh, const SliceResult& result, const Parallel& parallel) {
    if (mesh.triangle_count != result.summary.triangles) {
        return Error{ErrorCode::invalid_argument, "the result is not of this mesh"};
    }
    Result<Bounds> bounds = examine(mesh, result.frame, result.unit_mm, parallel);
    if (!bounds) {
        return bounds;
    }
    if (Status status = examine(result); !status) {
        return status.error();
    }
    return bounds;
}

}  // namespace lamella
