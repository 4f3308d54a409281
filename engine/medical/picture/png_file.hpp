// A canvas becomes a PNG file: all that libpng is used for.
#pragma once

#include <filesystem>

#include "lamella/error.hpp"
#include "medical/picture/canvas.hpp"

namespace lamella {

/// Refuses by name where this build lacks libpng. Throws Refused.
void require_png(const std::filesystem::path& path);

/// Equal pixels give equal bytes: no time, one filter, fixed settings of zlib. Errors: unwritable_file. Throws
/// std::bad_alloc, Refused.
Status write_png(const Canvas& canvas, const std::filesystem::path& path);

}  // namespace lamella
