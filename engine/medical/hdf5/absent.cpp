// In place of the other sources of this folder where there is no HDF5.
#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "lamella/medical/archive.hpp"

namespace lamella {

namespace {

template <class Answer>
Answer refused(const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Answer {
        return Error{ErrorCode::invalid_argument, "'" + path_text(path) + "': this build has no HDF5"};
    });
}

}  // namespace

bool has_archives() noexcept {
    return false;
}

Status write_archive(const SliceResult&, const ArchiveInfo&, const std::filesystem::path& path, const Context&) noexcept {
    return refused<Status>(path);
}

Result<Archive> read_archive(const std::filesystem::path& path, const Context&) noexcept {
    return refused<Result<Archive>>(path);
}

Result<MergedArchive> merge_archives(std::span<const std::filesystem::path>, const std::filesystem::path& path,
                                     const Context&) noexcept {
    return refused<Result<MergedArchive>>(path);
}

}  // namespace lamella
