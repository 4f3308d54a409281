#include "slicing/sections/near_plane.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lamella {

namespace {

constexpr std::uint64_t lattice_side = 64;  // cells along an axis
constexpr std::size_t cells = lattice_side * lattice_side * lattice_side;

/// Each of the lowest six bits three places from the one before.
std::uint32_t spread(std::uint32_t bits) noexcept {
    bits = (bits | bits << 8) & 0x300F;
    bits = (bits | bits << 4) & 0x30C3;
    return (bits | bits << 2) & 0x9249;
}

double height_of(const PlaneReach& plane, const std::array<double, 3>& at) noexcept {
    return plane.row[0] * at[0] + plane.row[1] * at[1] + plane.row[2] * at[2] + plane.row[3];
}

}  // namespace

bool NearPlane::CentredBox::meets(const PlaneReach& plane) const noexcept {
    const double reach =
        std::abs(plane.row[0]) * half[0] + std::abs(plane.row[1]) * half[1] + std::abs(plane.row[2]) * half[2];
    return std::abs(height_of(plane, middle)) <= reach + plane.room;
}

NearPlane::CentredBox NearPlane::CentredBox::around(const Bounds& bounds) noexcept {
    CentredBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.middle[axis] = bounds.min_mm[axis] / 2 + bounds.max_mm[axis] / 2;
        box.half[axis] = bounds.max_mm[axis] - box.middle[axis];
        box.half[axis] += box.half[axis] * 0x1p-50;  // for its rounding
    }
    return box;
}

NearPlane::NearPlane(const MeshView& mesh, const Bounds& bounds, const Parallel& parallel)
    : mesh_(mesh),
      reader_(mesh, placing_of(mesh, {})),
      order_(mesh.triangle_count, 0, parallel.memory()),
      runs_(runs_in(mesh.triangle_count), Run(), parallel.memory()),
      boxes_(runs_in(mesh.triangle_count), CentredBox(), parallel.memory()),
      larger_(runs_in(boxes_.size()), CentredBox(), parallel.memory()) {
    sort_along_curve(bounds, parallel);
    parallel.run(larger_.size(), [&](std::size_t l, int) {
        Bounds of_all = Bounds::empty();
        for (std::size_t b = run * l; b < std::min(run * (l + 1), boxes_.size()); ++b) {
            Bounds own = Bounds::empty();
            for (std::size_t i = run * b; i < std::min(run * (b + 1), order_.size()); ++i) {
                for (std::size_t corner = 0; corner < 3; ++corner) {
                    const std::array<double, 3> at = reader_.corner(order_[i], corner);
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        own.add(static_cast<int>(axis), at[axis], at[axis]);
                        runs_[b].corners[corner][axis][i - run * b] = static_cast<float>(at[axis]);
                    }
                }
            }
            boxes_[b] = CentredBox::around(own);
            of_all.add(own);
        }
        larger_[l] = CentredBox::around(of_all);
    });
}

/// By the cells of a lattice that first corners lie in: counted, then each put in its place.
void NearPlane::sort_along_curve(const Bounds& bounds, const Parallel& parallel) {
    std::array<double, 3> scale{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double extent = bounds.max_mm[axis] - bounds.min_mm[axis];
        scale[axis] = extent > 0 ? static_cast<double>(lattice_side - 1) / extent : 0;
    }
    Vector<std::uint32_t> cell_of(order_.size(), 0, parallel.memory());
    parallel.run_ranges(order_.size(), 4096, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t t = begin; t < end; ++t) {
            const std::array<double, 3> at = reader_.corner(t, 0);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                cell_of[t] =
                    cell_of[t] << 1 | spread(static_cast<std::uint32_t>((at[axis] - bounds.min_mm[axis]) * scale[axis]));
            }
        }
    });
    Vector<std::size_t> next(cells + 1, 0, parallel.memory());
    for (const std::uint32_t cell : cell_of) {
        ++next[cell + 1];
    }
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::size_t t = 0; t < order_.size(); ++t) {
        order_[next[cell_of[t]]++] = t;
    }
}

void NearPlane::find(const PlaneReach& plane, Vector<std::size_t>& found) const {
    found.clear();
    for (std::size_t l = 0; l < larger_.size(); ++l) {
        if (larger_[l].meets(plane)) {
            for (std::size_t b = run * l; b < std::min(run * (l + 1), boxes_.size()); ++b) {
                if (boxes_[b].meets(plane)) {
                    find_in(b, plane, found);
                }
            }
        }
    }
}

void NearPlane::find_in(std::size_t b, const PlaneReach& plane, Vector<std::size_t>& found) const {
    const auto row = [&plane](std::size_t axis) { return static_cast<float>(plane.row[axis]); };
    const auto room = static_cast<float>(plane.room * (1 + 0x1p-20));
    const auto& [first, second, third] = runs_[b].corners;
    std::array<std::uint8_t, run> is_near{};
    for (std::size_t i = 0; i < run; ++i) {
        const auto height = [&](const auto& xyz) {
            return row(0) * xyz[0][i] + row(1) * xyz[1][i] + row(2) * xyz[2][i] + row(3);
        };
        const float a = height(first);
        const float other = height(second);
        const float last = height(third);
        const float low = std::min(std::min(a, other), last);
        const float high = std::max(std::max(a, other), last);
        is_near[i] = static_cast<std::uint8_t>(static_cast<int>(low <= room) & static_cast<int>(high >= -room));
    }
    for (std::size_t i = 0; i < std::min(run, order_.size() - run * b); ++i) {
        if (is_near[i] != 0) {
            found.push_back(order_[run * b + i]);
        }
    }
}

}  // namespace lamella
