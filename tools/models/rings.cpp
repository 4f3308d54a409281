// Sphere and prism: rings of equal numbers of points, one above the other, joined by rows of triangles.
//
//      row j:   upper ring   u0----u1----u2
//                             | \   | \   |      each quad is (l0, l1, u0) and (l1, u1, u0),
//               lower ring   l0----l1----l2      counter-clockwise as seen from outside
//
// A sphere ends in poles (fans of `points` triangles), a prism in flat caps (zigzags of `points` - 2).
#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "models/numbers.hpp"
#include "models/surface.hpp"

namespace lamella::models {

namespace {

constexpr std::size_t batch_triangles = 1 << 16;

// Splitting a triangle in three adds 7/6 of its z extent to the sum of extents, averaged over the height of its middle
// vertex.
constexpr double split_extent_gain = 7.0 / 6;

struct RingSizes {
    std::uint64_t points = 0;  // in each ring
    std::uint64_t rows = 0;
    std::uint64_t splits = 0;
    double segments = 0;  // expected number, at the recipe's layer height
};

class Rings {
public:
    Rings(const Recipe& recipe, const RingSizes& sizes)
        : sphere_(recipe.shape == Shape::sphere),
          height_(recipe.height_mm),
          radius_(recipe.width_mm.value_or(sphere_ ? recipe.height_mm : recipe.height_mm / 4) / 2),
          sizes_(sizes) {
        const double phase = Random(recipe.seed).unit();
        circle_.resize(sizes.points);
        for (std::size_t i = 0; i < circle_.size(); ++i) {
            circle_[i] = sincos_turns((static_cast<double>(i) + phase) / static_cast<double>(sizes.points));
        }
    }

    std::uint64_t triangles() const noexcept {
        return sizes_.points * 2 * sizes_.rows - (sphere_ ? sizes_.points * 2 : 0) + cap_triangles() * 2 + sizes_.splits * 2;
    }

    bool emit(const Consumer& consume) const {
        const std::uint64_t candidates = sphere_ ? triangles() - sizes_.splits * 2 : cap_triangles() * 2;
        Emitter out(consume, candidates, sizes_.splits);
        std::vector<Vertex> lower = ring(0);
        if (!sphere_ && !emit_cap(lower, true, out)) {
            return false;
        }
        for (std::uint64_t row = 0; row < sizes_.rows; ++row) {
            std::vector<Vertex> upper = ring(row + 1);
            if (!emit_row(lower, upper, out)) {
                return false;
            }
            lower = std::move(upper);
        }
        return sphere_ || emit_cap(lower, false, out);
    }

private:
    std::uint64_t cap_triangles() const noexcept { return sphere_ ? 0 : sizes_.points - 2; }

    // A pole is a ring of one point.
    std::vector<Vertex> ring(std::uint64_t index) const {
        const double at = static_cast<double>(index) / static_cast<double>(sizes_.rows);
        const SinCos latitude = sincos_turns(at / 2);
        const bool pole = sphere_ && (index == 0 || index == sizes_.rows);
        const double z = pole || !sphere_ ? height_ * at : height_ / 2 * (1 - latitude.cos);
        if (pole) {
            return {{0, 0, static_cast<float>(z)}};
        }
        const double radius = sphere_ ? radius_ * latitude.sin : radius_;
        std::vector<Vertex> points(circle_.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i] = {static_cast<float>(radius * circle_[i].cos), static_cast<float>(radius * circle_[i].sin),
                         static_cast<float>(z)};
        }
        return points;
    }

    bool emit_row(const std::vector<Vertex>& lower, const std::vector<Vertex>& upper, Emitter& out) const {
        const auto add = [&](const Triangle& triangle) { sphere_ ? out.add_splittable(triangle) : out.add(triangle); };
        const auto at = [](const std::vector<Vertex>& ring, std::size_t i) { return ring[i < ring.size() ? i : 0]; };
        for (std::size_t i = 0; i < circle_.size(); ++i) {
            if (lower.size() > 1) {
                add({lower[i], at(lower, i + 1), at(upper, i)});
            }
            if (upper.size() > 1) {
                add({at(lower, i + 1), at(upper, i + 1), upper[i]});
            }
            // No facet of a prism is split, so all triangles of a row begin at one height and can be flushed in parts.
            if (!sphere_ && out.pending() >= batch_triangles && !out.flush()) {
                return false;
            }
        }
        return out.flush();
    }

    // Takes points 0, 1, n-1, 2, n-2, ..., so that no vertex has more than a few triangles.
    bool emit_cap(const std::vector<Vertex>& ring, bool bottom, Emitter& out) const {
        std::size_t left = 0;
        std::size_t right = ring.size() - 1;
        for (bool advance_left = true; right - left >= 2; advance_left = !advance_left) {
            const std::size_t apex = advance_left ? left + 1 : right - 1;
            out.add_splittable({ring[left], ring[bottom ? right : apex], ring[bottom ? apex : right]});
            (advance_left ? left : right) = apex;
            if (out.pending() >= batch_triangles && !out.flush()) {
                return false;
            }
        }
        return out.flush();
    }

    bool sphere_;
    double height_;
    double radius_;
    RingSizes sizes_;
    std::vector<SinCos> circle_;
};

double plane_count(const Recipe& recipe) noexcept {
    return std::max(1.0, recipe.height_mm / recipe.layer_height_mm);
}

RingSizes sphere_sizes(const Recipe& recipe, std::uint64_t points) noexcept {
    RingSizes sizes;
    sizes.points = points;
    sizes.rows = recipe.triangles / (2 * points) + 1;
    const std::uint64_t unsplit = 2 * points * (sizes.rows - 1);
    sizes.splits = (recipe.triangles - unsplit) / 2;
    // A plane through a polar row crosses each triangle once; through any other row, each quad twice.
    const double polar = 1 - sincos_turns(0.5 / static_cast<double>(sizes.rows)).cos;
    const double split = static_cast<double>(sizes.splits) / static_cast<double>(unsplit);
    sizes.segments = plane_count(recipe) * static_cast<double>(points) * (2 - polar) * (1 + split_extent_gain * split);
    return sizes;
}

RingSizes prism_sizes(const Recipe& recipe, std::uint64_t points) noexcept {
    RingSizes sizes;
    sizes.points = points;
    sizes.rows = (recipe.triangles + 4) / (2 * points) - 1;
    sizes.splits = (recipe.triangles + 4 - 2 * points * (sizes.rows + 1)) / 2;
    sizes.segments = plane_count(recipe) * static_cast<double>(2 * points);
    return sizes;
}

// The rings with the least `cost` among those within a fifth of `points`.
template <class Sizes, class Cost>
RingSizes best_rings(double points, std::uint64_t most, Sizes sizes_of, Cost cost) {
    const double first = std::clamp(points * 0.8, 4.0, static_cast<double>(most));
    const double last = std::clamp(points * 1.2 + 1, 4.0, static_cast<double>(most));
    RingSizes best;
    double least = std::numeric_limits<double>::infinity();
    for (auto p = static_cast<std::uint64_t>(first); p <= static_cast<std::uint64_t>(last); ++p) {
        const RingSizes sizes = sizes_of(p);
        if (const double c = cost(sizes); c < least) {
            least = c;
            best = sizes;
        }
    }
    return best;
}

RingSizes choose_rings(const Recipe& recipe) {
    const bool sphere = recipe.shape == Shape::sphere;
    // A sphere needs one full row between its polar rows; a prism needs one row and its caps.
    const std::uint64_t most = sphere ? recipe.triangles / 2 : (recipe.triangles + 4) / 4;
    const auto sizes_of = [&](std::uint64_t points) {
        return sphere ? sphere_sizes(recipe, points) : prism_sizes(recipe, points);
    };
    if (recipe.segments) {
        const auto wanted = static_cast<double>(*recipe.segments);
        return best_rings(wanted / (2 * plane_count(recipe)), most, sizes_of, [&](const RingSizes& sizes) {
            return sizes.segments > wanted ? sizes.segments / wanted : wanted / sizes.segments;
        });
    }
    if (!sphere) {
        return sizes_of(most);
    }
    // With about the square root of the triangles, those at the equator are about equilateral.
    std::uint64_t root = 1;
    while (root * root < recipe.triangles) {
        ++root;
    }
    return best_rings(static_cast<double>(root), most, sizes_of,
                      [](const RingSizes& sizes) { return static_cast<double>(sizes.splits); });
}

}  // namespace

Plan plan_rings(const Recipe& recipe) {
    const RingSizes sizes = choose_rings(recipe);
    if (recipe.segments) {
        const double ratio = sizes.segments / static_cast<double>(*recipe.segments);
        if (ratio < 0.96 || ratio > 1.04) {
            return unreachable(recipe, sizes.segments);
        }
    }
    const Rings rings(recipe, sizes);
    return Surface{rings.triangles(), [rings](const Consumer& consume) { return rings.emit(consume); }};
}

}  // namespace lamella::models
