// All baselines, for look-up by name.
#pragma once

#include <span>

#include "method.hpp"

namespace lamella::baselines {

std::span<const SlicingMethod* const> slicing_methods() noexcept;
std::span<const ContourMethod* const> contour_methods() noexcept;
std::span<const WholeMethod* const> whole_methods() noexcept;

}  // namespace lamella::baselines
