// Included where code relies on the host's byte order. Files of either byte order are read all the same.
#pragma once

#include <bit>

namespace lamella {

static_assert(std::endian::native == std::endian::little,
              "numbers of little-endian files are used where they lie, and the first character of eight is the lowest byte");

}  // namespace lamella
