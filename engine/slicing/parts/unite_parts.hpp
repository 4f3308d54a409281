// One region of the contours that several parts have in a layer.
#pragma once

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Makes regions by `united.region` of the contours of `apart`, as merge_parts() leaves them, by the orientation of their
/// facets. Fills in all of `united` but frame and plan. Precondition: no layer's rule is `contours`. O(q log q) for a layer
/// of q points, as slice(). `reach` is told the share of layers that are done. Throws std::bad_alloc.
void unite_parts(const SliceResult& apart, const Control& control, const Parallel& parallel, FunctionRef<void(double)> reach,
                 SliceResult& united);

}  // namespace lamella
