// Parents, roles and order of contours; shares nothing with the nesting stage.
#include <algorithm>
#include <cstdint>
#include <map>
#include <numeric>
#include <span>
#include <vector>

#include "audit/structure.hpp"
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

/// For each contour with area: the others with area whose winding number about its start is not zero and that do not pass
/// through it. By a ray through the edges in the start's row: O(m log m) and, for each contour, the edges in its row.
std::vector<std::vector<std::size_t>> enclosures_of(const SliceResult& result, std::span<const Contour> contours) {
    struct Winding {
        int number = 0;
        bool through = false;
    };
    const auto start = [&](std::size_t c) { return result.points[contours[c].first_point]; };
    std::vector<Edge> edges;
    std::vector<std::size_t> queries;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (has_area(contours[c])) {
            queries.push_back(c);
            const std::span<const Point> points = result.points_of(contours[c]);
            for (std::size_t i = 0; i < points.size(); ++i) {
                edges.push_back({points[i], points[i + 1 == points.size() ? 0 : i + 1], c});
            }
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.low() < b.low(); });
    std::sort(queries.begin(), queries.end(), [&](std::size_t a, std::size_t b) { return start(a).y < start(b).y; });
    std::vector<std::vector<std::size_t>> around(contours.size());
    std::vector<Edge> row;  // the edges that reach the current query's y
    std::size_t next = 0;
    for (const std::size_t query : queries) {
        const Point at = start(query);
        for (; next < edges.size() && edges[next].low() <= at.y; ++next) {
            row.push_back(edges[next]);
        }
        std::erase_if(row, [&](const Edge& edge) { return edge.high() < at.y; });
        std::map<std::size_t, Winding> windings;
        for (const Edge& edge : row) {
            Winding& own = windings[edge.contour];
            own.number += edge.winding_about(at);
            own.through = own.through || edge.passes_through(at);
        }
        for (const auto& [contour, own] : windings) {
            if (own.number != 0 && !own.through) {
                around[query].push_back(contour);
            }
        }
    }
    return around;
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
        const auto enclosures = enclosures_of(result_, contours_);
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            const std::vector<std::size_t>& around = enclosures[c];
            bool is_parent = around.empty();
            for (const std::size_t other : around) {
                is_parent = is_parent || other == parent(c);
            }
            for (const std::size_t other : around) {
                is_parent = is_parent && size(parent(c)) <= size(other);
            }
            at(c).require(is_parent && (!around.empty() || contours_[c].parent == -1),
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
            if (has_area(contours_[c])) {
                const bool hole = contours_[c].role == Role::hole;
                const bool stands =
                    parent(c) == none ? !hole : contours_[parent(c)].role == (hole ? Role::outer : Role::hole);
                at(c).require(stands && (contours_[c].flags & orientation_overruled) == 0,
                              "the role does not follow from what lies around");
            }
        }
    }

    /// Outers, flats and open ones by start; after each outer its holes by start.
    void check_order() const {
        std::size_t head = none;  // the last contour that is no hole
        for (std::size_t c = 0; c < contours_.size(); ++c) {
            const bool hole = contours_[c].role == Role::hole;
            at(c).require(!hole || owner(c) == head, "a hole that does not follow its outer");
            const std::size_t before = hole ? c - 1 : head;
            at(c).require(before == none || (hole && before == head) || start(c) >= start(before),
                          "contours are not in the order of their starts");
            head = hole ? head : c;
        }
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

}  // namespace

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

}  // namespace lamella
