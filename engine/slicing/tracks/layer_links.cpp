#include "slicing/tracks/layer_links.hpp"

#include <algorithm>
#include <tuple>

#include "base/sort.hpp"
#include "slicing/regions/snap_rounding.hpp"

namespace lamella {

namespace {

constexpr std::size_t track_work = 16;  ///< as StopPace counts it

void make_unique(Vector<TrackLink>& links, StopPace& pace) {
    const auto key = [](const TrackLink& link) { return std::pair(link.lower, link.upper); };
    sort_briefly(links.begin(), links.end(), [&](const TrackLink& a, const TrackLink& b) {
        pace.spend(1);
        return key(a) < key(b);
    });
    links.erase(
        std::unique(links.begin(), links.end(), [&](const TrackLink& a, const TrackLink& b) { return key(a) == key(b); }),
        links.end());
}

}  // namespace

void LayerLinks::run(const TrackLayer& lower, const TrackLayer& upper, Vector<TrackLink>& islands,
                     Vector<TrackLink>* voids) {
    islands_ = &islands;
    voids_ = voids;
    last_voids_ = {no_track, no_track};
    touches_.clear();
    begin(sides_[0], lower);
    begin(sides_[1], upper);
    last_.assign(lower.islands, no_track);
    if (voids_ != nullptr) {
        link_voids(lower.outside, upper.outside);
    }
    for (const auto ask : {&LayerLinks::ask_starts, &LayerLinks::ask_extremes}) {
        for (const std::size_t side : {0U, 1U}) {
            asked_.clear();
            (this->*ask)(sides_[side], sides_[1 - side]);
            look_up(sides_[1 - side]);
            link_asked(side);
        }
        mark(sides_[0], sides_[1]);
        mark(sides_[1], sides_[0]);
    }
    search();
    make_unique(islands, worker_);
    if (voids_ != nullptr) {
        link_open_points();
        make_unique(*voids, worker_);
    }
}

void LayerLinks::begin(Side& side, const TrackLayer& layer) {
    side.layer = layer;
    std::array<std::uint32_t, extremes> none{};
    none.fill(no_track);
    side.around.assign(layer.islands, none);
    side.outers.clear();
    for (std::uint32_t r = 0; r < layer.rings.size(); ++r) {
        if (layer.rings[r].is_outer && layer.rings[r].island != no_track) {
            side.outers.push_back(r);
        }
    }
    side.boxes.assign(
        side.outers.size(), [&](std::size_t i) { return layer.rings[side.outers[i]].box; }, worker_);
    worker_.spend(track_work * layer.rings.size());
}

void LayerLinks::ask_starts(const Side& side, const Side& other) {
    for (const std::uint32_t r : side.layer.by_size) {
        if (voids_ != nullptr || side.layer.rings[r].is_outer) {
            asked_.push_back({r, side.layer.rings[r].points.front(), no_track, other.layer.outside});
        }
    }
}

void LayerLinks::ask_extremes(const Side& side, const Side& other) {
    for (const std::uint32_t r : side.outers) {
        const TrackRing& ring = side.layer.rings[r];
        if (exceeds(side.near_island(ring.island).low, ring.box.high)) {
            continue;
        }
        std::array<Point, extremes - 1> points{ring.points.front(), ring.points.front(), ring.points.front()};
        for (const Point p : ring.points) {
            points[0] = p.x > points[0].x ? p : points[0];
            points[1] = p.y < points[1].y ? p : points[1];
            points[2] = p.y > points[2].y ? p : points[2];
        }
        worker_.spend(ring.points.size());
        for (const Point p : points) {
            asked_.push_back({r, p, no_track, other.layer.outside});
        }
    }
}

/// What the points lie in: by contours of the other layer, the smallest first.
void LayerLinks::look_up(const Side& in) {
    if (asked_.empty()) {
        return;
    }
    points_.assign(asked_.size(), [this](std::size_t i) { return asked_[i].point; });
    for (const std::uint32_t r : in.layer.by_size) {
        place(in.layer.rings[r]);
    }
}

void LayerLinks::place(const TrackRing& ring) {
    constexpr std::size_t many = 8;
    constexpr std::size_t points_per_step = 4;
    const auto count = static_cast<std::uint32_t>(ring.points.size());
    found_.clear();
    points_.find_in(ring.box, [this](Point, std::uint32_t i) {
        found_.push_back(i);
        return true;
    });
    worker_.spend(track_work + found_.size() * (found_.size() < many ? count / points_per_step : 1));
    inside_.clear();
    touching_.clear();
    if (found_.size() < many) {
        for (const std::uint32_t i : found_) {
            const nesting::Winding winding = nesting::winding_around(add_edges_, ring.points.data(), count, asked_[i].point);
            if (winding.strictly_inside()) {
                inside_.push_back(i);
            } else if (winding.on_boundary()) {
                touching_.push_back(i);
            }
        }
    } else {
        many_inside_.clear();
        for (const std::uint32_t i : found_) {
            many_inside_.add(asked_[i].point, i);
        }
        many_inside_.test(ring.points.data(), count, inside_, &touching_);
    }
    const auto set = [this](std::uint32_t i, std::uint32_t island, std::uint32_t empty) {
        asked_[i].island = island;
        asked_[i].empty = empty;
        points_.take_off(i);
    };
    for (const std::uint32_t i : inside_) {
        set(i, ring.is_outer ? ring.island : no_track, ring.is_outer ? no_track : ring.empty);
    }
    for (const std::uint32_t i : touching_) {
        set(i, no_track, no_track);
    }
}

/// A contour with a point that lies within something has that on both of its sides.
void LayerLinks::link_asked(std::size_t side) {
    Side& own = sides_[side];
    const auto in_order = [side](std::uint32_t a, std::uint32_t b) { return side == 0 ? TrackLink{a, b} : TrackLink{b, a}; };
    for (const Asked& asked : asked_) {
        const TrackRing& ring = own.layer.rings[asked.ring];
        if (asked.island != no_track) {
            islands_->push_back(in_order(ring.island, asked.island));
            auto& around = own.around[ring.island - own.layer.first_island];
            const auto at = std::find_if(around.begin(), around.end() - 1,
                                         [&](std::uint32_t island) { return island == no_track || island == asked.island; });
            *at = asked.island;
        } else if (asked.empty != no_track && voids_ != nullptr) {
            const TrackLink link = in_order(ring.empty, asked.empty);
            link_voids(link.lower, link.upper);
        }
    }
}

/// Finds for each island a box around all of the other layer's that it may overlap, as far as is not known yet; or that
/// holds the island.
void LayerLinks::mark(Side& of, const Side& others) {
    of.near.assign(of.layer.islands, FlatBox::nothing());
    for (const std::uint32_t r : others.outers.empty() ? std::span<const std::uint32_t>() : of.outers) {
        const TrackRing& ring = of.layer.rings[r];
        FlatBox& near = of.near[ring.island - of.layer.first_island];
        worker_.spend(track_work);
        others.boxes.search_if([&](const BoxBlock<Point>& block) { return block.meets(ring.box); },
                               [&](std::size_t i) {
                                   const TrackRing& other = others.layer.rings[others.outers[i]];
                                   if (!is_known(of, ring.island, others, other.island)) {
                                       near.include(other.box);
                                   }
                                   worker_.spend(1);
                                   return !(near.holds(ring.box.low) && near.holds(ring.box.high));
                               });
    }
}

/// Boxes around all contacts that may tell something new.
void LayerLinks::list_wanted() {
    wanted_.clear();
    for (const std::uint32_t r : sides_[0].outers) {
        const TrackRing& ring = sides_[0].layer.rings[r];
        const FlatBox& near = sides_[0].near_island(ring.island);
        if (near.meets(ring.box)) {
            wanted_.push_back({high_corner(near.low, ring.box.low), low_corner(near.high, ring.box.high)});
        }
    }
    for (const Side& side : sides_) {
        for (const std::uint32_t r : voids_ == nullptr ? std::span<const std::uint32_t>() : side.layer.by_size) {
            if (!side.layer.rings[r].is_outer) {
                wanted_.push_back(side.layer.rings[r].box);
            }
        }
    }
    worker_.spend(track_work * wanted_.size());
    order_by_place(
        std::span(wanted_), [](const FlatBox& box) { return box.low; }, worker_);
    wanted_boxes_.assign(
        wanted_.size(), [this](std::size_t i) { return wanted_[i]; }, worker_);
}

bool LayerLinks::is_wanted(const FlatBox& box) const {
    bool meets = false;
    wanted_boxes_.search_if([&](const BoxBlock<Point>& block) { return block.meets(box); },
                            [&](std::size_t) {
                                meets = true;
                                return false;
                            });
    return meets;
}

/// Edges in wanted boxes, and some beside them.
void LayerLinks::list_stretches(std::size_t side, std::uint32_t r) {
    constexpr std::size_t edges_at_once = 16;
    const TrackRing& ring = sides_[side].layer.rings[r];
    const std::span<const Point> points = ring.points;
    const FlatBox& near = sides_[side].near_island(ring.island);
    if (voids_ == nullptr && !near.meets(ring.box)) {
        return;
    }
    worker_.spend(2 * points.size());
    std::size_t first = 0;
    for (std::size_t i = 0; i + 1 < points.size(); i += edges_at_once) {
        const std::size_t end = std::min(i + edges_at_once, points.size() - 1);
        if (!is_wanted(FlatBox::around(points.subspan(i, end + 1 - i)))) {
            list_stretch(side, r, first, points.subspan(first, i + 1 - first));
            first = end;
        }
    }
    list_stretch(side, r, first, points.subspan(first));
    closing_edges_.push_back({points.back(), points.front()});
    if (is_wanted(FlatBox::around(points.back(), points.front()))) {
        list_stretch(side, r, points.size() - 1, closing_edges_.back());
    }
}

void LayerLinks::list_stretch(std::size_t side, std::uint32_t ring, std::size_t first, std::span<const Point> points) {
    if (points.size() > 1) {
        runs_.add({.points = points, .contour = stretches_.size(), .closed = false});
        stretches_.push_back({ring, static_cast<std::uint32_t>(first), side != 0});
    }
}

void LayerLinks::search() {
    runs_.clear();
    stretches_.clear();
    closing_edges_.clear();
    closing_edges_.reserve(sides_[0].layer.by_size.size() + sides_[1].layer.by_size.size());  // runs view them
    list_wanted();
    for (const std::size_t side : {0U, 1U}) {
        for (const std::uint32_t r : wanted_.empty() ? std::span<const std::uint32_t>() : sides_[side].layer.by_size) {
            list_stretches(side, r);
        }
    }
    if (stretches_.empty()) {
        return;
    }
    runs_.cut(0);
    pairs_.find(runs_, 0, 1, std::numeric_limits<std::uint64_t>::max(),
                [this](std::uint32_t a, std::size_t i, std::uint32_t b, std::size_t j) {
                    const EdgePath& a_path = runs_.paths()[a];
                    const EdgePath& b_path = runs_.paths()[b];
                    if (stretch_of(a_path).is_upper != stretch_of(b_path).is_upper) {
                        stretch_of(b_path).is_upper ? meet(a_path, i, b_path, j) : meet(b_path, j, a_path, i);
                    }
                });
}

/// `a` of the lower layer, `b` of the upper one.
void LayerLinks::meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    const TrackRing& lower = ring_of(stretch_of(a));
    const TrackRing& upper = ring_of(stretch_of(b));
    if (voids_ == nullptr && is_linked(lower.island, upper.island)) {
        return;
    }
    const Point* const points = runs_.points();
    if (edges_cross(points[i], points[i + 1], points[j], points[j + 1])) {
        link_islands(lower.island, upper.island);
        if (voids_ != nullptr) {
            cross_voids(points + i, points + j, {lower.empty, upper.empty});
        }
    } else {
        touch(a, i, b, j);
    }
}

/// What lies right of two edges that cross is open in both layers, unless corners of other contours lie where they cross.
void LayerLinks::cross_voids(const Point* lower, const Point* upper, TrackLink voids) {
    const Point at = rounded_crossing(lower[0], lower[1], upper[0], upper[1]);
    if (side_of(lower[0], lower[1], at) == 0 && side_of(upper[0], upper[1], at) == 0) {
        touches_.push_back({at, voids});
    } else {
        link_voids(voids.lower, voids.upper);
    }
}

/// A contact that is no crossing. Each belongs to the edges that begin there, or that it lies within.
void LayerLinks::touch(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    const Point* const points = runs_.points();
    const TrackRing& lower = ring_of(stretch_of(a));
    const TrackRing& upper = ring_of(stretch_of(b));
    if (points[i] == points[j]) {
        pass(lower, passage_at(a, i), upper, passage_at(b, j));
        return;
    }
    if (lies_within(points[i], j)) {
        pass(lower, passage_at(a, i), upper, {points[j], points[i], points[j + 1]});
    }
    if (lies_within(points[j], i)) {
        pass(lower, {points[i], points[j], points[i + 1]}, upper, passage_at(b, j));
    }
}

void LayerLinks::pass(const TrackRing& lower, const Passage& of_lower, const TrackRing& upper, const Passage& of_upper) {
    if (solids_overlap(of_lower, of_upper)) {
        link_islands(lower.island, upper.island);
    }
    if (voids_ == nullptr || (last_voids_.lower == lower.empty && last_voids_.upper == upper.empty)) {
        return;
    }
    if (of_lower.leads_to(of_upper.after)) {  // what lies right of both edges
        link_voids(lower.empty, upper.empty);
    } else {
        touches_.push_back({of_lower.at, {lower.empty, upper.empty}});
    }
}

/// At a point is one void of each layer. A contour may pass it within an edge, and meet no corner there: all are looked for.
void LayerLinks::link_open_points() {
    const auto key = [](const Touch& touch) { return std::tuple(touch.at, touch.voids.lower, touch.voids.upper); };
    sort_briefly(touches_.begin(), touches_.end(), [&](const Touch& a, const Touch& b) {
        worker_.spend(1);
        return key(a) < key(b);
    });
    const auto end =
        std::unique(touches_.begin(), touches_.end(), [&](const Touch& a, const Touch& b) { return key(a) == key(b); });
    for (auto touch = touches_.begin(); touch != end; ++touch) {
        passages_.clear();
        const FlatBox point{touch->at, touch->at};
        runs_.boxes().search_if([&](const BoxBlock<Point>& block) { return block.meets(point); },
                                [&](std::size_t i) {
                                    const EdgeRun& run = runs_.runs()[i];
                                    list_passages(touch->at, run.begin, run.end, runs_.path_of(run));
                                    return true;
                                });
        worker_.spend(track_work + passages_.size() * passages_.size());
        const bool is_open = std::any_of(passages_.begin(), passages_.end(), [this](const Passage& from) {
            return std::none_of(passages_.begin(), passages_.end(), [&](const Passage& p) { return p.holds(from.before); });
        });
        if (is_open) {
            link_voids(touch->voids.lower, touch->voids.upper);
        }
    }
}

/// Of edges of one run.
void LayerLinks::list_passages(Point at, std::size_t begin, std::size_t end, const EdgePath& path) {
    const Point* const points = runs_.points();
    if (!FlatBox::around(points[begin], points[end]).holds(at)) {
        return;
    }
    if (end - begin > 1) {
        list_passages(at, begin, begin + (end - begin) / 2, path);
        list_passages(at, begin + (end - begin) / 2, end, path);
    } else if (at == points[begin]) {
        passages_.push_back(passage_at(path, begin));
    } else if (lies_within(at, begin)) {
        passages_.push_back({points[begin], at, points[end]});
    }
}

/// And not at its end.
bool LayerLinks::lies_within(Point at, std::size_t edge) const noexcept {
    const Point a = runs_.points()[edge];
    const Point b = runs_.points()[edge + 1];
    return at != b && FlatBox::around(a, b).holds(at) && side_of(a, b, at) == 0;
}

/// Where the ring passes the point that the edge leaves.
Passage LayerLinks::passage_at(const EdgePath& path, std::size_t edge) const noexcept {
    const Stretch& stretch = stretch_of(path);
    const std::span<const Point> points = ring_of(stretch).points;
    const std::size_t at = stretch.first + (edge - path.begin);
    return {points[at == 0 ? points.size() - 1 : at - 1], points[at], points[at + 1 == points.size() ? 0 : at + 1]};
}

}  // namespace lamella
