// From meshes and options to items, with all that can be refused before any work.
#pragma once

#include <string>
#include <vector>

#include "batch/plan/item.hpp"
#include "batch/sources/mesh_sources.hpp"
#include "batch/sources/slice_words.hpp"

namespace lamella::cli::batch {

/// Throws Failure: options that slice would refuse, an unknown word in a name, two items with one output, an output that is
/// a mesh of the batch, a file that options name, or one of `own_files`: results and manifests.
std::vector<Item> plan_items(const std::vector<MeshSource>& sources, const OptionValues& common, const SliceWords& words,
                             const std::vector<std::string>& own_files);

/// Those of shard `index` of `count`: every count-th.
std::vector<Item> items_of_shard(std::vector<Item> items, std::uint32_t index, std::uint32_t count);

}  // namespace lamella::cli::batch
