#include "slicing/overlay/layer_clip.hpp"

#include <algorithm>

#include "base/numbers.hpp"
#include "base/sort.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/regions/snap_rounding.hpp"

namespace lamella {

namespace {

constexpr std::size_t polyline_work = 32;  ///< as StopPace counts it
constexpr std::size_t edges_at_once = BoxBlock<Point>::lanes;

std::uint64_t magnitude_of(Int128 value) noexcept {
    return static_cast<std::uint64_t>(value < 0 ? -value : value);
}

/// Earlier along the edge. Parts and wholes are at most 2^63.
constexpr auto comes_earlier = [](const auto& a, const auto& b) noexcept {
    return Word128{a.part} * b.whole < Word128{b.part} * a.whole;
};

}  // namespace

std::uint32_t LayerClip::run(const Layers& lines, const LayerSet& by, const ClipOptions& options, double grid_mm,
                             std::uint64_t n, BandOutput& out) {
    options_ = options;
    read_region(by, grid_mm, n);
    const std::size_t before = out.contours.size();
    std::uint32_t number = 0;
    std::uint32_t last = 0;
    for (const Path& line : reader_.list_lines({.layers = lines}, n)) {
        last = clip({line.item.points, line.item.count}, line.item.closed, number, out) ? number + 1 : last;
        ++number;
    }
    out.layer_contours.push_back(static_cast<std::uint32_t>(out.contours.size() - before));
    return last;
}

void LayerClip::read_region(const LayerSet& by, double grid_mm, std::uint64_t n) {
    runs_.clear();
    weights_.clear();
    for (const Path& path : reader_.list_region(by, n, grid_mm, nester_)) {
        runs_.add({.points = {path.item.points, path.item.count}, .contour = weights_.size()});
        weights_.push_back(path.is_backward() ? -1 : 1);
    }
    runs_.cut(0);
}

/// Returns whether any piece is left.
bool LayerClip::clip(std::span<const Point> points, bool closed, std::uint32_t number, BandOutput& out) {
    points_.clear();
    ends_.clear();
    sides_are_known_ = in_piece_ = false;
    bool is_first_edge = true;
    bool begins_in_piece = false;
    const std::size_t edges = points.size() - (closed || points.empty() ? 0 : 1);
    worker_.spend(polyline_work);
    for (std::size_t i = 0; i < edges; ++i) {
        const Point next = points[i + 1 < points.size() ? i + 1 : 0];
        if (points[i] != next) {
            begin_edge(points[i], next);
            begins_in_piece = is_first_edge ? in_piece_ : begins_in_piece;
            is_first_edge = false;
            follow_edge();
        }
    }
    const bool goes_on = closed && in_piece_ && begins_in_piece && !ends_.empty();  // the last piece, in the first
    for (std::size_t i = 0; goes_on && i < ends_[0]; ++i) {
        add_point(points_[i]);
    }
    if (in_piece_) {
        ends_.push_back(points_.size());
    }
    return append_pieces(goes_on ? 1 : 0, number, out);
}

void LayerClip::begin_edge(Point a, Point b) {
    a_ = a;
    b_ = b;
    dx_ = static_cast<double>(b.x) - a.x;
    dy_ = static_cast<double>(b.y) - a.y;
    if (!sides_are_known_) {
        sides_ = {};
        find_start(runs_.boxes().levels() - 1, 0);
    }
    if (is_wanted() != in_piece_) {
        turn(a);
    }
}

void LayerClip::follow_edge() {
    find_crossings();
    sides_are_known_ = true;
    for (auto at = crossings_.begin(); at != crossings_.end();) {
        const Crossing here = *at;
        if (here.part == here.whole) {
            sides_are_known_ = false;  // beyond the end, which lies on the boundary
            break;
        }
        for (; at != crossings_.end() && !comes_earlier(here, *at); ++at) {
            sides_.pass(at->weight, side_of_line_at(at->edge), side_of_line_at(at->edge + 1));
        }
        if (is_wanted() != in_piece_) {
            turn(rounded_crossing(a_, b_, runs_.points()[here.edge], runs_.points()[here.edge + 1]));
        }
    }
    sides_are_known_ = sides_are_known_ && sides_.left == sides_.right;
    if (in_piece_) {
        add_point(b_);
    }
}

/// Of what lies in the box, for find_start(): beside the line and ahead of its start it does not matter.
LayerClip::Place LayerClip::place_of(const FlatBox& box) const noexcept {
    if (side_of_box(a_, dx_, dy_, box) != 0) {
        return Place::no_matter;
    }
    const int across = side_of_box(a_, -dy_, dx_, box);
    return across == 0 ? Place::unclear : (across > 0 ? Place::behind : Place::no_matter);
}

/// Passes all that crosses the line at a_ and behind it, of the runs in a block of the tree. Runs that follow one another
/// are the end of a contour, whole contours, which lead back to where they start, and the start of another; or a stretch of
/// one.
void LayerClip::find_start(std::size_t level, std::size_t block) {
    constexpr std::size_t fan = BoxTree<Point>::fan;
    const std::span<const EdgeRun> runs = runs_.runs();
    worker_.spend(fan);
    for (std::size_t lane = 0; lane < fan; ++lane) {
        const std::size_t child = block * fan + lane;
        const std::size_t begin = child << (3 * level);
        if (begin >= runs.size()) {
            return;
        }
        const Place place = place_of(runs_.boxes().block(level, block)[lane]);
        if (place == Place::behind) {
            const EdgeRun& first = runs[begin];
            const EdgeRun& last = runs[std::min(runs.size(), (child + 1) << (3 * level)) - 1];
            sides_.pass(weight_of(first), side_of_line_at(first.begin), side_of_line_at(runs_.path_of(first).end));
            sides_.pass(weight_of(last), side_of_line_at(runs_.path_of(last).begin), side_of_line_at(last.end));
        } else if (place == Place::unclear && level > 0) {
            find_start(level - 1, child);
        } else if (place == Place::unclear) {
            find_start_along(runs[begin].begin, runs[begin].end, weight_of(runs[begin]));
        }
    }
}

/// The same of the edges [begin, end) of a run.
void LayerClip::find_start_along(std::size_t begin, std::size_t end, int weight) {
    const Point* const points = runs_.points();
    worker_.spend(1);
    Place place = place_of(FlatBox::around(points[begin], points[end]));
    const int from = side_of_line_at(begin);
    const int to = side_of_line_at(end);
    if (place == Place::unclear && end - begin == 1) {
        place = (to - from) * side_of(points[begin], points[end], a_) <= 0 ? Place::behind : Place::no_matter;
    }
    if (place == Place::behind) {
        sides_.pass(weight, from, to);
    } else if (place == Place::unclear) {
        find_start_along(begin, begin + (end - begin) / 2, weight);
        find_start_along(begin + (end - begin) / 2, end, weight);
    }
}

/// In order.
void LayerClip::find_crossings() {
    crossings_.clear();
    const auto enter = [&](const BoxBlock<Point>& block) {
        worker_.spend(edges_at_once);
        return lanes_along(block, a_, b_);
    };
    runs_.boxes().search_if(enter, [&](std::size_t i) {
        const EdgeRun& run = runs_.runs()[i];
        compare(run.begin, run.end, weight_of(run));
        return true;
    });
    sort_briefly(crossings_.begin(), crossings_.end(), [this](const Crossing& a, const Crossing& b) {
        worker_.spend(1);
        return comes_earlier(a, b);
    });
}

/// The edges [begin, end) of a run, eight at once.
void LayerClip::compare(std::size_t begin, std::size_t end, int weight) {
    const Point* const points = runs_.points();
    const FlatBox box = FlatBox::around(points[begin], points[end]);
    worker_.spend(edges_at_once);
    if (!box.meets(FlatBox::around(a_, b_)) || side_of_box(a_, dx_, dy_, box) != 0) {
        return;
    }
    if (end - begin > edges_at_once) {
        compare(begin, begin + (end - begin) / 2, weight);
        compare(begin + (end - begin) / 2, end, weight);
        return;
    }
    BoxBlock<Point> boxes;
    boxes.set_edges(points + begin);  // after the last point there is room
    each_lane(lanes_along(boxes, a_, b_) & all_eight >> (edges_at_once - (end - begin)),
              [&](std::size_t lane) { add_crossing(begin + lane, weight); });
}

/// If there is one, beyond the start of the edge that is followed.
void LayerClip::add_crossing(std::size_t edge, int weight) {
    const Point from = runs_.points()[edge];
    const Point to = runs_.points()[edge + 1];
    const int turns = side_of_line_at(edge + 1) - side_of_line_at(edge);
    if (turns * side_of(from, to, a_) > 0 && turns * side_of(from, to, b_) <= 0) {
        const Int128 part = side_of_line(from, to, a_);
        crossings_.push_back({magnitude_of(part), magnitude_of(part - side_of_line(from, to, b_)), edge, weight});
    }
}

bool LayerClip::is_wanted() const noexcept {
    const bool left = sides_.left > 0;
    const bool right = sides_.right > 0;
    return (left == right ? left : options_.boundary_is_inside) == options_.inside;
}

/// Equal consecutive ones are stored once.
void LayerClip::add_point(Point p) {
    if (points_.size() == (ends_.empty() ? 0 : ends_.back()) || points_.back() != p) {
        points_.push_back(p);
    }
}

/// Ends the piece, or begins one.
void LayerClip::turn(Point at) {
    add_point(at);
    if (in_piece_) {
        ends_.push_back(points_.size());
    }
    in_piece_ = !in_piece_;
}

/// From piece `first` on, but for those that rounding makes a point.
bool LayerClip::append_pieces(std::size_t first, std::uint32_t number, BandOutput& out) {
    const std::size_t before = out.contours.size();
    for (std::size_t i = first; i < ends_.size(); ++i) {
        const std::size_t begin = i == 0 ? 0 : ends_[i - 1];
        const std::size_t count = ends_[i] - begin;
        if (count < 2) {
            continue;
        }
        std::copy_n(points_.data() + begin, count, out.reserve_points(count));
        Contour& contour = out.contours.emplace_back();
        contour.first_point = out.point_count;
        contour.point_count = static_cast<std::uint32_t>(count);
        contour.segments = contour.point_count - 1;
        contour.role = Role::open;
        contour.part = number;
        out.totals.add(contour);
        out.point_count += count;
        worker_.spend(polyline_work + count);
    }
    return out.contours.size() > before;
}

}  // namespace lamella
