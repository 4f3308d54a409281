// Points and the origins that they name.
#include <algorithm>
#include <array>
#include <cmath>

#include "audit/questions.hpp"
#include "audit/structure.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

bool has_edge(std::uint8_t edge) {
    return edge < 3;
}

struct Position {
    double x;
    double y;

    Position operator-(const Position& other) const { return {x - other.x, y - other.y}; }
    double dot(const Position& other) const { return x * other.x + y * other.y; }
};

Position to_position(Point point) {
    return {static_cast<double>(point.x), static_cast<double>(point.y)};
}

double distance(const Position& a, const Position& b) {
    return std::sqrt((b - a).dot(b - a));
}

/// From a point to the segment from a to b.
double distance(const Position& point, const Position& a, const Position& b) {
    const Position along = b - a;
    const double length = along.dot(along);
    const double share = length == 0 ? 0 : std::clamp((point - a).dot(along) / length, 0.0, 1.0);
    return distance(point, {a.x + share * along.x, a.y + share * along.y});
}

/// Where a plane cuts the edges of a triangle.
class Section {
public:
    Section(const GridTriangle& triangle, PlaneHeight plane) {
        for (std::size_t e = 0; e < 3; ++e) {
            const GridVertex& u = triangle[e];
            const GridVertex& v = triangle[(e + 1) % 3];
            cut_[e] = (u.z < plane.z()) != (v.z < plane.z());
            down_[e] = v.z < u.z;
            if (cut_[e]) {
                const double share = (static_cast<double>(plane.z()) - u.z) / (static_cast<double>(v.z) - u.z);
                at_[e] = {u.x + share * (static_cast<double>(v.x) - u.x), u.y + share * (static_cast<double>(v.y) - u.y)};
                ends_[count_++] = at_[e];
            }
        }
    }

    bool is_cut() const { return count_ == 2; }
    bool is_cut(std::uint8_t edge) const { return cut_[edge]; }
    /// The facet's segment begins on this edge.
    bool begins(std::uint8_t edge) const { return down_[edge]; }
    double distance_to_edge(std::uint8_t edge, Point point) const { return distance(to_position(point), at_[edge]); }
    double distance_to_segment(Point point) const { return distance(to_position(point), ends_[0], ends_[1]); }

private:
    std::array<bool, 3> cut_{};
    std::array<bool, 3> down_{};
    std::array<Position, 3> at_{};
    std::array<Position, 2> ends_{};
    std::size_t count_ = 0;
};

/// No contour edge with a length begins at point i.
bool is_last(const Contour& contour, std::size_t i) {
    return contour.point_count == 1 || (contour.role == Role::open && i + 1 == contour.point_count);
}

// The point is rounded by half a unit; each of fill, closing and offset may move it by another half.
constexpr double on_edge = 0.75;
constexpr double on_segment = 3;

void check_ends(const SliceResult& result, const Section& section, const Contour& contour, std::size_t i,
                const ResultPlace& at) {
    const PointOrigin& origin = result.origins_of(contour)[i];
    const std::span<const Point> points = result.points_of(contour);
    const Point next = points[i + 1 < points.size() ? i + 1 : 0];
    const auto lies_on = [&](std::uint8_t edge, Point point) {
        return !has_edge(edge) || (section.is_cut(edge) && section.distance_to_edge(edge, point) <= on_edge);
    };
    at.require(lies_on(origin.edge, points[i]), "the point does not lie on the edge that its origin names");
    if (is_last(contour, i)) {
        return;
    }
    at.require(lies_on(origin.end_edge, next), "the contour edge does not end on the edge that its origin names");
    const bool whole = !result.info.options.region.drop_collinear;  // else the edge may lead on over other triangles
    at.require(
        section.distance_to_segment(points[i]) <= on_segment && (!whole || section.distance_to_segment(next) <= on_segment),
        "the contour edge does not lie in the origin's triangle");
}

void check_origin(const SliceResult& result, std::span<const Part> parts, const Contour& contour, const ResultPlace& at) {
    const PointOrigin& origin = result.origins_of(contour)[*at.point];
    const bool kept = keeps_contours(result, *at.layer);
    if (origin.triangle == no_triangle) {
        at.require(!kept || (contour.flags & stitched) != 0 || result.info.options.region.simplify_mm != 0,
                   "no origin, though nothing was made, joined or simplified here");
        return;
    }
    const Part& part = parts[origin.part];
    at.require(origin.triangle < part.mesh.triangle_count, "the origin's triangle is not in the mesh");
    const GeneralReader read(part.mesh, placing_of(part, result), result.info.grid_mm);
    const Section section(read(origin.triangle), result.layers[*at.layer].plane);
    at.require(section.is_cut(), "the plane does not cut the origin's triangle");
    check_ends(result, section, contour, *at.point, at);
    const bool runs_as_facet = kept && (contour.flags & (orientation_mixed | orientation_overruled)) == 0;
    at.require(!runs_as_facet || is_last(contour, *at.point) || section.begins(origin.edge),
               "the contour edge runs against its facet");
}

}  // namespace

void check_origins(const SliceResult& result) {
    if (result.origins.empty()) {
        return;
    }
    ResultPlace{}.require(result.origins.size() == result.points.size(), "there are not as many origins as points");
    for (std::size_t c = 0; c < result.contours.size(); ++c) {
        const Contour& contour = result.contours[c];
        for (std::size_t i = 0; i < contour.point_count; ++i) {
            const PointOrigin& origin = result.origins_of(contour)[i];
            const ResultPlace at{{}, c, i};
            if (origin.triangle == no_triangle) {
                at.require(origin == PointOrigin(), "an origin without a triangle, yet with an edge or a part");
                continue;
            }
            at.require(origin.edge <= no_edge && origin.end_edge <= no_edge,
                       "the origin names an edge that no triangle has");
            at.require(!has_edge(origin.edge) || origin.edge != origin.end_edge,
                       "the contour edge begins and ends on the same edge of its triangle");
            at.require(origin.triangle < result.info.triangles, "the origin's triangle is not in the mesh");
            at.require(
                origin.part < result.info.part_count && (contour.part == several_parts || origin.part == contour.part),
                "the origin's part is not the contour's");
        }
    }
}

void check_origins(const SliceResult& result, std::span<const Part> parts) {
    if (parts.empty() || result.origins.empty()) {
        return;
    }
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
            for (std::size_t i = 0; i < result.contours[c].point_count; ++i) {
                check_origin(result, parts, result.contours[c], {l, c, i});
            }
        }
    }
}

}  // namespace lamella
