// In place of the other sources of this folder where there is no HDF5.
#include "lamella/medical/archive.hpp"

#include "base/guard.hpp"

namespace lamella {

namespace {

Error refused(const std::filesystem::path& path) {
    return {ErrorCode::invalid_argument, "'" + path.string() + "': this build has no HDF5"};
}

}  // namespace

bool has_archives() noexcept {
    return false;
}

Status write_archive(const SliceResult&, const ArchiveInfo&, const std::filesystem::path& path, const Control&) noexcept {
    return guarded([&]() -> Status { return refused(path); });
}

Result<Archive> read_archive(const std::filesystem::path& path, const Control&) noexcept {
    return guarded([&]() -> Result<Archive> { return refused(path); });
}

Result<MergedArchive> merge_archives(std::span<const std::filesystem::path>, const std::filesystem::path& path,
                                     const Control&) noexcept {
    return guarded([&]() -> Result<MergedArchive> { return refused(path); });
}

}  // namespace lamella
