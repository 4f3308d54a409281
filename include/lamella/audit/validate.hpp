// Whether a result keeps the promises of result.hpp that can be seen from the result alone: for tests, and for results that
// were read or changed.
//
//     const lamella::Status valid = lamella::validate(result);
//     if (!valid) {
//         std::fprintf(stderr, "layer %d: %s\n", static_cast<int>(valid.error().plane), valid.error().message.c_str());
//     }
#pragma once

#include "lamella/error.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Checks that offsets are contiguous, contours closed and in their order, oriented as their role says, areas exact, parents
/// around their children and nested where contours do not cross, layers ordered, and no segment lost. The error
/// (invalid_argument, with the layer as Error::plane) names the first broken promise with its layer and contour. O(m log m)
/// for m points, on the calling thread. Errors: also out_of_memory.
Status validate(const SliceResult& result) noexcept;

}  // namespace lamella
