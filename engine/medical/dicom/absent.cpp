// Stands in where DCMTK is missing.
#include "medical/absent.hpp"
#include "lamella/medical/structure_set.hpp"

namespace lamella {

Result<StructureSetSummary> write_structure_set(std::span<const Roi>, const ImageGeometry&,
                                                const std::filesystem::path& path, const StructureSetOptions&) noexcept {
    return absent("write", path, "DICOM (libdcmtk-dev)");
}

}  // namespace lamella
