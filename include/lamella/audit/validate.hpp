// Whether a result keeps every promise that result.hpp makes.
#pragma once

#include "lamella/error.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Checks every promise above: offsets contiguous, contours closed and canonical, oriented as their role says, areas exact,
/// parents around their children and nested where contours do not cross, layers ordered, no segment lost. The first
/// broken promise is named with layer and contour. O(m log m).
Status validate(const SliceResult& result) noexcept;

}  // namespace lamella
