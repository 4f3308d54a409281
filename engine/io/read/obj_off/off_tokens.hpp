// OFF number by number, wherever its lines end.
#pragma once

#include <optional>

#include "io/read/obj_off/off_numbers.hpp"
#include "io/read/reader.hpp"

namespace lamella {

/// A file that is no lines of one vertex or face each; on one thread. Nothing where it is not understood: then `failure` is
/// set if the file ends too early and is all right up to there.
std::optional<Result<MeshFile>> read_off_tokens(const FileSource& source, std::string_view whole, std::string_view text,
                                                TextFailure& failure);

}  // namespace lamella
