// What is known of a result before its first layer is cut.
#pragma once

#include <cstdint>

#include "lamella/slice_file.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

FileOutline outline_of(const SliceOptions& slicing, const SharedFrame& frame, const PlaneSet& planes);

/// SliceResult::layer_of.
Array<std::uint64_t> layers_of_listed(const PlaneSet& planes, const Memory* memory);

}  // namespace lamella
