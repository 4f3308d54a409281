#include "7_nesting/fill.hpp"

#include <vector>

#include <clipper.hpp>

namespace lamella {

struct Fill::Clipping {
    ClipperLib::Paths contours;
    std::vector<Point> points;
};

Fill::Fill() : clipping_(std::make_unique<Clipping>()) {}
Fill::~Fill() = default;

void Fill::clear() {
    clipping_->contours.clear();
}

void Fill::add(std::span<const Point> before, std::span<const Point> after) {
    ClipperLib::Path& path = clipping_->contours.emplace_back();
    path.reserve(before.size() + after.size());
    for (const std::span<const Point> part : {before, after}) {
        for (const Point& point : part) {
            path.emplace_back(point.x, point.y);
        }
    }
}

void Fill::fill(FillRule rule, FunctionRef<void(std::span<const Point>, std::int64_t)> take) {
    // Points on straight lines are kept: a contour that nothing touches comes out as it went in.
    ClipperLib::Clipper clipper(ClipperLib::ioPreserveCollinear);
    clipper.AddPaths(clipping_->contours, ClipperLib::ptSubject, true);
    const ClipperLib::PolyFillType type = rule == FillRule::even_odd   ? ClipperLib::pftEvenOdd
                                          : rule == FillRule::non_zero ? ClipperLib::pftNonZero
                                                                       : ClipperLib::pftPositive;
    ClipperLib::PolyTree region;
    clipper.Execute(ClipperLib::ctUnion, region, type, type);
    struct Taken {
        const ClipperLib::PolyNode* node;
        std::int64_t number;
    };
    std::vector<Taken> around{{&region, -1}};  // the way down the tree to the contour before
    std::int64_t number = 0;
    for (const ClipperLib::PolyNode* node = region.GetFirst(); node != nullptr; node = node->GetNext()) {
        while (around.back().node != node->Parent) {
            around.pop_back();
        }
        clipping_->points.clear();
        for (const ClipperLib::IntPoint& point : node->Contour) {
            clipping_->points.push_back({static_cast<std::int32_t>(point.X), static_cast<std::int32_t>(point.Y)});
        }
        take(clipping_->points, around.back().number);
        around.push_back({node, number++});
    }
}

}  // namespace lamella
