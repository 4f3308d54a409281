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

void Fill::fill(FillRule rule, FunctionRef<void(std::span<const Point>)> take) {
    // Points on straight lines are kept: a contour that nothing touches comes out as it went in.
    ClipperLib::Clipper clipper(ClipperLib::ioPreserveCollinear);
    clipper.AddPaths(clipping_->contours, ClipperLib::ptSubject, true);
    const ClipperLib::PolyFillType type = rule == FillRule::even_odd   ? ClipperLib::pftEvenOdd
                                          : rule == FillRule::non_zero ? ClipperLib::pftNonZero
                                                                       : ClipperLib::pftPositive;
    ClipperLib::Paths region;
    clipper.Execute(ClipperLib::ctUnion, region, type, type);
    for (const ClipperLib::Path& path : region) {
        clipping_->points.clear();
        for (const ClipperLib::IntPoint& point : path) {
            clipping_->points.push_back({static_cast<std::int32_t>(point.X), static_cast<std::int32_t>(point.Y)});
        }
        take(clipping_->points);
    }
}

}  // namespace lamella
