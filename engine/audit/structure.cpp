// The promises of result.hpp, looked at by plain methods that share nothing with the slicing stages.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "audit/questions.hpp"
#include "base/guard.hpp"
#include "base/sort.hpp"

namespace lamella {

namespace {

bool is_closed(const Contour& contour) {
    return contour.role != Role::open;
}

void check_planes(const SliceResult& result) {
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        const ResultPlace at{l};
        at.require(layer.plane.z() % 2 != 0, "the plane lies on an even height, where vertices are");
        at.require(layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm,
                   "the plane is not between bottom and top");
    }
}

void check_points(const Contour& contour, std::span<const Point> points, const ResultPlace& at) {
    at.require(!points.empty(), "no points");
    at.require(std::adjacent_find(points.begin(), points.end()) == points.end(), "equal consecutive points");
    // A polyline has one point more than segments, and keeps it when it is joined to another.
    const std::uint64_t extra = (contour.flags & stitched) != 0 ? contour.segments : (is_closed(contour) ? 0 : 1);
    at.require(contour.point_count <= std::uint64_t{contour.segments} + extra, "more points than its segments have");
    if (is_closed(contour)) {
        at.require(points.size() == 1 || points.front() != points.back(), "the first point is repeated at the end");
        at.require(*std::min_element(points.begin(), points.end()) == points.front(),
                   "does not start at its smallest point");
    }
}

void check_area(const Contour& contour, std::span<const Point> points, const ResultPlace& at) {
    const Int128 twice_area = is_closed(contour) ? size_of(points).twice_area : 0;
    const int sign = contour.role == Role::outer ? 1 : (contour.role == Role::hole ? -1 : 0);
    at.require(twice_area == to_int128(contour.twice_area), "the area is not that of its points");
    at.require(sign_of(twice_area) == sign, "the area's sign does not suit the role");
}

void check_orientation(const Contour& contour, const ResultPlace& at) {
    const bool overruled = (contour.flags & orientation_overruled) != 0;
    if (!contour.encloses_area()) {
        at.require(contour.orientation == 0 && contour.parent == -1 && !overruled,
                   "flat or open, yet with an orientation, a parent or an overruled orientation");
        return;
    }
    at.require(contour.orientation == 1 || contour.orientation == -1, "closed with an area, yet without an orientation");
    at.require(overruled || contour.orientation == (contour.role == Role::outer ? 1 : -1),
               "runs against its facets, yet is not marked as overruled");
}

struct Edge {
    Point from;
    Point to;

    std::int32_t low() const noexcept { return std::min(from.y, to.y); }
    std::int32_t high() const noexcept { return std::max(from.y, to.y); }
    bool passes_through(Point p) const noexcept {
        return low() <= p.y && p.y <= high() && std::min(from.x, to.x) <= p.x && p.x <= std::max(from.x, to.x) &&
               side_of_line(from, to, p) == 0;
    }
    /// The edge's share of the winding number about p: the ray from p towards +x, each edge without its upper end.
    int winding_about(Point p) const noexcept {
        if (from.y <= p.y && p.y < to.y) {
            return side_of_line(from, to, p) > 0 ? 1 : 0;
        }
        if (to.y <= p.y && p.y < from.y) {
            return side_of_line(from, to, p) < 0 ? -1 : 0;
        }
        return 0;
    }
};

/// The start of a contour with area, and the others with area around it.
struct Start {
    std::size_t contour = 0;
    Point at{};
    std::vector<std::size_t> around{};  ///< whose winding number about it is not zero, and that do not pass through it
    int winding = 0;                    ///< of the contour that is looked at
    bool through = false;
};

/// In the order of rows. By a ray from each start through the edges in its row: O(m log q), and the edges in each row.
std::vector<Start> enclosed_starts(const SliceResult& result, std::span<const Contour> contours) {
    std::vector<Start> starts;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (contours[c].encloses_area()) {
            starts.push_back({c, result.points[contours[c].first_point]});
        }
    }
    sort_briefly(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.at.y < b.at.y; });
    if (starts.size() < 2) {
        return starts;  // one alone lies in no other
    }
    std::vector<Start*> met;
    const auto meet = [&](const Edge& edge) {
        auto start = std::lower_bound(starts.begin(), starts.end(), edge.low(),
                                      [](const Start& s, std::int32_t y) { return s.at.y < y; });
        for (; start != starts.end() && start->at.y <= edge.high(); ++start) {
            start->winding += edge.winding_about(start->at);
            start->through = start->through || edge.passes_through(start->at);
            met.push_back(&*start);
        }
    };
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (!contours[c].encloses_area()) {
            continue;
        }
        const std::span<const Point> points = result.points_of(contours[c]);
        for (std::size_t i = 0; i < points.size(); ++i) {
            meet({points[i], points[i + 1 == points.size() ? 0 : i + 1]});
        }
        for (Start* const start : met) {  // some more than once
            if (start->winding != 0 && !start->through) {
                start->around.push_back(c);
            }
            start->winding = 0;
        }
        for (Start* const start : met) {
            start->through = false;
        }
        met.clear();
    }
    return starts;
}

/// One layer's contours of one part, their own promises already checked. Indices are the layer's.
class LayerCheck {
public:
    LayerCheck(const SliceResult& result, std::size_t index, const Layer& layer)
        : result_(result), index_(index), layer_(layer), contours_(result.contours_of(layer_)) {}

    void run() const {
        if (keeps_contours(result_, index_)) {
            check_parents();
            check_roles();
        } else {
            check_roles_of_region();  // contours of a region may touch: a start may lie on the contour around it
        }
        check_order();
    }

private:
    static constexpr std::size_t none = static_cast<std::size_t>(-1);

    ResultPlace at(std::size_t c) const { return {index_, layer_.first_contour + c}; }

    std::size_t parent(std::size_t c) const {
        return contours_[c].parent < 0 ? none : static_cast<std::size_t>(contours_[c].parent) - layer_.first_contour;
    }

    Point start(std::size_t c) const { return result_.points[contours_[c].first_point]; }

    Int128 size(std::size_t c) const {
        const Int128 twice_area = to_int128(contours_[c].twice_area);
        return twice_area < 0 ? -twice_area : twice_area;
    }

    /// Any of several equally small ones will do.
    void check_parents() const {
        for (const Start& start : enclosed_starts(result_, contours_)) {
            const std::size_t c = start.contour;
            bool is_parent = start.around.empty();
            for (const std::size_t other : start.around) {
                is_parent = is_parent || other == parent(c);
            }
            for (const std::size_t other : start.around) {
                is_parent = is_parent && size(parent(c)) <= size(other);
            }
            at(c).require(is_parent && (!start.around.empty() || contours_[c].parent == -1),
                          "the parent is not the smallest contour around its start");
        }
    }

    struct Standing {
        std::int64_t winding = 0;
        std::size_t ancestors = 0;
        bool facets_stand = true;  ///< no winding number from the outside in to here is negative
    };

    /// Parents start strictly left of their children, so in the order of starts they come first.
    void check_roles() const {
        std::vector<std::size_t> by_start(contours_.size());
        std::iota(by_start.begin(), by_start.end(), std::size_t{0});
        sort_briefly(by_start.begin(), by_start.end(), [&](std::size_t a, std::size_t b) { return start(a) < start(b); });
        std::vector<Standing> standing(contours_.size());
        for (const std::size_t c : by_start) {
            if (!contours_[c].encloses_area()) {
                continue;
            }
            if (parent(c) != none) {
                standing[c] = standing[parent(c)];
                ++standing[c].ancestors;
            }
            standing[c].winding += contours_[c].orientation;
            standing[c].facets_stand = standing[c].facets_stand && standing[c].winding >= 0;
            at(c).require(suits(contours_[c], standing[c]),
                          "the role or its overruled mark does not follow from what lies around");
        }
    }

    static bool suits(const Contour& contour, const Standing& standing) {
        const bool overruled = (contour.flags & orientation_overruled) != 0;
        const bool outer = standing.facets_stand ? contour.orientation > 0 : standing.ancestors % 2 == 0;
        return overruled == !standing.facets_stand && contour.role == (outer ? Role::outer : Role::hole);
    }

    /// For a region that a fill rule leaves: outers lie in nothing or in holes, holes in outers.
    void check_roles_of_region() const {
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            if (contours_[c].encloses_area()) {
                const bool hole = contours_[c].role == Role::hole;
                const bool stands =
                    parent(c) == none ? !hole : contours_[parent(c)].role == (hole ? Role::outer : Role::hole);
                at(c).require(stands && (contours_[c].flags & orientation_overruled) == 0,
                              "the role does not follow from what lies around");
            }
        }
    }

    /// Outers, flats and open ones by start, but for pieces of polylines; after each outer its holes by start.
    void check_order() const {
        std::size_t head = none;  // the last contour that is no hole
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            const bool hole = contours_[c].role == Role::hole;
            at(c).require(!hole || owner(c) == head, "a hole that does not follow its outer");
            const std::size_t before = hole ? c - 1 : head;
            at(c).require(
                before == none || (hole && before == head) || start(c) >= start(before) || may_be_clipped(before, c),
                "contours are not in the order of their starts");
            head = hole ? head : c;
        }
    }

    /// Pieces of a polyline come in order along it.
    bool may_be_clipped(std::size_t a, std::size_t b) const {
        return !is_closed(contours_[a]) && !is_closed(contours_[b]) && !keeps_contours(result_, index_);
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

/// Parents, roles and order of a layer's contours, each of which keeps its own promises.
void check_nesting(const SliceResult& result, std::size_t index) {
    const Layer& layer = result.layers[index];
    const std::uint64_t end = layer.first_contour + layer.contour_count;
    const auto part_of = [&](std::uint64_t contour) { return result.contours[contour].part; };
    if (result.info.options.unite_parts) {
        for (std::uint64_t c = layer.first_contour; c < end; ++c) {
            ResultPlace{index, c}.require(part_of(c) < result.info.part_count || part_of(c) == several_parts,
                                          "there is no such part");
        }
        LayerCheck(result, index, layer).run();
        return;
    }
    Layer own = layer;  // the contours of one part
    for (std::uint64_t first = layer.first_contour; first < end; first += own.contour_count) {
        const ResultPlace at{index, first};
        const std::uint32_t part = part_of(first);
        at.require(part < result.info.part_count && (first == layer.first_contour || part > part_of(first - 1)),
                   "the part is none, or not in the order of parts");
        own.first_contour = first;
        own.contour_count = 1;
        while (first + own.contour_count < end && part_of(first + own.contour_count) == part) {
            ++own.contour_count;
        }
        for (const Contour& contour : result.contours_of(own)) {
            at.require(contour.parent < 0 || part_of(static_cast<std::uint64_t>(contour.parent)) == part,
                       "the parent is of another part");
        }
        LayerCheck(result, index, own).run();
    }
}

void check_layer(const SliceResult& result, std::size_t index) {
    constexpr unsigned known_flags = orientation_overruled | orientation_mixed | stitched | would_close;
    const Layer& layer = result.layers[index];
    const auto first = static_cast<std::int64_t>(layer.first_contour);
    const auto end = first + static_cast<std::int64_t>(layer.contour_count);
    std::uint64_t segments = 0;
    for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
        const Contour& contour = result.contours[c];
        const std::span<const Point> points = result.points_of(contour);
        const ResultPlace at{index, c};
        at.require(contour.role <= Role::open && (contour.flags & ~known_flags) == 0, "an unknown role or flag");
        at.require(contour.segments > 0, "no segments");
        check_points(contour, points, at);
        check_area(contour, points, at);
        check_orientation(contour, at);
        at.require(contour.parent == -1 || (first <= contour.parent && contour.parent < end),
                   "the parent lies in another layer");
        segments += contour.segments;
    }
    // A fill rule drops some and cuts others in two.
    ResultPlace{index}.require(segments == layer.segments || !keeps_contours(result, index),
                               "contours do not use every segment once");
    check_nesting(result, index);
}

void check_summary(const SliceResult& result) {
    SliceInfo counted;
    for (const Contour& contour : result.contours) {
        counted.segments += contour.segments;
        counted.holes += contour.role == Role::hole;
        counted.flat_contours += contour.role == Role::flat;
        counted.open_contours += contour.role == Role::open;
        counted.overruled_contours += (contour.flags & orientation_overruled) != 0;
        counted.would_close_contours += (contour.flags & would_close) != 0;
    }
    bool all_kept = true;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        counted.emptied_layers += result.layers[l].segments > 0 && result.layers[l].contour_count == 0;
        all_kept = all_kept && keeps_contours(result, l);
    }
    const SliceInfo& info = result.info;
    ResultPlace{}.require((counted.segments == info.segments || !all_kept) && counted.holes == info.holes &&
                              counted.flat_contours == info.flat_contours && counted.open_contours == info.open_contours &&
                              counted.overruled_contours == info.overruled_contours &&
                              counted.would_close_contours == info.would_close_contours &&
                              counted.emptied_layers == info.emptied_layers,
                          "the summary's counts are not those of the contours");
}

}  // namespace

void ResultPlace::require(bool kept, std::string_view broken) const {
    if (kept) {
        return;
    }
    std::string text;
    const auto name = [&](const char* noun, const std::optional<std::size_t>& index) {
        if (index) {
            text += (text.empty() ? "" : ", ") + std::string(noun) + " " + std::to_string(*index);
        }
    };
    name("layer", layer);
    name("contour", contour);
    name("point", point);
    Error error;
    error.message = text + (text.empty() ? "" : ": ") + std::string(broken);
    error.plane = layer ? static_cast<std::int64_t>(*layer) : -1;
    throw Refused{std::move(error)};
}

void check_offsets(const SliceResult& result) {
    std::uint64_t next_contour = 0;
    std::uint64_t next_point = 0;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        const Layer& layer = result.layers[l];
        const ResultPlace at_layer{l};
        at_layer.require(l == 0 || layer.plane > result.layers[l - 1].plane, "the plane is not above the one before");
        at_layer.require(layer.first_contour == next_contour, "does not begin where the layer before ends");
        at_layer.require(layer.contour_count <= result.contours.size() - next_contour, "reaches past the last contour");
        for (; next_contour < layer.first_contour + layer.contour_count; ++next_contour) {
            const Contour& contour = result.contours[next_contour];
            const ResultPlace at{l, next_contour};
            at.require(contour.first_point == next_point, "does not begin where the contour before ends");
            at.require(contour.point_count <= result.points.size() - next_point, "reaches past the last point");
            next_point += contour.point_count;
        }
    }
    ResultPlace{}.require(next_contour == result.contours.size() && next_point == result.points.size(),
                          "contours or points are left over behind the last layer");
}

void check_structure(const SliceResult& result, std::span<const Part> parts, const Parallel& parallel) {
    check_offsets(result);
    check_planes(result);
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        parallel.stop_if_asked();
        check_layer(result, l);
    }
    check_summary(result);
    check_origins(result, parts);
}

}  // namespace lamella
