// Stands in where HDF5 is missing.
#include "medical/absent.hpp"
#include "lamella/medical/archive.hpp"

namespace lamella {

Status write_archive(const SliceResult&, const ArchiveInfo&, const std::filesystem::path& path, const Control&) noexcept {
    return absent("write", path, "HDF5 (libhdf5-dev)");
}

Result<Archive> read_archive(const std::filesystem::path& path, const Control&) noexcept {
    return absent("read", path, "HDF5 (libhdf5-dev)");
}

Status merge_archives(std::span<const std::filesystem::path>, const std::filesystem::path& path, const Control&) noexcept {
    return absent("write", path, "HDF5 (libhdf5-dev)");
}

}  // namespace lamella
