// What a slice reads its triangles from, chosen once for a call:
//
//     prepared mesh    buckets/prepared_triangles   triangles on the grid already
//     shared vertices  buckets/indexed_triangles    each vertex is placed once
//     lists            buckets/listed_triangles     records in their lists already
//     other meshes     buckets/bucket               corner by corner, blocks between planes skipped
#pragma once

#include <cstddef>

#include "base/parallel.hpp"
#include "lamella/error.hpp"
#include "lamella/slice.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/workspace.hpp"

namespace lamella {

/// Fills in the buckets of `kept`; the functions in their order, with planes built after measure() and bands cut after
/// count().
class TriangleSource {
public:
    TriangleSource(const detail::SliceInput& input, const SliceOptions& options, const Parallel& parallel,
                   detail::WorkspaceParts& kept) noexcept;

    /// The box, that of a mesh without triangles being a point where options allow it.
    Result<Bounds> measure(double asked_mm);
    /// The lists' sizes, and degenerate triangles.
    void count(double unit_mm);
    /// The lists, and where origins are asked for the lowest corners. Returns how many triangles reach beyond their band.
    std::size_t scatter(double unit_mm);
    /// All bands are swept: what was lent goes back.
    void give_back() noexcept;

private:
    std::size_t scatter_records(double unit_mm);

    const MeshView& mesh_;
    const detail::PreparedParts* prepared_;
    const ListedTriangles* listed_;
    const SharedFrame* frame_;
    const SliceOptions& options_;
    const Parallel& parallel_;
    detail::WorkspaceParts& kept_;
    bool places_vertices_;
};

}  // namespace lamella
