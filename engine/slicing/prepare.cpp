#include <utility>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "lamella/source.hpp"
#include "slicing/buckets/prepared_source.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

PreparedMesh::PreparedMesh(std::unique_ptr<const detail::PreparedImpl> impl) noexcept : impl_(std::move(impl)) {}
PreparedMesh::~PreparedMesh() = default;
PreparedMesh::PreparedMesh(PreparedMesh&&) noexcept = default;
PreparedMesh& PreparedMesh::operator=(PreparedMesh&&) noexcept = default;

std::size_t PreparedMesh::bytes() const noexcept {
    return impl_->bytes();
}

const Frame& PreparedMesh::frame() const noexcept {
    return impl_->asked;
}

Result<PreparedMesh> prepare(const MeshView& mesh, const Frame& frame, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<PreparedMesh> {
        const Parallel parallel(context);
        parallel.begin_stage(1, 5);
        auto made = std::make_unique<detail::PreparedImpl>(context.memory);
        made->frame = choose_frame(mesh, frame, true, {}, parallel);
        made->bounds = made->frame.bounds;
        made->asked = frame;
        made->asked_grid_mm = frame.grid_mm;
        made->asked.grid_mm = made->frame.unit.mm;
        made->build(mesh, parallel);
        if (made->triangles.empty()) {
            made->frame.bounds = {};  // the box of nothing chooses no planes
        }
        parallel.finish();
        return PreparedMesh(std::move(made));
    });
}

}  // namespace lamella
