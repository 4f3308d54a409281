// Checks for validate() that points came from their origins.
#include <algorithm>
#include <array>
#include <cmath>

#include "audit/pair.hpp"
#include "audit/validate.hpp"
#include "base/guard.hpp"
#include "lamella/audit/validate.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

std::string point_place(std::size_t contour, std::size_t point) {
    return "contour " + std::to_string(contour) + ", point " + std::to_string(point) + ": ";
}

bool has_edge(std::uint8_t edge) {
    return edge < 3;
}

Complaint complaint_about(const PointOrigin& origin, const Contour& contour, const SliceResult& result) {
    if (origin.triangle == no_triangle) {
        return origin == PointOrigin() ? "" : "an origin without a triangle, yet with an edge or a part";
    }
    if (origin.edge > no_edge || origin.end_edge > no_edge) {
        return "the origin names an edge that no triangle has";
    }
    if (has_edge(origin.edge) && origin.edge == origin.end_edge) {
        return "the contour edge begins and ends on the same edge of its triangle";
    }
    if (origin.triangle >= result.summary.triangles) {
        return "the origin's triangle is not in the mesh";
    }
    if (origin.part >= result.part_count || (contour.part != several_parts && origin.part != contour.part)) {
        return "the origin's part is not the contour's";
    }
    return {};
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

/// The triangles of one part.
class OriginCheck {
public:
    OriginCheck(const SliceResult& result, std::span<const Part> parts) : result_(result), parts_(parts) {}

    Status run() const {
        for (std::size_t l = 0; l < result_.layers.size(); ++l) {
            const Layer& layer = result_.layers[l];
            for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
                const Contour& contour = result_.contours[c];
                for (std::uint32_t i = 0; i < contour.point_count; ++i) {
                    Complaint complaint = complaint_at(l, contour, i);
                    if (!complaint.empty()) {
                        Error error;
                        error.message = "layer " + std::to_string(l) + ", " + point_place(c, i) + std::move(complaint);
                        error.plane = static_cast<std::int64_t>(l);
                        return error;
                    }
                }
            }
        }
        return {};
    }

private:
    // The point is rounded by half a unit; each of fill, closing and offset may move it by another half.
    static constexpr double on_edge = 0.75;
    static constexpr double on_segment = 3;

    Complaint complaint_at(std::size_t layer, const Contour& contour, std::uint32_t i) const {
        const PointOrigin& origin = result_.origins_of(contour)[i];
        const bool is_plain = result_.region.rule_of(result_.first_layer + layer) == FillRule::contours;
        if (origin.triangle == no_triangle) {
            const bool as_walked = is_plain && (contour.flags & gap_closed) == 0 && result_.region.simplify_mm == 0;
            return as_walked ? "no origin, though nothing was made, joined or simplified here" : "";
        }
        const MeshView& mesh = parts_[origin.part].mesh;
        if (origin.triangle >= mesh.triangle_count) {
            return "the origin's triangle is not in the mesh";
        }
        const Section section(
            GeneralReader(mesh, result_.frame * parts_[origin.part].transform, result_.unit_mm)(origin.triangle),
            result_.layers[layer].plane);
        if (!section.is_cut()) {
            return "the plane does not cut the origin's triangle";
        }
        Complaint complaint = complaint_about_ends(section, origin, contour, i);
        const bool runs_as_facet = is_plain && (contour.flags & (orientation_mixed | orientation_overruled)) == 0;
        if (complaint.empty() && runs_as_facet && !is_last(contour, i) && !section.begins(origin.edge)) {
            complaint = "the contour edge runs against its facet";
        }
        return complaint;
    }

    /// No contour edge with a length begins there.
    static bool is_last(const Contour& contour, std::uint32_t i) {
        return contour.point_count == 1 || (contour.role == Role::open && i + 1 == contour.point_count);
    }

    Complaint complaint_about_ends(const Section& section, const PointOrigin& origin, const Contour& contour,
                                   std::uint32_t i) const {
        const std::span<const Point> points = result_.points_of(contour);
        const Point next = points[i + 1 < points.size() ? i + 1 : 0];
        const auto is_off = [&](std::uint8_t edge, Point point) {
            return has_edge(edge) && (!section.is_cut(edge) || section.distance_to_edge(edge, point) > on_edge);
        };
        if (is_off(origin.edge, points[i])) {
            return "the point does not lie on the edge that its origin names";
        }
        if (is_last(contour, i)) {
            return {};
        }
        if (is_off(origin.end_edge, next)) {
            return "the contour edge does not end on the edge that its origin names";
        }
        const bool whole = !result_.region.drop_collinear;  // else the edge may lead on over other triangles
        if (section.distance_to_segment(points[i]) > on_segment ||
            (whole && section.distance_to_segment(next) > on_segment)) {
            return "the contour edge does not lie in the origin's triangle";
        }
        return {};
    }

    const SliceResult& result_;
    std::span<const Part> parts_;
};

Status check(const SliceResult& result, std::span<const Part> parts) {
    if (Status status = validate(result); !status || result.origins.empty()) {
        return status;
    }
    if (parts.size() != result.part_count) {
        return Error{ErrorCode::invalid_argument, "the result is not of so many parts"};
    }
    const Parallel parallel({.threads = 1});
    std::uint64_t triangles = 0;
    for (const Part& part : parts) {
        const Transform transform = result.frame * part.transform;
        if (const Result<Bounds> bounds = examine(part.mesh, transform, result.unit_mm, parallel); !bounds) {
            return bounds.error();
        }
        triangles += part.mesh.triangle_count;
    }
    if (triangles != result.summary.triangles) {
        return Error{ErrorCode::invalid_argument, "the result is not of this mesh"};
    }
    return OriginCheck(result, parts).run();
}

}  // namespace

Complaint complaint_about_origins(const SliceResult& result) {
    if (result.origins.empty()) {
        return {};
    }
    if (result.origins.size() != result.points.size()) {
        return "there are not as many origins as points";
    }
    for (std::size_t c = 0; c < result.contours.size(); ++c) {
        const Contour& contour = result.contours[c];
        for (std::uint32_t i = 0; i < contour.point_count; ++i) {
            Complaint complaint = complaint_about(result.origins_of(contour)[i], contour, result);
            if (!complaint.empty()) {
                return point_place(c, i) + complaint;
            }
        }
    }
    return {};
}

Status validate(const SliceResult& result, const MeshView& mesh) noexcept {
    const Part whole{.mesh = mesh};
    return validate(result, std::span(&whole, 1));
}

Status validate(const SliceResult& result, std::span<const Part> parts) noexcept {
    return guarded([&] { return check(result, parts); });
}

}  // namespace lamella
