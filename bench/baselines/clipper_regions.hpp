// Regions of one layer's contours by ClipperLib 6.4, which the slicers of the Slic3r family use: what region_of() is
// compared with. Only bench/ links the library.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "lamella/grid.hpp"
#include "lamella/region.hpp"

namespace lamella::baselines {

/// The contours of a layer in the library's own form, so that only its work is timed.
class ClipperLayer {
public:
    explicit ClipperLayer(std::span<const std::span<const Point>> contours);
    ~ClipperLayer();
    ClipperLayer(const ClipperLayer&) = delete;
    ClipperLayer& operator=(const ClipperLayer&) = delete;

    /// Union by even-odd, non-zero or positive. False where the library fails.
    bool unite(FillRule rule);
    /// As slicers close: united by non-zero, grown by so many grid units with miter joins, then shrunk by as many.
    bool close(double radius, double miter_limit);
    /// Of the last region, square grid units.
    double area() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace lamella::baselines
