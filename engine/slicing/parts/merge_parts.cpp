#include "slicing/parts/merge_parts.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <tuple>

#include "base/vector.hpp"

namespace lamella {

namespace {

/// A layer's points in a part, or their origins: those of its contours follow one another.
template <class T>
std::span<const T> of_layer(const Array<T>& elements, const SliceResult& part, std::size_t layer) {
    const std::span<const Contour> contours = part.contours_of(part.layers[layer]);
    if (contours.empty()) {
        return {};
    }
    const std::uint64_t first = contours.front().first_point;
    return elements.span().subspan(first, contours.back().first_point + contours.back().point_count - first);
}

/// Sizes the arrays and says where each layer begins; returns where its points do.
Vector<std::uint64_t> lay_out(std::span<const SliceResult> parts, const Parallel& parallel, SliceResult& merged) {
    const std::size_t layers = parts[0].layers.size();
    Vector<std::uint64_t> first_points(layers, merged.points.memory());
    merged.layers.resize_discarding(layers);
    std::uint64_t contours = 0;
    std::uint64_t points = 0;
    for (std::size_t l = 0; l < layers; ++l) {
        Layer& layer = merged.layers[l] = parts[0].layers[l];
        first_points[l] = points;
        layer.first_contour = contours;
        layer.segments = 0;
        for (const SliceResult& part : parts) {
            assert(part.layers[l].plane == layer.plane);
            layer.segments += part.layers[l].segments;
            contours += part.layers[l].contour_count;
            points += of_layer(part.points, part, l).size();
        }
        layer.contour_count = contours - layer.first_contour;
        if (l % 1024 == 0) {
            parallel.stop_if_asked();
        }
    }
    merged.contours.resize_discarding(contours);
    merged.points.resize_discarding(points);
    merged.origins.resize_discarding(parts[0].origins.empty() ? 0 : points);
    return first_points;
}

void copy_origins(std::span<const PointOrigin> origins, std::uint16_t part, PointOrigin* to) {
    std::transform(origins.begin(), origins.end(), to, [part](PointOrigin origin) {
        origin.part = origin.triangle == no_triangle ? std::uint16_t{0} : part;
        return origin;
    });
}

void copy_layer(std::span<const SliceResult> parts, std::size_t l, std::uint64_t first_point, SliceResult& merged) {
    std::uint64_t first_contour = merged.layers[l].first_contour;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const Layer& layer = parts[p].layers[l];
        const std::span<const Point> points = of_layer(parts[p].points, parts[p], l);
        std::copy(points.begin(), points.end(), merged.points.data() + first_point);
        if (!merged.origins.empty()) {
            copy_origins(of_layer(parts[p].origins, parts[p], l), static_cast<std::uint16_t>(p),
                         merged.origins.data() + first_point);
        }
        for (std::uint64_t c = 0; c < layer.contour_count; ++c) {
            const Contour& own = parts[p].contours[layer.first_contour + c];
            Contour& contour = merged.contours[first_contour + c] = own;
            contour.part = static_cast<std::uint32_t>(p);
            contour.first_point = first_point + (own.first_point - parts[p].contours[layer.first_contour].first_point);
            contour.parent = own.parent < 0 ? -1
                                            : static_cast<std::int64_t>(first_contour) + own.parent -
                                                  static_cast<std::int64_t>(layer.first_contour);
        }
        first_contour += layer.contour_count;
        first_point += points.size();
    }
}

void merge_gaps(std::span<const SliceResult> parts, SliceResult& merged) {
    std::size_t count = 0;
    for (const SliceResult& part : parts) {
        count += part.closed_gaps.size();
    }
    merged.closed_gaps.resize_discarding(count);
    ClosedGap* out = merged.closed_gaps.data();
    for (const SliceResult& part : parts) {
        out = std::copy(part.closed_gaps.begin(), part.closed_gaps.end(), out);
    }
    std::sort(merged.closed_gaps.begin(), merged.closed_gaps.end(), [](const ClosedGap& a, const ClosedGap& b) {
        return std::tie(a.layer, a.from, a.to) < std::tie(b.layer, b.from, b.to);
    });
}

void add(const SliceSummary& own, SliceSummary& sum) {
    sum.triangles += own.triangles;
    sum.degenerate += own.degenerate;
    sum.crossed += own.crossed;
    sum.segments += own.segments;
    sum.holes += own.holes;
    sum.open_contours += own.open_contours;
    sum.flat_contours += own.flat_contours;
    sum.overruled_contours += own.overruled_contours;
    sum.near_contours += own.near_contours;
    sum.cancelled_layers += own.cancelled_layers;
    sum.bands += own.bands;
    sum.ms.bucket += own.ms.bucket;
    sum.ms.sweep += own.ms.sweep;
    sum.ms.contours += own.ms.contours;
    sum.ms.nesting += own.ms.nesting;
    sum.ms.fill += own.ms.fill;
}

}  // namespace

void merge_parts(std::span<const SliceResult> parts, const Parallel& parallel, SliceResult& merged) {
    assert(!parts.empty());
    const Vector<std::uint64_t> first_points = lay_out(parts, parallel, merged);
    parallel.run_ranges(merged.layers.size(), 1, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t l = begin; l < end; ++l) {
            copy_layer(parts, l, first_points[l], merged);
        }
    });
    merge_gaps(parts, merged);
    merged.layer_of.resize_discarding(parts[0].layer_of.size());
    std::copy(parts[0].layer_of.begin(), parts[0].layer_of.end(), merged.layer_of.begin());
    merged.first_layer = parts[0].first_layer;
    merged.all_layers = parts[0].all_layers;
    merged.part_count = static_cast<std::uint32_t>(parts.size());
    merged.close_gaps_mm = parts[0].close_gaps_mm;
    merged.gap_sense = parts[0].gap_sense;
    merged.unit_mm = parts[0].unit_mm;
    merged.summary = parts[0].summary;
    for (const SliceResult& part : parts.subspan(1)) {
        merged.close_gaps_mm = std::max(merged.close_gaps_mm, part.close_gaps_mm);
        add(part.summary, merged.summary);
    }
    merged.summary.emptied_layers =
        static_cast<std::uint64_t>(std::count_if(merged.layers.begin(), merged.layers.end(), [](const Layer& layer) {
            return layer.segments > 0 && layer.contour_count == 0;
        }));
}

}  // namespace lamella
