// A mesh prepared once and then sliced again and again: at other heights, by other rules, by several threads at once.
//
//     const lamella::Result<lamella::PreparedMesh> prepared = lamella::prepare(mesh);
//     lamella::SliceOptions options;
//     lamella::Workspace workspace;
//     lamella::SliceResult sliced;
//     for (const double height : {1.5, 0.25, 7.0}) {
//         options.plan.spacing = lamella::ExplicitPlanes{.heights_mm = {height}};
//         if (prepared && lamella::slice(*prepared, options, workspace, sliced)) {
//             std::printf("z %g mm: %g mm2\n", height, sliced.area_mm2(sliced.layers[0]));
//         }
//     }
//
// The triangles are kept on the grid, ordered by height: one plane reads little more than the triangles that it cuts, where
// slice() of the mesh reads them all.
#pragma once

#include <cstddef>
#include <memory>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"

namespace lamella {

namespace detail {
struct PreparedParts;
}  // namespace detail

/// What slice() of the same mesh takes from its options before planes are known.
struct PrepareOptions {
    double unit_mm = 0;                    ///< as SliceOptions::unit_mm
    UnitFit unit_fit = UnitFit::as_asked;  ///< as SliceOptions::unit_fit
    /// As SliceOptions::allow_empty, which the slices of the prepared mesh need too.
    bool allow_empty = false;
    Transform transform{};  ///< as SliceOptions::transform
    Control control{};      ///< of prepare() alone, but for `memory`, which the prepared mesh holds until its end
};

/// Immutable: any number of threads may slice it at once, each with a Workspace of its own. The MeshView that it was made of
/// is not needed any more. One that was moved from may only be assigned to or destroyed.
class PreparedMesh {
public:
    explicit PreparedMesh(std::unique_ptr<const detail::PreparedParts> parts) noexcept;
    ~PreparedMesh();
    PreparedMesh(PreparedMesh&&) noexcept;
    PreparedMesh& operator=(PreparedMesh&&) noexcept;

    /// The memory that it holds: 48 bytes a triangle and about a fiftieth of a byte more for each.
    std::size_t bytes() const noexcept;
    /// The grid unit chosen, mm.
    double unit_mm() const noexcept;

    const detail::PreparedParts& parts() const noexcept { return *parts_; }  ///< for the library itself

private:
    std::unique_ptr<const detail::PreparedParts> parts_;
};

/// O(n) for n triangles, of which the mesh is read three times. Takes 48 bytes a triangle from `options.control.memory`, and
/// while it works some more for its lists. Errors, as of slice(): invalid_argument, empty_mesh, bad_coordinate (with the
/// triangle), out_of_memory, cancelled.
Result<PreparedMesh> prepare(const MeshView& mesh, const PrepareOptions& options = {}) noexcept;

/// Gives the bytes that slice() of the mesh gives for the same options. `options.transform` and `options.unit_mm` are those
/// that the mesh was prepared with, or left out; others are invalid_argument.
///
/// As slice() of a mesh, but that the triangles of n that no plane comes near are not read: O(n / 4096 + t + k + m) for t
/// triangles near planes.
Result<SliceResult> slice(const PreparedMesh& mesh, const SliceOptions& options = {}) noexcept;

/// The same into an existing result and with scratch that is kept.
Status slice(const PreparedMesh& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept;

}  // namespace lamella
