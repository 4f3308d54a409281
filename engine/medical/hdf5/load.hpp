// An archive's file, and its rows as a result.
#pragma once

#include <filesystem>

#include "base/parallel.hpp"
#include "medical/hdf5/tree.hpp"

namespace lamella {

/// A file whose rows lie in `tree.result`.
struct LoadedArchive {
    InputFile file;
    ReadTree tree;
};

/// Reads and checks all of it. Throws Refused, Stopped, std::bad_alloc.
LoadedArchive load_archive(const std::filesystem::path& path, const Parallel& parallel, const Memory* memory);

/// What no single row shows: offsets, areas, parents, open layers. Sets what follows from the columns. Throws as above.
void check_loaded(const InputFile& file, SliceResult& result, const Parallel& parallel);

}  // namespace lamella
