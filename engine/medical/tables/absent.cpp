#include "medical/absent.hpp"
#include "lamella/medical/table.hpp"

namespace lamella {

Result<MeshFacts> measure_facts(const MeshView&, const Transform&, const SliceResult&, const Control&) noexcept {
    return absent("write", "facts", "tables");
}

Status write_layer_table(std::span<const TablePart>, const std::filesystem::path& path, const Control&) noexcept {
    return absent("write", path, "tables");
}

}  // namespace lamella
