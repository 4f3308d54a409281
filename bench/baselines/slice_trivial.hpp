// Trivial slicing (paper 2.1 and 5.1): Chalasani and Grogan 1991. The paper times it as the slicing of Park 2003.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O(k n).
extern const SlicingMethod trivial_slicing;

}  // namespace lamella::baselines
