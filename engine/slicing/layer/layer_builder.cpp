#include "slicing/layer/layer_builder.hpp"

#include <algorithm>

#include "base/numbers.hpp"
#include "base/system/processor.hpp"

namespace lamella {

void LayerBuilder::build(BandOutput& out) {
    contours_.with_origins = out.with_origins;
    if (rules->stitch > 0) {
        close_gaps(out);
    }
    contours_.sort_by_start();
    const std::uint64_t layer = rules->first_layer + out.first_layer + out.layer_contours.size();
    const bool cancels = nest(rules->region == nullptr ? FillRule::contours : rules->region->rule_of(layer));
    out.totals.cancelled_layers += cancels ? 1 : 0;
    append(out);
    out.layer_contours.push_back(static_cast<std::uint32_t>(contours_.items.size()));
}

std::uint32_t LayerBuilder::append_region(const Fill& region, std::uint32_t part, BandOutput& out) {
    contours_.with_origins = out.with_origins;
    (region_ ? *region_ : region_.emplace(contours_)).take(region, *rules->region, rules->grid_mm);
    for (NestItem& item : contours_.items) {
        item.part = part;
    }
    append(out);
    return static_cast<std::uint32_t>(contours_.items.size());
}

/// Replaces the open contours by what they are joined to.
void LayerBuilder::close_gaps(BandOutput& out) {
    Vector<Path>& paths = contours_.paths;
    const auto first_open = std::partition(paths.begin(), paths.end(), [](const Path& path) { return path.item.closed; });
    if (first_open == paths.end()) {
        return;
    }
    const auto closed = std::span(paths).first(static_cast<std::size_t>(first_open - paths.begin()));
    PolylineRepair& repair = repair_ ? *repair_ : repair_.emplace(worker_);
    if (repair.join(std::span(paths).subspan(closed.size()), closed,
                    {rules->stitch, rules->crossing_stitch, rules->direction}, out.layer_contours.size(), out.stitches)) {
        paths.erase(first_open, paths.end());
        paths.insert(paths.end(), repair.joined().begin(), repair.joined().end());
    }
}

/// Finds parents and roles. Returns true where a fill rule let contours cancel.
bool LayerBuilder::nest(FillRule rule) {
    const RegionRules* region = rules->region;
    const bool plain =
        rule == FillRule::contours && (region == nullptr || (region->simplify_mm == 0 && region->flag_closing_mm == 0));
    const std::uint64_t before = ticks != nullptr ? lamella::ticks() : 0;
    bool cancels = false;
    if (plain) {
        contours_.nester.nest(contours_.items);
    } else {
        cancels = (region_ ? *region_ : region_.emplace(contours_)).apply(*region, rule, rules->grid_mm);
    }
    if (ticks != nullptr) {
        (plain ? ticks->nesting : ticks->fill) += lamella::ticks() - before;
    }
    return cancels;
}

/// From element `first` on.
template <class T>
void LayerBuilder::copy_rotated(const T* from, std::size_t first, std::size_t count, T* to) {
    worker_.in_stretches(first, count, 1, [&](std::size_t begin, std::size_t end) {
        std::copy(from + begin, from + end, to + (begin - first));
    });
    to += count - first;
    worker_.in_stretches(0, first, 1,
                         [&](std::size_t begin, std::size_t end) { std::copy(from + begin, from + end, to + begin); });
}

void LayerBuilder::append(BandOutput& out) {
    CanonicalOrder& order = contours_.order;
    order.put_holes_after_outers(contours_.items);
    const std::size_t base = out.contours.size();
    for (const std::uint32_t i : order.items()) {
        const NestItem& item = contours_.items[i];
        worker_.spend(LayerContours::contour_work);
        const std::size_t first = item.reverse ? item.start + 1 : item.start;  // the start comes last to be turned round
        Point* const points = out.reserve_points(item.count);
        prefetch_ahead<true>(reinterpret_cast<const std::byte*>(points), item.count * sizeof(Point));
        copy_rotated(item.points, first, item.count, points);
        PointOrigin* const origins = out.with_origins ? out.origins + out.point_count : nullptr;
        if (origins != nullptr) {
            copy_rotated(item.origins, first, item.count, origins);
        }
        if (item.reverse) {
            turn_round({points, item.count}, origins, item.closed);
        }
        Contour& contour = out.contours.emplace_back();
        contour.first_point = out.point_count;
        contour.twice_area = item.reverse ? to_integer128(-to_int128(item.twice_area)) : item.twice_area;
        contour.parent =
            item.parent < 0 ? -1 : static_cast<std::int64_t>(base + order.place_of(static_cast<std::size_t>(item.parent)));
        contour.point_count = item.count;
        contour.segments = contours_.path_of(i).segments;
        contour.role = item.role;
        contour.orientation = item.orientation;
        contour.flags = item.flags;
        contour.part = item.part;
        out.totals.add(contour);
        out.point_count += item.count;
    }
}

}  // namespace lamella
