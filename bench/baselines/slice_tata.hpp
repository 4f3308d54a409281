// Slicing by groups of facets (paper 2.1): Tata et al. 1998, "Efficient slicing for layered manufacturing".
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O(n log n + k s + m) for s sub-groups; O(n k) where all heights differ.
extern const SlicingMethod tata_slicing;

}  // namespace lamella::baselines
