// Chooses the lattice whose isosurface has the requested numbers of triangles and crossings.
#include <algorithm>
#include <cmath>
#include <optional>

#include "models/lattice.hpp"

namespace lamella::models {

namespace {

// The requested size of the isosurface, in shape space.
struct Goal {
    double triangles = 0;            // upper bound
    std::optional<double> z_extent;  // sum over triangles: crossings times layer height
    double flatness = 1;             // dz / dx, unless z_extent decides it
};

struct Spacing {
    double dx = 0;
    double dz = 0;
};

// A fixed-point iteration for the lattice spacing. The number of triangles is about proportional to 1 / (dx dz), and
// their mean z extent to dz. It is damped where it oscillates, because the number of triangles jumps or the lattice is
// far from cubic.
class Correction {
public:
    explicit Correction(const Goal& goal) : goal_(goal) {}

    Spacing next(const Spacing& from, const SurfaceSize& size, double aim) {
        double excess = std::clamp(size.triangles / (goal_.triangles * aim), 0.05, 20.0);
        if (std::abs(excess - 1) > 0.02) {
            damping_ += last_excess_ != 0 && (excess > 1) != (last_excess_ > 1) ? 1 : 0;
            last_excess_ = excess;
        }
        for (int i = 0; i < std::min(damping_, 2); ++i) {
            excess = std::sqrt(excess);
        }
        if (!goal_.z_extent) {
            const double dx = from.dx * std::sqrt(excess);
            return {dx, dx * goal_.flatness};
        }
        const double wanted = *goal_.z_extent / goal_.triangles;
        const double mean = size.triangles > 0 ? size.z_extent / size.triangles : wanted;
        const double dz = from.dz * std::clamp(wanted / mean, 0.2, 5.0);
        return {from.dx * excess * from.dz / dz, dz};
    }

private:
    const Goal& goal_;
    double last_excess_ = 0;
    int damping_ = 0;
};

// True if the spacing gives more than one step in each direction and a number of nodes that can be visited.
bool sensible(const Field& field, const Spacing& spacing) {
    constexpr double most_nodes = 4e11;
    constexpr double most_plane_nodes = 2e7;
    const double plane_nodes = 4 * field.half_x * field.half_y / (spacing.dx * spacing.dx);
    return spacing.dx < 2 * std::min(field.half_x, field.half_y) && spacing.dz < 1 && plane_nodes < most_plane_nodes &&
           plane_nodes < most_nodes * spacing.dz;
}

struct Choice {
    Spacing spacing;
    SurfaceSize size;
    bool met = false;  // `size` meets the goal; otherwise it is the last size tried
};

// The extent after splitting. A split adds seven sixths of the triangle's extent, averaged over the height of its
// middle vertex.
double expected_extent(const SurfaceSize& size, const Goal& goal) {
    const double splits = std::max(goal.triangles - size.triangles, 0.0) / 2;
    return size.z_extent * (1 + splits / size.triangles * 7 / 6);
}

// Corrects the spacing first by sampled slabs, then by full counts, until one is at or just below the goal. Splits add
// the missing triangles.
Choice choose_spacing(Field& field, const Goal& goal) {
    constexpr int most_samples = 8;
    constexpr int most_counts = 24;
    constexpr double sampled_slabs = 64;
    const bool extents = goal.z_extent.has_value();
    double aim = 0.993;
    Correction correction(goal);
    // Starts from four triangles per square of a lattice step and three units of area.
    const double dx = std::sqrt(4 * 3 / (goal.triangles * goal.flatness));
    Spacing spacing{std::min(dx, field.half_y), std::min(dx * goal.flatness, 0.5)};
    for (int i = 0; i < most_samples && spacing.dz * 4 * sampled_slabs < 1 && sensible(field, spacing); ++i) {
        const auto stride = static_cast<std::uint32_t>(1 / (spacing.dz * sampled_slabs));
        const SurfaceSize size = measure(field, lattice_around(field, spacing.dx, spacing.dz), stride, extents);
        const Spacing next = correction.next(spacing, size, aim);
        const double step = std::max(std::abs(next.dx / spacing.dx - 1), std::abs(next.dz / spacing.dz - 1));
        spacing = next;
        if (step < 0.003) {
            break;
        }
    }
    Choice best;
    for (int i = 0; i < most_counts && sensible(field, spacing); ++i) {
        const SurfaceSize size = measure(field, lattice_around(field, spacing.dx, spacing.dz), 1, extents);
        const bool fits = size.triangles <= goal.triangles && 3 * size.triangles >= goal.triangles;
        const bool crossed = !extents || std::abs(expected_extent(size, goal) / *goal.z_extent - 1) < 0.03;
        if (!best.met || (fits && crossed && size.triangles > best.size.triangles)) {
            best = {spacing, size, fits && crossed};
        }
        if (best.met && best.size.triangles > 0.97 * aim * goal.triangles) {
            break;
        }
        spacing = correction.next(spacing, size, aim);
        aim *= 0.99;  // the same aim could miss in the same way again
    }
    return best;
}

double natural_width(Shape shape) {
    switch (shape) {
        case Shape::torus:
            return 2 * (0.36 / 0.8 + 0.14);
        case Shape::bone:
            return 0.32;
        default:
            return 1;
    }
}

}  // namespace

Plan plan_isosurface(const Recipe& recipe) {
    const std::shared_ptr<Field> field = make_field(recipe);
    const double width = natural_width(recipe.shape);
    const Scale scale{recipe.width_mm.value_or(recipe.height_mm * width) / width, recipe.height_mm};
    Goal goal;
    goal.triangles = static_cast<double>(recipe.triangles);
    goal.flatness = scale.xy / scale.z;
    if (recipe.segments) {
        goal.z_extent = static_cast<double>(*recipe.segments) * recipe.layer_height_mm / scale.z;
    }
    const Choice choice = choose_spacing(*field, goal);
    if (!choice.met) {
        return unreachable(recipe, choice.size.z_extent * scale.z / recipe.layer_height_mm);
    }
    const auto unsplit = static_cast<std::uint64_t>(choice.size.triangles);
    const Lattice lattice = lattice_around(*field, choice.spacing.dx, choice.spacing.dz);
    const std::uint64_t splits = (recipe.triangles - unsplit) / 2;
    return Surface{unsplit + 2 * splits, [=](const Consumer& consume) {
                       Emitter out(consume, unsplit, splits);
                       return march(*field, lattice, scale, out);
                   }};
}

}  // namespace lamella::models
