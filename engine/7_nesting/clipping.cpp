#include "7_nesting/clipping.hpp"

#include <algorithm>
#include <vector>

#include <clipper.hpp>

namespace lamella {

namespace {

using ClipperLib::Path;
using ClipperLib::Paths;

constexpr std::uint64_t most_cost = std::uint64_t{1} << 32;  // some seconds

/// How a region is found. The library sweeps in the direction of y, so that turned paths are another problem to it.
struct Way {
    bool one_by_one;
    bool turned;  ///< x for y and y for x
};

/// A closed contour as the library has it.
struct Source {
    Path path;
    std::uint32_t times;
    bool meets_itself;
};

/// Of closed paths: how many points they have, and how often they turn upwards.
struct Extent {
    std::uint64_t points = 0;
    std::uint64_t valleys = 0;

    void add(const Path& path) {
        bool falling = false;
        points += path.size();
        for (std::size_t i = 0; i < path.size(); ++i) {
            const auto from = path[i].Y;
            const auto to = path[i + 1 < path.size() ? i + 1 : 0].Y;
            valleys += falling && to > from ? 1 : 0;
            falling = to < from || (falling && to == from);
        }
        ++valleys;  // where the walk began
    }
    void add(const Paths& paths) {
        for (const Path& path : paths) {
            add(path);
        }
    }
    /// In steps of some nanoseconds, as measured with rods across each other and side by side.
    std::uint64_t cost(std::uint64_t contacts) const noexcept { return points * valleys + contacts * contacts / 16; }
};

ClipperLib::PolyFillType library_rule(FillRule rule) noexcept {
    return rule == FillRule::even_odd   ? ClipperLib::pftEvenOdd
           : rule == FillRule::non_zero ? ClipperLib::pftNonZero
                                        : ClipperLib::pftPositive;
}

/// Points on straight lines are kept: a contour that nothing touches comes out as it went in.
ClipperLib::Clipper new_clipper() {
    return ClipperLib::Clipper(ClipperLib::ioPreserveCollinear);
}

}  // namespace

struct Clipping::Cluster {
    std::vector<Source> sources;
    ClipperLib::IntPoint low, high;
    std::uint64_t spent = 0;

    /// Rectangles around all, one in the other, whose winding numbers add up to `winding` within.
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

    /// Empty once too much is spent.
    Paths combined(ClipperLib::ClipType type, const Paths& a, const Paths& b) {
        Extent extent;
        extent.add(a);
        extent.add(b);
        spent += extent.cost(0);
        Paths region;
        if (spent <= most_cost) {
            ClipperLib::Clipper clipper = new_clipper();
            clipper.AddPaths(a, ClipperLib::ptSubject, true);
            clipper.AddPaths(b, ClipperLib::ptClip, true);
            clipper.Execute(type, region, ClipperLib::pftEvenOdd, ClipperLib::pftEvenOdd);
        }
        return region;
    }

    /// Empty once too much is spent.
    Paths filled(const Paths& contours, ClipperLib::PolyFillType rule) {
        Extent extent;
        extent.add(contours);
        spent += extent.cost(0);
        Paths region;
        if (spent <= most_cost) {
            ClipperLib::Clipper clipper = new_clipper();
            clipper.AddPaths(contours, ClipperLib::ptSubject, true);
            clipper.Execute(ClipperLib::ctUnion, region, rule, rule);
        }
        return region;
    }

    Paths one_by_one_even_odd(std::int64_t ambient) {
        Paths region = frames(ambient % 2);
        for (const Source& source : sources) {
            if (source.times % 2 != 0) {
                const Paths own = source.meets_itself ? filled({source.path}, ClipperLib::pftEvenOdd) : Paths{source.path};
                region = combined(ClipperLib::ctXor, region, own);
            }
        }
        return region;
    }

    /// levels[i] is where i + 1 covers or more lie on each other.
    void add_cover(std::vector<Paths>& levels, Paths cover, bool only_first) {
        for (std::size_t i = 0; !cover.empty() && (i == 0 || !only_first); ++i) {
            if (i == levels.size()) {
                levels.emplace_back();
            }
            Paths carried = only_first ? Paths{} : combined(ClipperLib::ctIntersection, levels[i], cover);
            levels[i] = combined(ClipperLib::ctUnion, levels[i], cover);
            cover = std::move(carried);
        }
    }

    /// Where the contour winds once or more, where twice or more, and so on, in the sense of `sign`.
    std::vector<Paths> covers_of(const Source& source, int sign) {
        const bool forwards = ClipperLib::Orientation(source.path) == (sign > 0);
        if (!source.meets_itself) {
            return forwards ? std::vector<Paths>{{source.path}} : std::vector<Paths>{};
        }
        std::vector<Paths> covers;
        for (std::int64_t less = 0; covers.empty() || !covers.back().empty(); ++less) {
            Paths contour = frames(-less);
            contour.push_back(source.path);
            if (sign < 0) {
                std::reverse(contour.back().begin(), contour.back().end());
            }
            covers.push_back(filled(contour, ClipperLib::pftPositive));
        }
        covers.pop_back();
        return covers;
    }

    bool has_both_signs(std::int64_t ambient) const {
        bool sign[2] = {ambient<0, ambient> 0};
        for (const Source& source : sources) {
            sign[0] = sign[0] || source.meets_itself || !ClipperLib::Orientation(source.path);
            sign[1] = sign[1] || source.meets_itself || ClipperLib::Orientation(source.path);
        }
        return sign[0] && sign[1];
    }

    Paths one_by_one_signed(FillRule rule, std::int64_t ambient) {
        const bool only_first = !has_both_signs(ambient);
        std::vector<Paths> levels[2];  // of negative covers, of positive ones
        for (const Path& frame : frames(ambient)) {
            add_cover(levels[ambient > 0 ? 1 : 0], {frame}, only_first);
        }
        for (const Source& source : sources) {
            for (const int sign : {-1, 1}) {
                for (const Paths& cover : covers_of(source, sign)) {
                    for (std::uint32_t t = 0; t < source.times && spent <= most_cost; ++t) {
                        add_cover(levels[sign > 0 ? 1 : 0], cover, only_first);
                    }
                }
            }
        }
        const std::size_t most = std::max(levels[0].size(), levels[1].size());
        levels[0].resize(most);
        levels[1].resize(most);
        Paths region;
        for (std::size_t i = 0; i < most; ++i) {
            const auto type = rule == FillRule::non_zero ? ClipperLib::ctXor : ClipperLib::ctDifference;
            region = combined(ClipperLib::ctUnion, region, combined(type, levels[1][i], levels[0][i]));
        }
        return region;
    }

    /// x and y change places; what is solid on the left stays so.
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

    std::unique_ptr<Region> find(FillRule rule, std::int64_t ambient, Way way);
};

Clipping::Clipping() : cluster_(std::make_unique<Cluster>()) {}
Clipping::~Clipping() = default;

void Clipping::clear() {
    cluster_->sources.clear();
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

/// What one way has found.
struct Clipping::Region {
    Way way;
    bool framed;  ///< its only contour that lies in none is a frame around all
    ClipperLib::PolyTree tree;

    template <class See>
    void for_each(See see) const {
        for (const ClipperLib::PolyNode* node = tree.GetFirst(); node != nullptr; node = node->GetNext()) {
            if (!framed || node->Parent != &tree) {
                see(*node);
            }
        }
    }

    /// Whether holes lie in outers and outers in holes: the library's tree is not always right.
    bool is_consistent() const {
        bool consistent = true;
        for_each([&](const ClipperLib::PolyNode& node) {
            consistent = consistent && ClipperLib::Orientation(node.Contour) != node.IsHole();
        });
        return consistent;
    }

    /// Clipping moves each point by a unit or so.
    bool agrees_with(const Region& other) const {
        if ((!way.one_by_one && !other.way.one_by_one) || !is_consistent() || !other.is_consistent()) {
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
        return std::abs(area[0] - area[1]) <= 2 * length;
    }

    void take_all(FunctionRef<void(std::span<const Point>, std::int64_t)> take) const;
};

std::unique_ptr<Clipping::Region> Clipping::Cluster::find(FillRule rule, std::int64_t ambient, Way way) {
    if (way.turned) {
        turn();
    }
    Paths paths = !way.one_by_one              ? all(ambient)
                  : rule == FillRule::even_odd ? one_by_one_even_odd(ambient)
                                               : one_by_one_signed(rule, ambient);
    if (way.turned) {
        turn();
    }
    ClipperLib::Clipper clipper = new_clipper();
    clipper.AddPaths(paths, ClipperLib::ptSubject, true);
    const ClipperLib::PolyFillType library = way.one_by_one ? ClipperLib::pftEvenOdd : library_rule(rule);
    auto region = std::make_unique<Region>();
    region->way = way;
    region->framed = fills(rule, ambient);
    clipper.Execute(ClipperLib::ctUnion, region->tree, library, library);
    return region;
}

bool Clipping::fill(FillRule rule, std::int64_t ambient, const Meetings& meetings,
                    FunctionRef<void(std::span<const Point>, std::int64_t)> take) {
    Extent extent;
    extent.add(cluster_->all(ambient));
    if (extent.cost(meetings.contacts) > most_cost) {
        return false;
    }
    std::vector<std::unique_ptr<Region>> tried;
    for (const Way way :
         {Way{meetings.crowded, false}, {!meetings.crowded, true}, {!meetings.crowded, false}, {meetings.crowded, true}}) {
        tried.push_back(cluster_->find(rule, ambient, way));
        if (cluster_->spent > most_cost) {
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
    std::vector<Taken> around;  // the way down the tree to the contour before
    std::vector<Point> points;
    std::int64_t number = 0;
    for_each([&](const ClipperLib::PolyNode& node) {
        while (!around.empty() && around.back().node != node.Parent) {
            around.pop_back();
        }
        points.clear();
        for (const ClipperLib::IntPoint& point : node.Contour) {
            const Point own{static_cast<std::int32_t>(point.X), static_cast<std::int32_t>(point.Y)};
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
