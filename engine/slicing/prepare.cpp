#include "lamella/prepare.hpp"

#include <utility>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/buckets/prepared_source.hpp"
#include "slicing/frame.hpp"

namespace lamella {

PreparedMesh::PreparedMesh(std::unique_ptr<const detail::PreparedParts> parts) noexcept : parts_(std::move(parts)) {}
PreparedMesh::~PreparedMesh() = default;
PreparedMesh::PreparedMesh(PreparedMesh&&) noexcept = default;
PreparedMesh& PreparedMesh::operator=(PreparedMesh&&) noexcept = default;

std::size_t PreparedMesh::bytes() const noexcept {
    return parts_->bytes();
}

double PreparedMesh::unit_mm() const noexcept {
    return parts_->frame.unit.mm;
}

Result<PreparedMesh> prepare(const MeshView& mesh, const PrepareOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<PreparedMesh> {
        const Parallel parallel(options.control);
        parallel.begin_stage(1, 5);
        auto parts = std::make_unique<detail::PreparedParts>(options.control.memory);
        parts->frame = choose_frame(mesh, options, {}, parallel);
        parts->bounds = parts->frame.bounds;
        parts->transform = options.transform;
        parts->asked_unit_mm = options.unit_mm;
        parts->build(mesh, parallel);
        if (parts->triangles.empty()) {
            if (!options.allow_empty) {
                return all_collapsed(mesh.triangle_count, parts->frame.unit.mm);
            }
            parts->frame.bounds = {};
        }
        parallel.finish();
        return PreparedMesh(std::move(parts));
    });
}

}  // namespace lamella
