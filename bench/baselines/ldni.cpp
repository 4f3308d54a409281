// Layered depth-normal images: L. Zeng, L. M. Lai, D. Qi, Y.-H. Lai and M. M.-F. Yuen 2011, and D. Qi, L. Zeng and M.
// M.-F. Yuen 2013, as the paper describes them (2.2). Parallel rays sample each layer, here along x. Each ray gives a
// list of points and, for each point, whether the ray enters or leaves the solid. Points of neighbouring rays are then
// connected.
//
// Two neighbouring rays bound a strip. Their intervals within the solid belong together where they overlap. Overlapping
// intervals form one piece of the solid within the strip, and the border of the piece connects the points:
//
//     ray j + 1   ----o=========o----o====o--------o===o-----        = solid
//                    /           `--'      \        `-'              an interval alone is closed at once
//     ray j       --o=======================o----------------
//
// O(n log k + m + s log s) for s samples. The answer is accurate to about the resolution: the error of an area is at
// most the contours' length times the distance of two rays. Details between two rays are lost, and so are the mesh's
// own corners.
//
// Kept from the source: only closed meshes are sliced; an interval without an end is dropped. Left out: the images
// themselves, which the authors render on graphics hardware, and resolutions that vary with the shape.
#include "methods.hpp"

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <optional>
#include <span>

#include "base/system/processor.hpp"
#include "geometry.hpp"

namespace lamella::baselines {

namespace {

/// Where a ray crosses the surface. Entries into the solid sort before exits, so solids that touch become one.
struct Sample {
    std::uint32_t ray;
    std::int32_t x;
    bool leaves;
    auto operator<=>(const Sample&) const = default;
};
using Samples = std::vector<Sample>;

/// Rays along x. The first lies half the ray distance below the lowest y.
class Rays {
public:
    Rays(const std::vector<Facet>& facets, double unit_mm)
        : distance_(std::max<std::int64_t>(1, std::llround(ldni_resolution_mm / unit_mm))) {
        std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
        for (const Facet& facet : facets) {
            for (const GridVertex& vertex : facet) {
                lowest = std::min(lowest, vertex.y);
            }
        }
        first_ = lowest - distance_ / 2;
    }

    std::int32_t y(std::uint32_t ray) const noexcept { return static_cast<std::int32_t>(first_ + ray * distance_); }

    /// Takes in the lower end of a segment and leaves out its upper end, so a ray through a shared point meets one
    /// segment.
    void sample(const Segment& segment, Samples& samples) const {
        const auto [low, high] = std::minmax(segment.from, segment.to, [](Point a, Point b) { return a.y < b.y; });
        const std::uint32_t end = first_at_or_above(high.y);
        const double slope =
            static_cast<double>(std::int64_t{high.x} - low.x) / static_cast<double>(std::int64_t{high.y} - low.y);
        for (std::uint32_t ray = first_at_or_above(low.y); ray < end; ++ray) {
            const auto rise = static_cast<double>(std::int64_t{y(ray)} - low.y);
            samples.push_back({ray, round_to_int(low.x + slope * rise), segment.from.y < segment.to.y});
        }
    }

private:
    std::uint32_t first_at_or_above(std::int32_t y) const noexcept {
        return static_cast<std::uint32_t>((y - first_ + distance_ - 1) / distance_);
    }

    std::int64_t distance_;  // grid units
    std::int64_t first_ = 0;
};

std::vector<Samples> sample(const Problem& problem, const std::vector<Facet>& facets, const Rays& rays) {
    const FirstPlaneAbove first_plane(problem);
    std::vector<Samples> layers(problem.planes.size());
    for (const Facet& facet : facets) {
        const auto [low, high] = std::minmax({facet[0].z, facet[1].z, facet[2].z});
        for (std::size_t i = first_plane(low); i < layers.size() && problem.planes[i] < high; ++i) {
            rays.sample(cut(facet, problem.planes[i]), layers[i]);
        }
    }
    return layers;
}

/// Connects the samples of one layer into contours.
class LayerLinker {
public:
    LayerLinker(Samples& samples, const Rays& rays) {
        std::ranges::sort(samples);
        for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
            for (end = begin; end < samples.size() && samples[end].ray == samples[begin].ray;) {
                ++end;
            }
            add_ray({samples.data() + begin, end - begin}, rays.y(samples[begin].ray));
        }
        next_.resize(ends_.size());
        for (std::size_t r = 0; r < rays_.size(); ++r) {
            const bool has_below = r > 0 && rays_[r - 1].number + 1 == rays_[r].number;
            const bool has_above = r + 1 < rays_.size() && rays_[r].number + 1 == rays_[r + 1].number;
            if (!has_below) {
                link_strip({}, rays_[r]);
            }
            link_strip(rays_[r], has_above ? rays_[r + 1] : Ray{});
        }
    }

    std::vector<Polyline> contours() const {
        std::vector<Polyline> contours;
        std::vector<bool> is_used(ends_.size());
        for (std::uint32_t start = 0; start < ends_.size(); ++start) {
            if (is_used[start]) {
                continue;
            }
            Polyline& contour = contours.emplace_back();
            contour.closed = true;
            for (std::uint32_t end = start; !is_used[end]; end = next_[end]) {
                is_used[end] = true;
                contour.points.push_back(ends_[end]);
            }
        }
        return contours;
    }

private:
    /// Its intervals within the solid: each begins and ends at two successive entries of ends_[begin, end).
    struct Ray {
        std::uint32_t number = 0;
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
    };

    void add_ray(std::span<const Sample> samples, std::int32_t y) {
        const auto begin = static_cast<std::uint32_t>(ends_.size());
        int depth = 0;
        for (const Sample& sample : samples) {
            const int before = depth;
            depth += sample.leaves ? -1 : 1;
            if ((before == 0 && depth == 1) || (before == 1 && depth == 0)) {
                ends_.push_back({sample.x, y});
            }
        }
        ends_.resize(ends_.size() / 2 * 2);
        if (ends_.size() != begin) {
            rays_.push_back({samples.front().ray, begin, static_cast<std::uint32_t>(ends_.size())});
        }
    }

    /// Contours have the solid on their left. They run up through the right end of an interval and down through its
    /// left end. The strip above a ray therefore gives the point after a right end, and the strip below gives the point
    /// after a left end.
    void link_strip(Ray below, Ray above) {
        while (below.begin != below.end || above.begin != above.end) {
            link_piece(below, above);
        }
    }

    /// Removes the intervals of the leftmost piece of the solid and links their ends.
    void link_piece(Ray& below, Ray& above) {
        const Ray first_below = below;
        const Ray first_above = above;
        for (std::int32_t reach = std::numeric_limits<std::int32_t>::min();;) {
            const bool is_below =
                above.begin == above.end || (below.begin != below.end && ends_[below.begin].x <= ends_[above.begin].x);
            Ray& ray = is_below ? below : above;
            const bool is_first = below.begin == first_below.begin && above.begin == first_above.begin;
            if (ray.begin == ray.end || (!is_first && ends_[ray.begin].x >= reach)) {
                break;
            }
            if (is_below && below.begin != first_below.begin) {
                next_[below.begin - 1] = below.begin;
            } else if (!is_below && above.begin != first_above.begin) {
                next_[above.begin] = above.begin - 1;
            }
            reach = std::max(reach, ends_[ray.begin + 1].x);
            ray.begin += 2;
        }
        const bool has_below = below.begin != first_below.begin;
        const bool has_above = above.begin != first_above.begin;
        if (has_below) {
            next_[below.begin - 1] = has_above ? above.begin - 1 : first_below.begin;
        }
        if (has_above) {
            next_[first_above.begin] = has_below ? first_below.begin : above.begin - 1;
        }
    }

    std::vector<Point> ends_;
    std::vector<Ray> rays_;
    std::vector<std::uint32_t> next_;  // By interval end: the next end along the contour
};

WholeOutcome run(const Problem& problem) {
    std::optional<Rays> rays;
    return in_two_steps(
        [&] {
            const std::vector<Facet> facets = quantised(problem);
            return sample(problem, facets, rays.emplace(facets, problem.unit_mm));
        },
        [&](Samples& samples) { return LayerLinker(samples, *rays).contours(); });
}

}  // namespace

const WholeMethod ldni{
    .name = "LDNI, 0.1 mm",
    .run = run,
};

}  // namespace lamella::baselines
