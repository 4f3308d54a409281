#include "engine/origin_oracle.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "engine/slicing.hpp"

namespace origin_oracle {

using lamella::GridVertex;
using lamella::PointOrigin;

namespace {

/// The same for each first corner.
oracle::Triangle turned_to_smallest(oracle::Triangle t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

/// The cut of a triangle by its own corners; none if it has no length.
std::optional<Cut> cut_of(const oracle::Triangle& t, std::uint32_t index, std::uint16_t part, std::int32_t z) {
    const std::vector<lamella::Segment> segments = oracle::segments_at(std::span(&t, 1), z);
    if (segments.empty() || segments[0].from == segments[0].to) {
        return {};
    }
    Cut cut{segments[0].from, segments[0].to, {index, part}};
    for (std::uint8_t e = 0; e < 3; ++e) {
        const std::int32_t from = t[e].z;
        const std::int32_t to = t[(e + 1U) % 3].z;
        if (from > z && to < z) {
            cut.origin.edge = e;  // the facet's segment starts where the facet runs down
        } else if (from < z && to > z) {
            cut.origin.end_edge = e;
        }
    }
    return cut;
}

}  // namespace

Triangles::Triangles(const shapes::Soup& soup, const lamella::SliceResult& result, std::uint16_t part) : part_(part) {
    std::map<oracle::Triangle, std::uint32_t> smallest;
    for (std::uint32_t t = 0; t < soup.size() / 9; ++t) {
        const std::vector<oracle::Triangle> own = oracle::quantise(std::span(soup).subspan(9 * t, 9), result.info.grid_mm);
        triangles_.push_back(own.empty() ? oracle::Triangle{} : own[0]);
        stands_for_.push_back(smallest.emplace(turned_to_smallest(triangles_[t]), t).first->second);
    }
}

std::vector<Cut> Triangles::cuts_at(lamella::PlaneHeight plane) const {
    std::vector<Cut> cuts;
    for (const std::uint32_t t : stands_for_) {
        if (const std::optional<Cut> cut = cut_of(triangles_[t], t, part_, plane.z())) {
            cuts.push_back(*cut);
        }
    }
    std::sort(cuts.begin(), cuts.end());
    return cuts;
}

bool Triangles::runs_down(const PointOrigin& origin) const {
    const oracle::Triangle& t = triangles_[origin.triangle];
    return t[(origin.edge + 1U) % 3].z < t[origin.edge].z;
}

std::vector<Cut> Triangles::edges_of(const lamella::LayerView& layer) const {
    std::vector<Cut> edges;
    for (const lamella::Contour& contour : layer.contours) {
        const std::span<const lamella::Point> points = layer.points_of(contour);
        const std::span<const PointOrigin> origins = layer.origins_of(contour);
        const bool open = contour.role == lamella::Role::open;
        for (std::size_t i = 0; i < points.size() - (open ? 1 : 0); ++i) {
            const lamella::Point next = points[i + 1 < points.size() ? i + 1 : 0];
            const PointOrigin& origin = origins[i];
            if (origin.triangle == lamella::no_triangle || points[i] == next) {
                continue;
            }
            edges.push_back(runs_down(origin)
                                ? Cut{points[i], next, origin}
                                : Cut{next, points[i], {origin.triangle, origin.part, origin.end_edge, origin.edge}});
        }
    }
    std::sort(edges.begin(), edges.end());
    return edges;
}

lamella::SliceOptions with_origins(lamella::SliceOptions options) {
    options.origins = true;
    return options;
}

lamella::SliceResult traced(const shapes::Soup& soup, const lamella::SliceOptions& options, const lamella::Tuning& tuning) {
    lamella::SliceResult result = sliced(soup, with_origins(options), {}, tuning);
    REQUIRE(result.origins.size() == result.points.size());
    require_ok(audits::structure_of(result, view_of(soup)));
    lamella::SliceOptions plain = options;
    plain.origins = false;
    const lamella::SliceResult without = sliced(soup, plain, {}, tuning);
    REQUIRE(without.origins.empty());
    REQUIRE(without.hash() == result.hash());
    return result;
}

}  // namespace origin_oracle
