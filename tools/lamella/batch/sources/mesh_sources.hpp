// What SOURCE... stands for: files, folders, globs and manifests become one list of meshes.
#pragma once

#include <string>
#include <vector>

#include "batch/sources/slice_words.hpp"

namespace lamella::cli::batch {

struct MeshSource {
    std::string path;
    std::string folder;   ///< of the mesh below the SOURCE that is a folder; empty where that is the folder itself
    OptionValues values;  ///< of a manifest
    std::string place;    ///< FILE:LINE of a manifest, else empty
};

/// In the order of the sources; a folder's in the order of names, folders in it included. Throws Failure: of a folder that
/// cannot be listed, of a folder or glob without meshes, of a manifest. A mesh need not exist: that is for its item to say.
std::vector<MeshSource> list_sources(const std::vector<std::string>& given, const SliceWords& words);

}  // namespace lamella::cli::batch
