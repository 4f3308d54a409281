#include "slicing/compare/contour_distance.hpp"

#include <algorithm>
#include <cmath>

#include "slicing/grid/distance.hpp"

namespace lamella {

void NearestEdges::assign(const LayerView& layer) {
    edges_.clear();
    for (const Contour& contour : layer.contours) {
        if (contour.encloses_area()) {
            const std::span<const Point> ring = layer.points_of(contour);
            Point from = ring.back();
            for (const Point to : ring) {
                edges_.push_back({from, to});
                from = to;
            }
        }
    }
    boxes_.assign(
        edges_.size(), [&](std::size_t i) { return FlatBox::around(edges_[i].from, edges_[i].to); }, worker_);
}

double NearestEdges::squared_distance(const Place& place, std::size_t edge) const noexcept {
    return lamella::squared_distance(place.x, place.y, edges_[edge].from, edges_[edge].to);
}

NearestEdges::Nearest NearestEdges::nearest(const Place& place, std::size_t hint) const {
    Nearest best{hint, squared_distance(place, hint)};
    const auto near = [&] {
        static constexpr double limit = 2147483647;
        const double reach = std::sqrt(best.squared) + 1;
        const auto bounded = [](double at) { return static_cast<std::int32_t>(std::clamp(at, -limit, limit)); };
        return FlatBox{{bounded(std::floor(place.x - reach)), bounded(std::floor(place.y - reach))},
                       {bounded(std::ceil(place.x + reach)), bounded(std::ceil(place.y + reach))}};
    };
    FlatBox box = near();
    worker_.spend(16);
    boxes_.search_if([&](const auto& block) { return block.meets(box); },
                     [&](std::size_t edge) {
                         worker_.spend(1);
                         if (const double squared = squared_distance(place, edge); squared < best.squared) {
                             best = {edge, squared};
                             box = near();
                         }
                         return true;
                     });
    return best;
}

/// The distance to one edge is convex along a line: where both ends of a stretch have the same nearest edge, none between
/// them lies farther than the ends. Other stretches are halved where they may still hold the farthest.
void NearestEdges::find_most(const Stretch& whole, Vector<Stretch>& left, double& most) const {
    left.push_back(whole);
    while (!left.empty()) {
        const Stretch at = left.back();
        left.pop_back();
        const auto bound_of = [&](std::size_t edge) {
            return std::max(squared_distance(at.from, edge), squared_distance(at.to, edge));
        };
        const double bound = std::min(bound_of(at.from_nearest.edge), bound_of(at.to_nearest.edge));
        const double dx = at.to.x - at.from.x;
        const double dy = at.to.y - at.from.y;
        if (at.from_nearest.edge == at.to_nearest.edge || bound <= most * (1 + 0x1p-40) || dx * dx + dy * dy <= 1) {
            continue;
        }
        const Place middle{at.from.x + dx / 2, at.from.y + dy / 2};
        const Nearest found = nearest(middle, at.from_nearest.edge);
        most = std::max(most, found.squared);
        left.push_back({at.from, middle, at.from_nearest, found});
        left.push_back({middle, at.to, found, at.to_nearest});
    }
}

Distances NearestEdges::distances_to(const NearestEdges& others) const {
    Distances all;
    double most = 0;  // squared
    Vector<Stretch> left(worker_.memory());
    Nearest last;
    for (const auto& [from, to] : edges_) {
        const Place begin{static_cast<double>(from.x), static_cast<double>(from.y)};
        const Place end{static_cast<double>(to.x), static_cast<double>(to.y)};
        const Nearest first = others.nearest(begin, last.edge);
        const Place middle{begin.x + (end.x - begin.x) / 2, begin.y + (end.y - begin.y) / 2};
        const Nearest between = others.nearest(middle, first.edge);
        last = others.nearest(end, between.edge);
        const double length = std::sqrt((end.x - begin.x) * (end.x - begin.x) + (end.y - begin.y) * (end.y - begin.y));
        all.length += length;
        all.sum += length * (std::sqrt(first.squared) + 4 * std::sqrt(between.squared) + std::sqrt(last.squared)) / 6;
        most = std::max({most, first.squared, between.squared, last.squared});
        others.find_most({begin, middle, first, between}, left, most);
        others.find_most({middle, end, between, last}, left, most);
    }
    all.most = std::sqrt(most);
    return all;
}

}  // namespace lamella
