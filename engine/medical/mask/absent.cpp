// Stands in where nifticlib is missing.
#include "medical/absent.hpp"
#include "lamella/medical/mask.hpp"

namespace lamella {

Result<MaskSummary> write_mask(std::span<const MaskPart>, const ImageGeometry&, const std::filesystem::path& path,
                               const MaskOptions&) noexcept {
    return absent("write", path, "masks (libnifti-dev)");
}

}  // namespace lamella
