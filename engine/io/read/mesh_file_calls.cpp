// The calls on a mesh, for a mesh that was read: its unit is applied first.
#include "base/guard.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

namespace {

template <class Options>
Options in_mm(const MeshFile& file, Options options) {
    options.transform = options.transform * file.to_mm();
    return options;
}

}  // namespace

Result<SliceResult> slice(const MeshFile& file, const SliceOptions& options) noexcept {
    return guarded([&] { return slice(file.view(), in_mm(file, options)); });
}

Status slice(const MeshFile& file, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return guarded([&] { return slice(file.view(), in_mm(file, options), workspace, result); });
}

Result<MeshInfo> inspect(const MeshFile& file, const InspectOptions& options) noexcept {
    return inspect(file.view(), in_mm(file, options));
}

Result<MeshCheck> check(const MeshFile& file, const CheckOptions& options) noexcept {
    return check(file.view(), in_mm(file, options));
}

Result<WeldedMesh> weld(const MeshFile& file, const WeldOptions& options) noexcept {
    WeldOptions in_unit = options;
    in_unit.mm_per_unit = file.mm_per_unit;
    return weld(file.view(), in_unit);
}

}  // namespace lamella
