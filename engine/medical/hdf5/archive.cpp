#include "lamella/medical/archive.hpp"

#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "medical/hdf5/load.hpp"
#include "medical/hdf5/write_columns.hpp"

namespace lamella {

namespace {

constexpr std::size_t longest_name = 4096;

void require_possible(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path) {
    const auto refuse = [&](const std::string& why) {
        throw Refused{{ErrorCode::invalid_argument, "'" + path.string() + "': " + why}};
    };
    if (result.first_layer > result.all_layers || result.layers.size() > result.all_layers - result.first_layer) {
        refuse("a result of " + counted(result.layers.size(), "layer") + " from layer " +
               std::to_string(result.first_layer) + " on, of " + std::to_string(result.all_layers) + " in all");
    }
    if (info.name.size() > longest_name || info.mesh_sha256.size() > longest_name) {
        refuse("an archive's name of the mesh has at most " + std::to_string(longest_name) + " bytes");
    }
    if (result.layer_of.size() != rows_of(result, ColumnKind::height)) {
        refuse("the result does not tell the layers of its planes");
    }
    if (info.geometry && info.geometry->uneven_slices_mm.size() > most_uneven_slices) {
        refuse("an image of more than " + std::to_string(most_uneven_slices) + " uneven slices");
    }
}

}  // namespace

bool has_archives() noexcept {
    return true;
}

Status write_archive(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path,
                     const Control& control) noexcept {
    return guarded(control, [&]() -> Status {
        Parallel parallel(control);
        require_possible(result, info, path);
        return write_columns(ResultColumns(result), {facts_of(result, info), hash_result(result), result.first_layer}, path,
                             parallel);
    });
}

Result<Archive> read_archive(const std::filesystem::path& path, const Control& control) noexcept {
    return guarded(control, [&]() -> Result<Archive> {
        Parallel parallel(control);
        parallel.begin_stage(0.9, 2);
        LoadedArchive loaded = load_archive(path, parallel, control.memory);
        parallel.finish();
        return Archive{std::move(loaded.tree.result), std::move(loaded.tree.info)};
    });
}

}  // namespace lamella
