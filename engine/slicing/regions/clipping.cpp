#include "slicing/regions/clipping.hpp"

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#include <clipper.hpp>

#include "base/stop_pace.hpp"
#include "slicing/regions/contacts.hpp"
#include "slicing/regions/sweep_cost.hpp"

namespace lamella {

namespace {

using ClipperLib::Path;
using ClipperLib::Paths;

using Levels = std::vector<Paths>;  // level i is the area that at least i + 1 contours cover

constexpr std::uint64_t most_cost = std::uint64_t{1} << 30;  // looks at an edge, of 10 to 40 ns
constexpr std::uint64_t least_cost = 128;                    // of a clipping, however small

/// How a region is computed. The library sweeps along y, so that it solves turned paths by other steps.
struct Way {
    bool halved;  ///< halves of the contours are clipped recursively, then combined; else all contours at once
    bool turned;  ///< x and y are swapped
};

/// A closed contour in the library's form.
struct Source {
    Path path;
    std::uint32_t times;
    bool meets_itself;
};

void add_edges(const Path& path, SweepCost& cost) {
    for (std::size_t i = 0; i < path.size(); ++i) {
        cost.add_edge(path[i].Y, path[i + 1 < path.size() ? i + 1 : 0].Y);
    }
}

Point to_point(const ClipperLib::IntPoint& point) noexcept {
    return {static_cast<std::int32_t>(point.X), static_cast<std::int32_t>(point.Y)};
}

/// Whether the point lies within rounding of the closed path.
bool is_near_path(const ClipperLib::IntPoint& point, const Path& path) {
    for (std::size_t i = 0; i < path.size(); ++i) {
        const ClipperLib::IntPoint& to = path[i + 1 < path.size() ? i + 1 : 0];
        if (is_near(to_point(point), to_point(path[i]), to_point(to), clipping_reach)) {
            return true;
        }
    }
    return false;
}

/// The library compares crossing pieces with each other, and visits all points to join two pieces.
std::uint64_t looks_at_pieces(const Clipping::Meetings& meetings, std::uint64_t points) noexcept {
    return meetings.contacts * meetings.contacts / 128 + meetings.shared * points / 4;
}

ClipperLib::PolyFillType library_rule(FillRule rule) noexcept {
    return rule == FillRule::even_odd   ? ClipperLib::pftEvenOdd
           : rule == FillRule::non_zero ? ClipperLib::pftNonZero
                                        : ClipperLib::pftPositive;
}

/// Clipper may free twice when an allocation fails, so as much memory as it needs is allocated and released beforehand.
void require_memory(std::size_t points) {
    constexpr std::size_t bytes_a_point = 512;
    void* volatile block = ::operator new(bytes_a_point* points);
    ::operator delete(block);
}

/// Points within straight lines are dropped: with them the library does not join all edges that run along each other.
void clip(ClipperLib::ClipType type, const Paths& a, const Paths& b, ClipperLib::PolyFillType rule, auto& region) {
    std::size_t points = 0;
    for (const Paths* paths : {&a, &b}) {
        for (const Path& path : *paths) {
            points += path.size();
        }
    }
    require_memory(points);
    ClipperLib::Clipper clipper;
    const bool any_a = clipper.AddPaths(a, ClipperLib::ptSubject, true);
    const bool any_b = clipper.AddPaths(b, ClipperLib::ptClip, true);
    // The library only reports that it failed: here no cause but memory is left.
    if ((any_a || any_b) && !clipper.Execute(type, region, rule, rule)) {
        throw std::bad_alloc();
    }
}

}  // namespace

struct Clipping::Cluster {
    std::vector<Source> sources;
    ClipperLib::IntPoint low, high;
    std::uint64_t spent = 0;
    StopPace pace;

    /// Nested rectangles around all contours, inside which the winding number is `winding`.
    Paths frames(std::int64_t winding) const {
        Paths frames;
        for (std::int64_t f = 1; f <= std::abs(winding); ++f) {
            frames.push_back(
                {{low.X - f, low.Y - f}, {high.X + f, low.Y - f}, {high.X + f, high.Y + f}, {low.X - f, high.Y + f}});
            if (winding < 0) {
                std::reverse(frames.back().begin(), frames.back().end());
            }
        }
        return frames;
    }

    Paths all(std::int64_t ambient) const {
        Paths paths = frames(ambient);
        for (const Source& source : sources) {
            paths.insert(paths.end(), source.times, source.path);
        }
        return paths;
    }

    /// To be asked before each call of the library.
    bool may_go_on(std::initializer_list<const Paths*> operands) {
        pace.ask();
        SweepCost cost;
        for (const Paths* operand : operands) {
            for (const Path& path : *operand) {
                add_edges(path, cost);
            }
        }
        spent += least_cost + cost.looks();
        return spent <= most_cost;
    }

    /// Empty once too much is spent, as are the results of all functions below.
    Paths combined(ClipperLib::ClipType type, const Paths& a, const Paths& b) {
        Paths region;
        if (may_go_on({&a, &b})) {
            clip(type, a, b, ClipperLib::pftEvenOdd, region);
        }
        return region;
    }

    Paths filled(const Paths& contours, ClipperLib::PolyFillType rule) {
        Paths region;
        if (may_go_on({&contours})) {
            clip(ClipperLib::ctUnion, contours, {}, rule, region);
        }
        return region;
    }

    Paths halved_even_odd(std::span<const Source> some) {
        if (some.size() > 1) {
            return combined(ClipperLib::ctXor, halved_even_odd(some.first(some.size() / 2)),
                            halved_even_odd(some.subspan(some.size() / 2)));
        }
        if (some.empty() || some[0].times % 2 == 0) {
            return {};
        }
        return some[0].meets_itself ? filled({some[0].path}, ClipperLib::pftEvenOdd) : Paths{some[0].path};
    }

    /// The levels of both together: where i of one and j of the other cover, i + j cover. At most `most` levels.
    Levels stacked(const Levels& a, const Levels& b, std::size_t most) {
        Levels levels;
        for (std::size_t count = 1; count <= std::min(most, a.size() + b.size()); ++count) {
            Paths level = combined(ClipperLib::ctUnion, count <= a.size() ? a[count - 1] : Paths{},
                                   count <= b.size() ? b[count - 1] : Paths{});
            for (std::size_t i = 1; i < count && spent <= most_cost; ++i) {
                if (i <= a.size() && count - i <= b.size()) {
                    level = combined(ClipperLib::ctUnion, level,
                                     combined(ClipperLib::ctIntersection, a[i - 1], b[count - i - 1]));
                }
            }
            if (level.empty()) {  // and so are all above it
                break;
            }
            levels.push_back(std::move(level));
        }
        return levels;
    }

    /// The levels of the contours whose orientation is `sign`.
    Levels halved_levels(std::span<const Source> some, int sign, std::size_t most) {
        if (some.size() > 1) {
            return stacked(halved_levels(some.first(some.size() / 2), sign, most),
                           halved_levels(some.subspan(some.size() / 2), sign, most), most);
        }
        return some.empty() ? Levels{} : levels_of(some[0], sign, most);
    }

    Levels levels_of(const Source& source, int sign, std::size_t most) {
        Levels levels;
        const auto add = [&](const Paths& cover) {
            levels.insert(levels.end(), std::min<std::size_t>(source.times, most - levels.size()), cover);
        };
        if (!source.meets_itself) {
            if (ClipperLib::Orientation(source.path) == (sign > 0)) {
                add({source.path});
            }
            return levels;
        }
        for (std::int64_t less = 0; levels.size() < most; ++less) {
            Paths contour = frames(-less);
            contour.push_back(source.path);
            if (sign < 0) {
                std::reverse(contour.back().begin(), contour.back().end());
            }
            const Paths cover = filled(contour, ClipperLib::pftPositive);
            if (cover.empty()) {
                break;
            }
            add(cover);
        }
        return levels;
    }

    bool has_both_signs(std::int64_t ambient) const {
        bool sign[2] = {ambient<0, ambient> 0};
        for (const Source& source : sources) {
            sign[0] = sign[0] || source.meets_itself || !ClipperLib::Orientation(source.path);
            sign[1] = sign[1] || source.meets_itself || ClipperLib::Orientation(source.path);
        }
        return sign[0] && sign[1];
    }

    Paths halved_signed(FillRule rule, std::int64_t ambient) {
        const std::size_t most = has_both_signs(ambient) ? std::numeric_limits<std::size_t>::max() : 1;
        Levels up = halved_levels(sources, 1, most);
        Levels down = halved_levels(sources, -1, most);
        Levels around;
        const Paths rectangles = frames(ambient);
        std::for_each(rectangles.rbegin(), rectangles.rend(), [&](const Path& frame) { around.push_back({frame}); });
        Levels& more = ambient > 0 ? up : down;
        more = stacked(more, around, most);
        up.resize(std::max(up.size(), down.size()));
        down.resize(up.size());
        Paths region;
        for (std::size_t i = 0; i < up.size(); ++i) {
            const auto type = rule == FillRule::non_zero ? ClipperLib::ctXor : ClipperLib::ctDifference;
            region = combined(ClipperLib::ctUnion, region, combined(type, up[i], down[i]));
        }
        return region;
    }

    /// Swaps x and y, and reverses paths so that solid stays on the left.
    void turn() {
        for (Source& source : sources) {
            for (ClipperLib::IntPoint& point : source.path) {
                std::swap(point.X, point.Y);
            }
            std::reverse(source.path.begin(), source.path.end());
        }
        std::swap(low.X, low.Y);
        std::swap(high.X, high.Y);
    }

    /// Whether turned paths cost far less, as for upright teeth side by side.
    bool is_for_turning() {
        std::uint64_t looks[2] = {0, 0};
        for (const bool turned : {false, true}) {
            SweepCost cost;
            for (const Source& source : sources) {
                add_edges(source.path, cost);
            }
            looks[turned ? 1 : 0] = cost.looks();
            turn();
        }
        return looks[1] < looks[0] / 4;
    }

    bool is_consistent(const Region& region);
    /// Null once too much is spent.
    std::unique_ptr<Region> find(FillRule rule, std::int64_t ambient, Way way);
};

Clipping::Clipping() : cluster_(std::make_unique<Cluster>()) {}
Clipping::~Clipping() = default;

void Clipping::follow(const StopCheck& host) noexcept {
    cluster_->pace.follow(host);
}

void Clipping::clear() {
    cluster_->sources.clear();
}

void Clipping::begin() noexcept {
    cluster_->spent = 0;
}

void Clipping::add(const NestItem& contour, std::uint32_t times, bool meets_itself) {
    ClipperLib::IntPoint& low = cluster_->low;
    ClipperLib::IntPoint& high = cluster_->high;
    if (cluster_->sources.empty()) {
        low = {contour.box_min.x, contour.box_min.y};
        high = {contour.box_max.x, contour.box_max.y};
    }
    low.X = std::min<ClipperLib::cInt>(low.X, contour.box_min.x);
    low.Y = std::min<ClipperLib::cInt>(low.Y, contour.box_min.y);
    high.X = std::max<ClipperLib::cInt>(high.X, contour.box_max.x);
    high.Y = std::max<ClipperLib::cInt>(high.Y, contour.box_max.y);
    Path& path = cluster_->sources.emplace_back(Source{{}, times, meets_itself}).path;
    path.reserve(contour.count);
    for (std::uint32_t i = 0; i < contour.count; ++i) {
        path.emplace_back(contour.from_start(i).x, contour.from_start(i).y);
    }
}

/// What one way of clipping gave.
struct Clipping::Region {
    Way way;
    bool framed;  ///< its only contour without a parent is a frame around all
    bool consistent = false;
    ClipperLib::PolyTree tree;

    template <class See>
    void for_each(See see) const {
        for (const ClipperLib::PolyNode* node = tree.GetFirst(); node != nullptr; node = node->GetNext()) {
            if (!framed || node->Parent != &tree) {
                see(*node);
            }
        }
    }

    /// Whether both are consistent and their areas differ by no more than rounding explains: a unit or so at each point.
    bool agrees_with(const Region& other) const {
        if ((!way.halved && !other.way.halved) || !consistent || !other.consistent) {
            return false;
        }
        double area[2] = {0, 0};
        double length = 0;
        for (const Region* region : {this, &other}) {
            region->for_each([&](const ClipperLib::PolyNode& node) {
                const Path& path = node.Contour;
                area[region == this ? 0 : 1] += ClipperLib::Area(path);
                for (std::size_t i = 0; i < path.size(); ++i) {
                    const ClipperLib::IntPoint& to = path[i + 1 < path.size() ? i + 1 : 0];
                    length += static_cast<double>(std::abs(to.X - path[i].X) + std::abs(to.Y - path[i].Y));
                }
            });
        }
        return std::abs(area[0] - area[1]) <= length / 2;
    }

    void take_all(FunctionRef<void(std::span<const Point>, std::int64_t)> take) const;
};

/// Whether holes lie in outers, and outers in holes: the library's tree is not always right.
bool Clipping::Cluster::is_consistent(const Region& region) {
    bool consistent = true;
    region.for_each([&](const ClipperLib::PolyNode& node) {
        consistent = consistent && ClipperLib::Orientation(node.Contour) != node.IsHole();
        const Path& around = node.Parent->Contour;
        bool inside = around.empty();
        for (std::size_t i = 0; i < node.Contour.size() && !inside && consistent; ++i) {
            const int side = ClipperLib::PointInPolygon(node.Contour[i], around);  // -1: on the line
            inside = side == 1;
            consistent = side != 0 || is_near_path(node.Contour[i], around);
            spent += around.size() / 4;
            pace.spend(around.size());
        }
    });
    return consistent;
}

std::unique_ptr<Clipping::Region> Clipping::Cluster::find(FillRule rule, std::int64_t ambient, Way way) {
    if (way.turned) {
        turn();
    }
    const Paths paths = !way.halved                  ? filled(all(ambient), library_rule(rule))
                        : rule == FillRule::even_odd ? combined(ClipperLib::ctXor, frames(ambient), halved_even_odd(sources))
                                                     : halved_signed(rule, ambient);
    if (way.turned) {
        turn();
    }
    if (!may_go_on({&paths})) {
        return nullptr;
    }
    auto region = std::make_unique<Region>();
    region->way = way;
    region->framed = fills(rule, ambient);
    // The tree is made of joined paths only: while joining, the library takes cubic time to keep its tree.
    clip(ClipperLib::ctUnion, paths, {}, ClipperLib::pftEvenOdd, region->tree);
    region->consistent = is_consistent(*region);
    return region;
}

bool Clipping::fill(FillRule rule, std::int64_t ambient, const Meetings& meetings,
                    FunctionRef<void(std::span<const Point>, std::int64_t)> take) {
    std::uint64_t points = 0;
    for (const Source& source : cluster_->sources) {
        points += source.path.size();
    }
    cluster_->spent += looks_at_pieces(meetings, points);
    const bool crowded = meetings.crowded;
    const bool turned = cluster_->is_for_turning();
    std::vector<std::unique_ptr<Region>> tried;
    for (const Way way : {Way{crowded, turned}, {!crowded, turned}, {!crowded, !turned}, {crowded, !turned}}) {
        tried.push_back(cluster_->find(rule, ambient, way));
        if (tried.back() == nullptr) {
            return false;
        }
        for (std::size_t other = 0; other + 1 < tried.size(); ++other) {
            if (tried[other]->agrees_with(*tried.back())) {
                tried[other]->take_all(take);
                return true;
            }
        }
    }
    return false;
}

void Clipping::Region::take_all(FunctionRef<void(std::span<const Point>, std::int64_t)> take) const {
    struct Taken {
        const ClipperLib::PolyNode* node;
        std::int64_t number;
    };
    std::vector<Taken> around;  // the ancestors of the last contour, and itself
    std::vector<Point> points;
    std::int64_t number = 0;
    for_each([&](const ClipperLib::PolyNode& node) {
        while (!around.empty() && around.back().node != node.Parent) {
            around.pop_back();
        }
        points.clear();
        for (const ClipperLib::IntPoint& point : node.Contour) {
            const Point own = to_point(point);
            points.push_back(way.turned ? Point{own.y, own.x} : own);
        }
        if (way.turned) {
            std::reverse(points.begin(), points.end());
        }
        take(points, around.empty() ? -1 : around.back().number);
        around.push_back({&node, number++});
    });
}

}  // namespace lamella
