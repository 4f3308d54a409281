// A list of meshes with options for each: CSV with a line of names, or JSON Lines.
//
//     path,layer-height,like            {"path": "liver.stl", "layer-height": 0.5, "like": "ct.nii.gz"}
//     liver.stl,0.5,ct.nii.gz           {"path": "skull.stl", "spacing": [1, 1, 2], "coverage": true}
//     skull.stl,,
//
// The names may be separated by semicolons or tabs; then so is the rest, and one number may have a decimal comma: 0,5.
//
// An empty cell or null leaves the option as the command line has it. Paths are relative to the current folder, as on the
// command line.
#pragma once

#include <string>
#include <vector>

#include "batch/slice_words.hpp"

namespace lamella::cli::batch {

struct ManifestRow {
    std::string path;
    OptionValues values;
    std::string place;  ///< FILE:LINE
};

/// Whether a file's name ends in .csv or .jsonl.
bool is_named_as_manifest(const std::string& path);

/// Throws Failure naming the file and the line: of what cannot be read, and of names that are no option of slice.
std::vector<ManifestRow> read_manifest(const std::string& path, const SliceWords& words);

}  // namespace lamella::cli::batch
