#include "slicing/triangle_source.hpp"

#include <span>

#include "slicing/buckets/bucket.hpp"
#include "slicing/buckets/indexed_triangles.hpp"
#include "slicing/buckets/lowest_corners.hpp"
#include "slicing/prepared_parts.hpp"

namespace lamella {

TriangleSource::TriangleSource(const detail::SliceInput& input, const SliceOptions& options, const Parallel& parallel,
                               detail::WorkspaceParts& kept) noexcept
    : mesh_(input.mesh),
      prepared_(input.prepared),
      listed_(input.listed),
      frame_(input.frame),
      options_(options),
      parallel_(parallel),
      kept_(kept),
      places_vertices_(input.prepared == nullptr && VertexTable::pays_for(input.mesh)) {}

Result<Bounds> TriangleSource::measure(double asked_mm) {
    if (listed_ != nullptr) {
        kept_.blocks.blocks.set_size(0);
        return frame_->bounds;
    }
    if (prepared_ != nullptr || (options_.allow_empty && mesh_.triangle_count == 0)) {
        kept_.blocks.blocks.set_size(0);
        return prepared_ != nullptr ? prepared_->bounds : Bounds{};
    }
    return places_vertices_ ? measure_bounds(mesh_, options_.transform, asked_mm, parallel_, kept_.vertices, kept_.blocks)
                            : measure_bounds(mesh_, options_.transform, asked_mm, parallel_, kept_.blocks);
}

void TriangleSource::count(double unit_mm) {
    const PlaneSet& planes = kept_.planes;
    if (listed_ != nullptr) {
        count_crossings(*listed_, kept_.buckets);
    } else if (prepared_ != nullptr) {
        count_crossings(prepared_->triangles, planes, parallel_, kept_.buckets);
    } else if (places_vertices_) {
        count_crossings(mesh_, options_.transform, unit_mm, kept_.vertices, planes, parallel_, kept_.buckets);
    } else {
        count_crossings(mesh_, options_.transform, unit_mm, kept_.blocks, planes, parallel_, kept_.buckets);
    }
}

std::size_t TriangleSource::scatter(double unit_mm) {
    const std::size_t reaching = scatter_records(unit_mm);
    if (options_.origins && prepared_ == nullptr) {
        find_lowest_corners(mesh_, options_.transform, unit_mm, parallel_, kept_.buckets);
    }
    return reaching;
}

std::size_t TriangleSource::scatter_records(double unit_mm) {
    const PlaneSet& planes = kept_.planes;
    const auto& band_end = kept_.bands.band_end;
    const std::span<Reaching> reaching = kept_.bands.reaching.span();
    if (listed_ != nullptr) {
        return scatter_triangles(*listed_, band_end, parallel_, kept_.buckets, reaching);
    }
    if (prepared_ != nullptr) {
        return scatter_triangles(prepared_->triangles, planes, band_end, parallel_, kept_.buckets, reaching,
                                 options_.origins);
    }
    if (places_vertices_) {
        return scatter_triangles(mesh_, kept_.vertices, planes, band_end, parallel_, kept_.buckets, reaching);
    }
    return scatter_triangles(mesh_, options_.transform, unit_mm, planes, band_end, parallel_, kept_.buckets, reaching);
}

void TriangleSource::give_back() noexcept {
    if (listed_ != nullptr) {
        lamella::give_back(*listed_, kept_.buckets);
    }
}

}  // namespace lamella
