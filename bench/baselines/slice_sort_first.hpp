// The paper's second way to build its triangle lists (3.4): sort by z_min, then merge.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O(n log n + k + m).
extern const SlicingMethod sort_first_slicing;

}  // namespace lamella::baselines
