// What validate() says about origins.
#pragma once

#include <string>

#include "lamella/result.hpp"

namespace lamella {

/// Of what can be seen without the mesh: the first broken promise in words, or empty. Precondition: contours lie within the
/// points.
std::string complaint_about_origins(const SliceResult& result);

}  // namespace lamella
