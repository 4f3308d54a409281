// OFF number by number, wherever its lines end.
#pragma once

#include <optional>

#include "io/read/obj_off/off_numbers.hpp"
#include "io/read/reader.hpp"

namespace lamella {

/// A file that is no lines of one vertex or face each, which as lines is refused at byte `refused_offset` of `whole`; on one
/// thread. Nothing where it is not understood: then `failure` is set if all is right to the end of the file, which comes too
/// early in a later vertex or face.
std::optional<Result<MeshFile>> read_off_tokens(const FileSource& source, std::string_view whole, std::string_view text,
                                                std::size_t refused_offset, TextFailure& failure);

}  // namespace lamella
