// Slicing by uniform planes (paper 2.1): Huang et al. 2012.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O(n + k + m). Uniform planes only.
extern const SlicingMethod huang_slicing;

}  // namespace lamella::baselines
