#include "slicing/overlay/set_reader.hpp"

#include <tuple>

#include "base/sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t contour_work = 32;  ///< as StopPace counts it

}  // namespace

bool is_before(const Path& a, const Path& b) noexcept {
    if (a.item.from_start(0) != b.item.from_start(0)) {
        return a.item.from_start(0) < b.item.from_start(0);
    }
    if (const std::strong_ordering points = compare_points(a.item, b.item); points != 0) {
        return points < 0;
    }
    return std::tie(a.segments, a.item.flags) < std::tie(b.segments, b.item.flags);
}

bool SetReader::is_region(const LayerSet& set) noexcept {
    const SliceResult* const stack = set.layers.stack();
    return stack != nullptr && set.from == set.to && set.grow_mm == 0 && !stack->info.options.region.keeps_contours() &&
           stack->info.options.region.fill_from.empty() &&
           (stack->info.part_count == 1 || stack->info.options.unite_parts || set.part);
}

std::span<const Path> SetReader::list_contours(const LayerSet& set, std::uint64_t n) {
    listed_.clear();
    if (set.layers.given() != nullptr) {
        list_host(*set.layers.given(), true);
        given_.list(of_host_, listed_);
    }
    // Flat contours and open ones bound nothing.
    for_each_contour(set, n, [&](const LayerView& layer, const Contour& contour) {
        if (contour.encloses_area()) {
            Path& path = listed_.emplace_back();
            path.item = closed_item(layer.points_of(contour));
            path.item.flags = static_cast<std::uint16_t>(contour.flags & (stitched | orientation_mixed));
            path.segments = contour.segments;
        }
    });
    return listed_;
}

std::span<const Path> SetReader::list_lines(const LayerSet& set, std::uint64_t n) {
    of_host_.clear();
    if (set.layers.given() != nullptr) {
        list_host(*set.layers.given(), false);
    }
    for_each_contour(set, n, [&](const LayerView& layer, const Contour& contour) {
        of_host_.push_back(given_path(layer.points_of(contour), nullptr, contour.role != Role::open));
    });
    return of_host_;
}

void SetReader::list_host(const ContourSet& given, bool closed) {
    of_host_.clear();
    for (const std::span<const Point> contour : given.contours) {
        if (!closed || !contour.empty()) {
            of_host_.push_back(given_path(contour, nullptr, closed));
        }
    }
}

/// The contours of the set's layers that count for layer n.
void SetReader::for_each_contour(const LayerSet& set, std::uint64_t n,
                                 FunctionRef<void(const LayerView&, const Contour&)> take) {
    const auto take_all = [&](const LayerView& layer) {
        for (const Contour& contour : layer.contours) {
            worker_.spend(contour_work + contour.point_count);
            if (!set.part || *set.part == contour.part) {
                take(layer, contour);
            }
        }
    };
    if (set.layers.layer() != nullptr) {
        take_all(*set.layers.layer());
    } else if (const SliceResult* const stack = set.layers.stack()) {
        for (std::int64_t own = set.from; own <= set.to; ++own) {
            const std::int64_t at = static_cast<std::int64_t>(n) + own;
            if (at >= 0 && at < static_cast<std::int64_t>(stack->size())) {
                take_all((*stack)[static_cast<std::size_t>(at)]);
            }
        }
    }
}

std::span<const Path> SetReader::list_region(const LayerSet& set, std::uint64_t n, double grid_mm, Nester& nester) {
    list_contours(set, n);
    if (is_region(set)) {
        for (Path& path : listed_) {
            path.hole = to_int128(path.item.twice_area) < 0;
        }
        return listed_;
    }
    sort_briefly(listed_.begin(), listed_.end(), [this](const Path& a, const Path& b) {
        worker_.spend(1);
        return is_before(a, b);
    });
    regions_.run(listed_, {.rule = set.fill_rule, .offset = set.grow_mm / grid_mm, .always_list = true}, nester);
    return regions_.paths();
}

}  // namespace lamella
