// Points and the origins that they name.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "audit/questions.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

// The point is rounded by half a unit; each of fill, closing and offset may move it by another half.
constexpr double on_edge = 0.75;
constexpr double on_segment = 3;

bool has_edge(std::uint8_t edge) {
    return edge < 3;
}

struct Position {
    double x;
    double y;
};

/// From a point to the segment from a to b.
double distance(Point point, const Position& a, const Position& b) {
    const Position along{b.x - a.x, b.y - a.y};
    const double length = along.x * along.x + along.y * along.y;
    const double dot = (point.x - a.x) * along.x + (point.y - a.y) * along.y;
    const double share = length == 0 ? 0 : std::clamp(dot / length, 0.0, 1.0);
    return std::hypot(point.x - a.x - share * along.x, point.y - a.y - share * along.y);
}

/// Where the plane cuts an edge of the triangle, if it does.
std::optional<Position> cut_of(const GridTriangle& triangle, std::size_t edge, PlaneHeight plane) {
    const GridVertex& u = triangle[edge];
    const GridVertex& v = triangle[(edge + 1) % 3];
    if ((u.z < plane.z()) == (v.z < plane.z())) {
        return std::nullopt;
    }
    const double share = (static_cast<double>(plane.z()) - u.z) / (static_cast<double>(v.z) - u.z);
    return Position{u.x + share * (static_cast<double>(v.x) - u.x), u.y + share * (static_cast<double>(v.y) - u.y)};
}

/// The origin by itself.
void check_alone(const SliceResult& result, const Contour& contour, const PointOrigin& origin, const ResultPlace& at) {
    at.require(origin.edge <= no_edge && origin.end_edge <= no_edge, "the origin names an edge that no triangle has");
    at.require(!has_edge(origin.edge) || origin.edge != origin.end_edge,
               "the contour edge begins and ends on the same edge of its triangle");
    at.require(origin.triangle < result.info.triangles, "the origin's triangle is not in the mesh");
    at.require(origin.part < result.info.part_count && (contour.part == several_parts || origin.part == contour.part),
               "the origin's part is not the contour's");
}

/// The contour edge that begins at point i, by the part that was sliced.
void check_edge(const SliceResult& result, const Part& part, const Contour& contour, std::size_t i, const ResultPlace& at) {
    const PointOrigin& origin = result.origins_of(contour)[i];
    const PlaneHeight plane = result.layers[*at.layer].plane;
    at.require(origin.triangle < part.mesh.triangle_count, "the origin's triangle is not in the mesh");
    const GridTriangle triangle = GridReader<>(part.mesh, placing_of(part, result), result.info.grid_mm)(origin.triangle);
    std::vector<Position> ends;
    for (std::size_t edge = 0; edge < 3; ++edge) {
        if (const auto cut = cut_of(triangle, edge, plane)) {
            ends.push_back(*cut);
        }
    }
    at.require(ends.size() == 2, "the plane does not cut the origin's triangle");
    const auto lies_on = [&](std::uint8_t edge, Point point) {
        const auto cut = has_edge(edge) ? cut_of(triangle, edge, plane) : std::nullopt;
        return !has_edge(edge) || (cut && distance(point, *cut, *cut) <= on_edge);
    };
    const std::span<const Point> points = result.points_of(contour);
    at.require(lies_on(origin.edge, points[i]), "the point does not lie on the edge that its origin names");
    if (points.size() == 1 || (contour.role == Role::open && i + 1 == points.size())) {
        return;  // no contour edge with a length begins here
    }
    const Point next = points[i + 1 < points.size() ? i + 1 : 0];
    at.require(lies_on(origin.end_edge, next), "the contour edge does not end on the edge that its origin names");
    const bool whole = !result.info.options.region.drop_collinear;  // else the edge may lead on over other triangles
    at.require(
        distance(points[i], ends[0], ends[1]) <= on_segment && (!whole || distance(next, ends[0], ends[1]) <= on_segment),
        "the contour edge does not lie in the origin's triangle");
    const bool runs_as_facet =
        keeps_contours(result, *at.layer) && (contour.flags & (orientation_mixed | orientation_overruled)) == 0;
    // The facet's segment begins where the triangle's edge falls.
    at.require(!runs_as_facet || !has_edge(origin.edge) || triangle[(origin.edge + 1U) % 3].z < triangle[origin.edge].z,
               "the contour edge runs against its facet");
}

void check_origin(const SliceResult& result, std::span<const Part> parts, const Contour& contour, std::size_t i,
                  const ResultPlace& at) {
    const PointOrigin& origin = result.origins_of(contour)[i];
    if (origin.triangle != no_triangle) {
        check_alone(result, contour, origin, at);
        if (!parts.empty()) {
            check_edge(result, parts[origin.part], contour, i, at);
        }
        return;
    }
    at.require(origin == PointOrigin(), "an origin without a triangle, yet with an edge or a part");
    at.require(parts.empty() || !keeps_contours(result, *at.layer) || (contour.flags & stitched) != 0 ||
                   result.info.options.region.simplify_mm != 0,
               "no origin, though nothing was made, joined or simplified here");
}

}  // namespace

void check_origins(const SliceResult& result, std::span<const Part> parts) {
    if (result.origins.empty()) {
        return;
    }
    ResultPlace{}.require(result.origins.size() == result.points.size(), "there are not as many origins as points");
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
            for (std::size_t i = 0; i < result.contours[c].point_count; ++i) {
                check_origin(result, parts, result.contours[c], i, {l, c, i});
            }
        }
    }
}

}  // namespace lamella
