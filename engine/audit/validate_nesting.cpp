// Parents, roles and order of contours, for validate(): shares nothing with the nesting stage.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "audit/validate.hpp"
#include "base/function_ref.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

struct Edge {
    Point from;
    Point to;
    std::size_t contour = 0;

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

std::vector<Edge> edges_by_low_end(const SliceResult& result, std::span<const Contour> contours) {
    std::vector<Edge> edges;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (!has_area(contours[c])) {
            continue;
        }
        const std::span<const Point> points = result.points_of(contours[c]);
        for (std::size_t i = 0; i < points.size(); ++i) {
            edges.push_back({points[i], points[i + 1 == points.size() ? 0 : i + 1], c});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.low() < b.low(); });
    return edges;
}

/// Starts of closed contours, lowest y first.
std::vector<std::size_t> queries_by_row(const SliceResult& result, std::span<const Contour> contours) {
    std::vector<std::size_t> queries;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (has_area(contours[c])) {
            queries.push_back(c);
        }
    }
    const auto row = [&](std::size_t c) { return result.points[contours[c].first_point].y; };
    std::sort(queries.begin(), queries.end(), [&](std::size_t a, std::size_t b) { return row(a) < row(b); });
    return queries;
}

/// Winding numbers about one point after another; resets only what it touched.
class Windings {
public:
    explicit Windings(std::size_t contours) : winding_(contours, 0), through_(contours, 0) {}

    void add(const Edge& edge, Point p) {
        const int winding = edge.winding_about(p);
        const bool through = edge.passes_through(p);
        if (winding != 0 || through) {
            winding_[edge.contour] += winding;
            through_[edge.contour] |= static_cast<char>(through);
            touched_.push_back(edge.contour);
        }
    }

    /// The contours strictly around the point; ready for the next one.
    void take_around(std::vector<std::size_t>& around) {
        around.clear();
        for (const std::size_t c : touched_) {
            if (winding_[c] != 0 && through_[c] == 0) {
                around.push_back(c);
            }
            winding_[c] = 0;
            through_[c] = 1;  // once is enough, though it was touched by many edges
        }
        for (const std::size_t c : touched_) {
            through_[c] = 0;
        }
        touched_.clear();
    }

private:
    std::vector<int> winding_;
    std::vector<char> through_;
    std::vector<std::size_t> touched_;
};

/// Calls visit(contour, around) for every closed contour with area of `layer`, where `around` lists the closed contours with
/// area whose winding number about the contour's start is not zero and that do not pass through it. Both index the layer's
/// contours. By a ray through the edges in the start's row: O(m log m) and, for each contour, the edges in its row.
void for_each_enclosure(const SliceResult& result, const Layer& layer,
                        FunctionRef<void(std::size_t contour, std::span<const std::size_t> around)> visit) {
    const std::span<const Contour> contours = result.contours_of(layer);
    const std::vector<Edge> edges = edges_by_low_end(result, contours);
    std::vector<Edge> row;  // the edges that reach the current query's y
    std::vector<std::size_t> around;
    Windings windings(contours.size());
    std::size_t next = 0;
    for (const std::size_t query : queries_by_row(result, contours)) {
        const Point start = result.points[contours[query].first_point];
        for (; next < edges.size() && edges[next].low() <= start.y; ++next) {
            row.push_back(edges[next]);
        }
        std::erase_if(row, [&](const Edge& edge) { return edge.high() < start.y; });
        for (const Edge& edge : row) {
            windings.add(edge, start);
        }
        windings.take_around(around);
        visit(query, around);
    }
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

    std::string at(std::size_t c) const { return layer_place(index_, layer_.first_contour + c); }

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
            return layer_place(index, first) + "the part is none, or not in the order of parts";
        }
        last_part = part;
        own.first_contour = first;
        own.contour_count = 1;
        while (first + own.contour_count < end && result.contours[first + own.contour_count].part == part) {
            ++own.contour_count;
        }
        for (const Contour& contour : result.contours_of(own)) {
            if (contour.parent >= 0 && result.contours[static_cast<std::size_t>(contour.parent)].part != part) {
                return layer_place(index, first) + "the parent is of another part";
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
            return layer_place(index, static_cast<std::size_t>(&contour - result.contours.data())) + "there is no such part";
        }
    }
    return LayerCheck(result, index, layer).run();
}

}  // namespace

Complaint complaint_about_nesting(const SliceResult& result, std::size_t layer) {
    return result.part_regions == PartRegions::united ? check_united(result, layer) : check_parts(result, layer);
}

}  // namespace lamella
