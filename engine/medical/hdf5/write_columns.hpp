// An archive as a file: the tree, and the rows of columns between its pieces.
#pragma once

#include <filesystem>

#include "base/parallel.hpp"
#include "medical/hdf5/tree.hpp"

namespace lamella {

/// The rows are asked for twice: for their checksums, by all threads, and to be written. `begun`: the progress so far.
/// Throws Refused, Stopped, std::bad_alloc.
Status write_columns(const ColumnSource& source, const ArchiveHead& head, const std::filesystem::path& path,
                     const Parallel& parallel, double begun = 0);

}  // namespace lamella
