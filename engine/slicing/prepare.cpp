#include "lamella/prepare.hpp"

#include <utility>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/prepared_parts.hpp"

namespace lamella {

namespace {

Result<PreparedMesh> make_prepared(const MeshView& mesh, const PrepareOptions& options) {
    const Parallel parallel(options.control);
    parallel.begin_stage(1, 5);
    auto parts = std::make_unique<detail::PreparedParts>(options.control.memory);
    BlockTable blocks(options.control.memory);
    const Result<Bounds> bounds = options.allow_empty && mesh.triangle_count == 0
                                      ? Bounds{}
                                      : measure_bounds(mesh, options.transform, options.unit_mm, parallel, blocks);
    if (!bounds) {
        return bounds.error();
    }
    const Result<ChosenUnit> unit = choose_unit(*bounds, options.unit_mm, options.unit_fit == UnitFit::coarser_if_needed);
    if (!unit) {
        return unit.error();
    }
    blocks = BlockTable(options.control.memory);
    parts->bounds = *bounds;
    parts->frame = {*bounds, *unit, placed_number(mesh, options.transform)};
    parts->transform = options.transform;
    parts->asked_unit_mm = options.unit_mm;
    parts->counted.triangle_count = mesh.triangle_count;
    parts->triangles.build(mesh, options.transform, *bounds, unit->mm, parallel);
    if (parts->triangles.degenerate == mesh.triangle_count) {
        if (!options.allow_empty) {
            return all_collapsed(mesh.triangle_count, unit->mm);
        }
        parts->frame.bounds = {};
    }
    parallel.finish();
    return PreparedMesh(std::move(parts));
}

}  // namespace

PreparedMesh::PreparedMesh(std::unique_ptr<const detail::PreparedParts> parts) noexcept : parts_(std::move(parts)) {}
PreparedMesh::~PreparedMesh() = default;
PreparedMesh::PreparedMesh(PreparedMesh&&) noexcept = default;
PreparedMesh& PreparedMesh::operator=(PreparedMesh&&) noexcept = default;

std::size_t PreparedMesh::bytes() const noexcept {
    return sizeof(detail::PreparedParts) + parts_->triangles.bytes();
}

double PreparedMesh::unit_mm() const noexcept {
    return parts_->frame.unit.mm;
}

Result<PreparedMesh> prepare(const MeshView& mesh, const PrepareOptions& options) noexcept {
    return guarded(options.control, [&] { return make_prepared(mesh, options); });
}

Status slice(const PreparedMesh& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return guarded(options.control,
                   [&] { return detail::PartSlicer::slice(mesh.parts().input(), options, workspace, result); });
}

Result<SliceResult> slice(const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<SliceResult> {
        Workspace workspace;
        SliceResult result(options.control.memory);
        if (Status status = detail::PartSlicer::slice(mesh.parts().input(), options, workspace, result); !status) {
            return status.error();
        }
        return result;
    });
}

}  // namespace lamella
