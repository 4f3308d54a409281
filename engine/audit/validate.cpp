// Checks what SliceResult promises, by plain methods that share nothing with the slicing stages.
#include <algorithm>
#include <new>
#include <numeric>
#include <vector>

#include "audit/containment.hpp"
#include "audit/validate_origins.hpp"
#include "base/guard.hpp"
#include "lamella/audit/validate.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

/// The broken promise in words, or empty.
using Complaint = std::string;

bool is_closed(const Contour& contour) {
    return contour.role != Role::open;
}

bool has_area(const Contour& contour) {
    return contour.role == Role::outer || contour.role == Role::hole;
}

std::string place(std::size_t layer) {
    return "layer " + std::to_string(layer) + ": ";
}

std::string place(std::size_t layer, std::size_t contour) {
    return "layer " + std::to_string(layer) + ", contour " + std::to_string(contour) + ": ";
}

/// Contours of consecutive layers and points of consecutive contours follow each other without gap, to the end.
Complaint check_offsets(const SliceResult& result) {
    std::uint64_t next_contour = 0;
    std::uint64_t next_point = 0;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        if (layer.first_contour != next_contour) {
            return place(l) + "does not begin where the layer before ends";
        }
        if (layer.contour_count > result.contours.size() - next_contour) {
            return place(l) + "reaches past the last contour";
        }
        for (; next_contour < layer.first_contour + layer.contour_count; ++next_contour) {
            const Contour& contour = result.contours[next_contour];
            if (contour.first_point != next_point) {
                return place(l, next_contour) + "does not begin where the contour before ends";
            }
            if (contour.point_count > result.points.size() - next_point) {
                return place(l, next_contour) + "reaches past the last point";
            }
            next_point += contour.point_count;
        }
    }
    if (next_contour != result.contours.size() || next_point != result.points.size()) {
        return "contours or points are left over behind the last layer";
    }
    return {};
}

Complaint check_planes(const SliceResult& result) {
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        if (layer.plane.z() % 2 == 0) {
            return place(l) + "the plane lies on an even height, where vertices are";
        }
        if (l > 0 && layer.plane <= result.layers[l - 1].plane) {
            return place(l) + "the plane is not above the one before";
        }
        if (!(layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm)) {
            return place(l) + "the plane is not between bottom and top";
        }
    }
    return {};
}

Complaint check_points(const Contour& contour, std::span<const Point> points) {
    if (points.empty()) {
        return "no points";
    }
    if (std::adjacent_find(points.begin(), points.end()) != points.end()) {
        return "equal consecutive points";
    }
    // A polyline has one point more than segments, and keeps it when it is joined to another.
    const std::uint64_t extra = (contour.flags & gap_closed) != 0 ? contour.segments : (is_closed(contour) ? 0 : 1);
    if (contour.point_count > std::uint64_t{contour.segments} + extra) {
        return "more points than its segments have";
    }
    if (!is_closed(contour)) {
        return {};
    }
    if (points.size() > 1 && points.front() == points.back()) {
        return "the first point is repeated at the end";
    }
    if (*std::min_element(points.begin(), points.end()) != points.front()) {
        return "does not start at its smallest point";
    }
    return {};
}

Int128 twice_area_of(std::span<const Point> points) {
    Int128 sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += cross(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
    }
    return sum;
}

Complaint check_area(const Contour& contour, std::span<const Point> points) {
    const Int128 twice_area = is_closed(contour) ? twice_area_of(points) : 0;
    if (twice_area != to_int128(contour.twice_area)) {
        return "the area is not that of its points";
    }
    if (has_area(contour) ? (twice_area > 0) != (contour.role == Role::outer) || twice_area == 0 : twice_area != 0) {
        return "the area's sign does not suit the role";
    }
    return {};
}

Complaint check_orientation(const Contour& contour) {
    if (!has_area(contour)) {
        if (contour.orientation != 0 || contour.parent != -1 || (contour.flags & orientation_overruled) != 0) {
            return "flat or open, yet with an orientation, a parent or an overruled orientation";
        }
        return {};
    }
    if (contour.orientation != 1 && contour.orientation != -1) {
        return "closed with an area, yet without an orientation";
    }
    const int direction = contour.role == Role::outer ? 1 : -1;
    if ((contour.flags & orientation_overruled) == 0 && contour.orientation != direction) {
        return "runs against its facets, yet is not marked as overruled";
    }
    return {};
}

Complaint check_contour(const Contour& contour, std::span<const Point> points) {
    constexpr unsigned known_flags = orientation_overruled | orientation_mixed | gap_closed | near_contour;
    if (contour.role > Role::open || (contour.flags & ~known_flags) != 0) {
        return "an unknown role or flag";
    }
    if (contour.segments == 0) {
        return "no segments";
    }
    Complaint complaint = check_points(contour, points);
    if (complaint.empty()) {
        complaint = check_area(contour, points);
    }
    return complaint.empty() ? check_orientation(contour) : complaint;
}

/// One layer's contours of one part, their own promises already checked. Indices are the layer's.
class LayerCheck {
public:
    LayerCheck(const SliceResult& result, std::size_t index, const Layer& layer)
        : result_(result), index_(index), layer_(layer), contours_(result.contours_of(layer_)) {}

    Complaint run() const {
        for (const auto check : {&LayerCheck::parents, &LayerCheck::roles, &LayerCheck::order}) {
            Complaint complaint = (this->*check)();
            if (!complaint.empty()) {
                return complaint;
            }
        }
        return {};
    }

private:
    static constexpr std::size_t none = static_cast<std::size_t>(-1);

    std::string at(std::size_t c) const { return place(index_, layer_.first_contour + c); }

    std::size_t parent(std::size_t c) const {
        return contours_[c].parent < 0 ? none : static_cast<std::size_t>(contours_[c].parent) - layer_.first_contour;
    }

    Point start(std::size_t c) const { return result_.points[contours_[c].first_point]; }

    Int128 size(std::size_t c) const {
        const Int128 twice_area = to_int128(contours_[c].twice_area);
        return twice_area < 0 ? -twice_area : twice_area;
    }

    Complaint parents() const {
        Complaint complaint;
        if (!keeps_contours()) {
            return complaint;  // contours of a region may touch: a start may lie on the contour around it
        }
        for_each_enclosure(result_, layer_, [&](std::size_t c, std::span<const std::size_t> around) {
            if (complaint.empty() && !is_parent(c, around)) {
                complaint = at(c) + "the parent is not the smallest contour around its start";
            }
        });
        return complaint;
    }

    bool keeps_contours() const noexcept {
        return result_.region.rule_of(result_.first_layer + index_) == FillRule::contours;
    }

    /// Any of several equally small ones will do.
    bool is_parent(std::size_t c, std::span<const std::size_t> around) const {
        if (around.empty() || parent(c) == none) {
            return around.empty() && contours_[c].parent == -1;
        }
        const auto smallest =
            std::min_element(around.begin(), around.end(), [&](auto a, auto b) { return size(a) < size(b); });
        return std::find(around.begin(), around.end(), parent(c)) != around.end() && size(parent(c)) == size(*smallest);
    }

    struct Standing {
        std::int64_t winding = 0;
        std::size_t ancestors = 0;
        bool facets_stand = true;  ///< no winding number from the outside in to here is negative
    };

    /// Parents start strictly left of their children, so in the order of starts they come first.
    Complaint roles() const {
        if (!keeps_contours()) {
            return roles_of_region();
        }
        std::vector<std::size_t> by_start(contours_.size());
        std::iota(by_start.begin(), by_start.end(), std::size_t{0});
        std::sort(by_start.begin(), by_start.end(), [&](std::size_t a, std::size_t b) { return start(a) < start(b); });
        std::vector<Standing> standing(contours_.size());
        for (const std::size_t c : by_start) {
            if (!has_area(contours_[c])) {
                continue;
            }
            if (parent(c) != none) {
                standing[c] = standing[parent(c)];
                ++standing[c].ancestors;
            }
            standing[c].winding += contours_[c].orientation;
            standing[c].facets_stand = standing[c].facets_stand && standing[c].winding >= 0;
            if (!suits(contours_[c], standing[c])) {
                return at(c) + "the role or its overruled mark does not follow from what lies around";
            }
        }
        return {};
    }

    /// For a region that a fill rule leaves: outers lie in nothing or in holes, holes in outers.
    Complaint roles_of_region() const {
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            if (!has_area(contours_[c])) {
                continue;
            }
            const bool hole = contours_[c].role == Role::hole;
            const bool stands = parent(c) == none ? !hole : contours_[parent(c)].role == (hole ? Role::outer : Role::hole);
            if (!stands || (contours_[c].flags & orientation_overruled) != 0) {
                return at(c) + "the role does not follow from what lies around";
            }
        }
        return {};
    }

    static bool suits(const Contour& contour, const Standing& standing) {
        const bool overruled = (contour.flags & orientation_overruled) != 0;
        const bool outer = standing.facets_stand ? contour.orientation > 0 : standing.ancestors % 2 == 0;
        return overruled == !standing.facets_stand && contour.role == (outer ? Role::outer : Role::hole);
    }

    /// Outers, flats and open ones by start; after each outer its holes by start.
    Complaint order() const {
        std::size_t head = none;  // the last contour that is no hole
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            const bool hole = contours_[c].role == Role::hole;
            if (hole && owner(c) != head) {
                return at(c) + "a hole that does not follow its outer";
            }
            const std::size_t before = hole ? c - 1 : head;
            if (before != none && (!hole || before != head) && start(c) < start(before)) {
                return at(c) + "contours are not in the order of their starts";
            }
            head = hole ? head : c;
        }
        return {};
    }

    /// The nearest ancestor that is an outer. Every hole has one: the outermost contour around it.
    std::size_t owner(std::size_t hole) const {
        std::size_t c = parent(hole);
        while (c != none && contours_[c].role != Role::outer) {
            c = parent(c);
        }
        return c;
    }

    const SliceResult& result_;
    std::size_t index_;
    const Layer& layer_;
    std::span<const Contour> contours_;
};

/// The same for every part of a layer, whose contours lie side by side.
Complaint check_parts(const SliceResult& result, std::size_t index) {
    const Layer& layer = result.layers[index];
    const std::uint64_t end = layer.first_contour + layer.contour_count;
    std::int64_t last_part = -1;
    Layer own = layer;
    for (std::uint64_t first = layer.first_contour; first < end; first += own.contour_count) {
        const std::uint32_t part = result.contours[first].part;
        if (part >= result.part_count || std::int64_t{part} <= last_part) {
            return place(index, first) + "the part is none, or not in the order of parts";
        }
        last_part = part;
        own.first_contour = first;
        own.contour_count = 1;
        while (first + own.contour_count < end && result.contours[first + own.contour_count].part == part) {
            ++own.contour_count;
        }
        for (const Contour& contour : result.contours_of(own)) {
            if (contour.parent >= 0 && result.contours[static_cast<std::size_t>(contour.parent)].part != part) {
                return place(index, first) + "the parent is of another part";
            }
        }
        if (Complaint complaint = LayerCheck(result, index, own).run(); !complaint.empty()) {
            return complaint;
        }
    }
    return {};
}

Complaint check_united(const SliceResult& result, std::size_t index) {
    const Layer& layer = result.layers[index];
    for (const Contour& contour : result.contours_of(layer)) {
        if (contour.part >= result.part_count && contour.part != several_parts) {
            return place(index, static_cast<std::size_t>(&contour - result.contours.data())) + "there is no such part";
        }
    }
    return LayerCheck(result, index, layer).run();
}

Complaint check_layer(const SliceResult& result, std::size_t index) {
    const Layer& layer = result.layers[index];
    std::uint64_t segments = 0;
    for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
        const Contour& contour = result.contours[c];
        Complaint complaint = check_contour(contour, result.points_of(contour));
        if (!complaint.empty()) {
            return place(index, c) + complaint;
        }
        const std::int64_t first = static_cast<std::int64_t>(layer.first_contour);
        const std::int64_t last = first + static_cast<std::int64_t>(layer.contour_count);
        if (contour.parent != -1 && (contour.parent < first || contour.parent >= last)) {
            return place(index, c) + "the parent lies in another layer";
        }
        segments += contour.segments;
    }
    // A fill rule drops some and cuts others in two.
    if (segments != layer.segments && result.region.rule_of(result.first_layer + index) == FillRule::contours) {
        return place(index) + "contours do not use every segment once";
    }
    return result.part_regions == PartRegions::united ? check_united(result, index) : check_parts(result, index);
}

Complaint check_summary(const SliceResult& result) {
    SliceSummary counted;
    for (const Contour& contour : result.contours) {
        counted.segments += contour.segments;
        counted.holes += contour.role == Role::hole;
        counted.flat_contours += contour.role == Role::flat;
        counted.open_contours += contour.role == Role::open;
        counted.overruled_contours += (contour.flags & orientation_overruled) != 0;
        counted.near_contours += (contour.flags & near_contour) != 0;
    }
    for (const Layer& layer : result.layers) {
        counted.emptied_layers += layer.segments > 0 && layer.contour_count == 0;
    }
    const SliceSummary& summary = result.summary;
    const bool agrees = (counted.segments == summary.segments || !result.region.keeps_contours()) &&
                        counted.holes == summary.holes && counted.flat_contours == summary.flat_contours &&
                        counted.open_contours == summary.open_contours &&
                        counted.overruled_contours == summary.overruled_contours &&
                        counted.near_contours == summary.near_contours && counted.emptied_layers == summary.emptied_layers;
    return agrees ? Complaint{} : "the summary's counts are not those of the contours";
}

Status failed(Complaint complaint, std::size_t layer) {
    Error error;
    error.message = std::move(complaint);
    error.plane = static_cast<std::int64_t>(layer);
    return error;
}

Status check(const SliceResult& result) {
    for (const auto whole : {check_offsets, check_planes, complaint_about_origins}) {
        Complaint complaint = whole(result);
        if (!complaint.empty()) {
            return failed(std::move(complaint), static_cast<std::size_t>(-1));
        }
    }
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        Complaint complaint = check_layer(result, l);
        if (!complaint.empty()) {
            return failed(std::move(complaint), l);
        }
    }
    Complaint complaint = check_summary(result);
    return complaint.empty() ? Status{} : failed(std::move(complaint), static_cast<std::size_t>(-1));
}

}  // namespace

Status validate(const SliceResult& result) noexcept {
    return guarded([&] { return check(result); });
}

}  // namespace lamella
