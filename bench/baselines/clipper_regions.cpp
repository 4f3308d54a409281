#include "clipper_regions.hpp"

#include <polyclipping/clipper.hpp>

namespace lamella::baselines {

namespace {

ClipperLib::PolyFillType fill_type(FillRule rule) {
    switch (rule) {
        case FillRule::even_odd:
            return ClipperLib::pftEvenOdd;
        case FillRule::positive:
            return ClipperLib::pftPositive;
        default:
            return ClipperLib::pftNonZero;
    }
}

ClipperLib::Paths grown(const ClipperLib::Paths& paths, double by, double miter_limit) {
    ClipperLib::ClipperOffset offset(miter_limit);
    offset.AddPaths(paths, ClipperLib::jtMiter, ClipperLib::etClosedPolygon);
    ClipperLib::Paths region;
    offset.Execute(region, by);
    return region;
}

}  // namespace

struct ClipperLayer::Parts {
    ClipperLib::Paths contours;
    ClipperLib::Paths region;
};

ClipperLayer::ClipperLayer(std::span<const std::span<const Point>> contours) : parts_(std::make_unique<Parts>()) {
    for (const std::span<const Point> contour : contours) {
        ClipperLib::Path& path = parts_->contours.emplace_back();
        for (const Point& point : contour) {
            path.emplace_back(point.x, point.y);
        }
    }
}

ClipperLayer::~ClipperLayer() = default;

bool ClipperLayer::unite(FillRule rule) {
    ClipperLib::Clipper clipper;
    clipper.AddPaths(parts_->contours, ClipperLib::ptSubject, true);
    return clipper.Execute(ClipperLib::ctUnion, parts_->region, fill_type(rule), fill_type(rule));
}

bool ClipperLayer::close(double radius, double miter_limit) {
    if (!unite(FillRule::non_zero)) {
        return false;
    }
    parts_->region = grown(grown(parts_->region, radius, miter_limit), -radius, miter_limit);
    return true;
}

double ClipperLayer::area() const {
    double sum = 0;
    for (const ClipperLib::Path& path : parts_->region) {
        sum += ClipperLib::Area(path);
    }
    return sum;
}

}  // namespace lamella::baselines
