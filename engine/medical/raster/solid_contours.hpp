// Contours as coverage can add them up: where one winds around another, or repeats it, they are united first. And how long
// they are.
#pragma once

#include <span>
#include <vector>

#include "lamella/assemble.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Unites one layer after another. Keep one a thread.
class SolidContours {
public:
    /// Closed contours of winding numbers 0 and 1 only, solid on the left: those of the layer where a fill rule has made a
    /// region of all of them, else their union by FillRule::non_zero. They stay until the next call. Throws Refused where
    /// memory fails.
    std::span<const std::span<const Point>> of(const SliceResult& result, const Layer& layer);

private:
    const Layer* layer_ = nullptr;
    std::vector<std::span<const Point>> contours_;
    LayerContours united_;
};

/// How long a closed contour is, grid units.
double perimeter_of(std::span<const Point> points) noexcept;

}  // namespace lamella
