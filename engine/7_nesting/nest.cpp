#include "7_nesting/nest.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <compare>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace lamella {

namespace {

using nesting::BoxQuad;
using nesting::Ring;
using nesting::SortKey;

/// Layers of at most so many contours compare all with all.
constexpr std::size_t few_rings = 100;

int sign_of(const Wide& area) noexcept {
    if (area.high < 0) {
        return -1;
    }
    return area.high > 0 || area.low > 0 ? 1 : 0;
}

std::pair<std::uint64_t, std::uint64_t> magnitude(const Wide& area) noexcept {
    const auto high = static_cast<std::uint64_t>(area.high);
    if (area.high >= 0) {
        return {high, area.low};
    }
    return {~high + (area.low == 0 ? 1 : 0), ~area.low + 1};
}

/// Compares the points of two contours from their starts on.
std::strong_ordering compare_points(const NestItem& a, const NestItem& b) noexcept {
    if (a.count != b.count) {
        return a.count <=> b.count;
    }
    for (std::uint32_t i = 0, ia = a.start, ib = b.start; i < a.count; ++i) {
        if (const auto order = a.points[ia] <=> b.points[ib]; std::is_neq(order)) {
            return order;
        }
        ia = ia + 1 == a.count ? 0 : ia + 1;
        ib = ib + 1 == b.count ? 0 : ib + 1;
    }
    return std::strong_ordering::equal;
}

/// From small to large, never by index: equal only if all points are.
std::strong_ordering compare_size(const NestItem& a, const NestItem& b) noexcept {
    if (const auto order = magnitude(a.twice_area) <=> magnitude(b.twice_area); std::is_neq(order)) {
        return order;
    }
    if (const auto order = a.points[a.start] <=> b.points[b.start]; std::is_neq(order)) {
        return order;
    }
    if (const auto order = std::pair(a.box_min, a.box_max) <=> std::pair(b.box_min, b.box_max); std::is_neq(order)) {
        return order;
    }
    return compare_points(a, b);
}

/// Maps signed order to unsigned order.
constexpr std::uint32_t biased(std::int32_t value) noexcept {
    return static_cast<std::uint32_t>(value) ^ 0x8000'0000U;
}

bool before(const SortKey& a, const SortKey& b) noexcept {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
}

/// Sorts keys whose indices ascend by (key, index): digit by digit once there are enough of them, constant digits skipped.
void sort_keys(std::pmr::vector<SortKey>& keys, std::pmr::vector<SortKey>& spare) {
    constexpr std::size_t few = 1024;
    constexpr int digit_bits = 11;
    constexpr std::uint64_t digit_mask = (1U << digit_bits) - 1;
    if (std::is_sorted(keys.begin(), keys.end(), before)) {
        return;
    }
    if (keys.size() < few) {
        std::sort(keys.begin(), keys.end(), before);
        return;
    }
    std::uint64_t varying = 0;
    for (const SortKey& key : keys) {
        varying |= key.key ^ keys[0].key;
    }
    spare.resize(keys.size());
    for (int shift = 0; shift < 64 && varying >> shift != 0; shift += digit_bits) {
        shift += std::countr_zero(varying >> shift);
        std::uint32_t ends[digit_mask + 1] = {};
        for (const SortKey& key : keys) {
            ++ends[key.key >> shift & digit_mask];
        }
        std::exclusive_scan(std::begin(ends), std::end(ends), std::begin(ends), 0U);
        for (const SortKey& key : keys) {
            spare[ends[key.key >> shift & digit_mask]++] = key;
        }
        keys.swap(spare);
    }
}

}  // namespace

Nester::Nester(std::pmr::memory_resource* memory)
    : memory_(memory != nullptr ? memory : std::pmr::new_delete_resource()),
      add_edges_(nesting::best_add_edges()),
      rings_(memory_),
      areas_(memory_),
      keys_(memory_),
      spare_keys_(memory_),
      quads_(memory_),
      places_(memory_),
      strip_ends_(memory_),
      tree_(memory_),
      around_(memory_),
      edge_index_(memory_) {}

void Nester::nest(std::span<NestItem> items) {
    assert(items.size() <= std::size_t{std::numeric_limits<std::int32_t>::max()});
    collect(items);
    sort_by_start(items);
    if (rings_.size() <= few_rings) {
        find_parents_among_few(items);
    } else {
        find_parents_among_many(items);
    }
    assign_roles(items);
}

/// Settles what takes no part in nesting and lists the starts of the rest.
void Nester::collect(std::span<NestItem> items) {
    keys_.clear();
    for (std::size_t i = 0; i < items.size(); ++i) {
        NestItem& item = items[i];
        item.parent = -1;
        item.reverse = false;
        item.sense = static_cast<std::int8_t>(item.closed ? sign_of(item.twice_area) : 0);
        item.role = item.closed ? Role::flat : Role::open;
        if (item.sense != 0) {
            assert(item.start < item.count && item.points[item.start].x == item.box_min.x);
            const Point start = item.points[item.start];
            keys_.push_back({std::uint64_t{biased(start.x)} << 32 | biased(start.y), static_cast<std::uint32_t>(i)});
        }
    }
}

/// Rings in the order of starts; of equal starts the larger first, so that a search backwards meets the smaller first.
void Nester::sort_by_start(std::span<const NestItem> items) {
    sort_keys(keys_, spare_keys_);
    for (auto run = keys_.begin(); run != keys_.end();) {
        const auto end = std::find_if(run + 1, keys_.end(), [run](const SortKey& key) { return key.key != run->key; });
        if (end - run > 1) {
            std::sort(run, end, [items](const SortKey& a, const SortKey& b) {
                const std::strong_ordering order = compare_size(items[a.index], items[b.index]);
                return std::is_neq(order) ? std::is_gt(order) : a.index > b.index;
            });
        }
        run = end;
    }
    edge_index_.clear();
    rings_.resize(keys_.size());
    areas_.resize(keys_.size());
    for (std::size_t i = 0; i < keys_.size(); ++i) {
        const NestItem& item = items[keys_[i].index];
        const auto [high, low] = magnitude(item.twice_area);
        Ring& ring = rings_[i] = Ring{};
        ring.start = item.points[item.start];
        ring.box_min = item.box_min;
        ring.box_max = item.box_max;
        areas_[i] = high != 0 ? std::numeric_limits<std::uint64_t>::max() : low;
        ring.item = keys_[i].index;
    }
}

/// Every contour against every earlier one, four boxes at a time.
void Nester::find_parents_among_few(std::span<const NestItem> items) {
    quads_.assign((rings_.size() + 3) / 4, BoxQuad{});
    std::size_t left = 0;  // rings that begin left of the start asked for, and are in `quads_`
    for (std::size_t ring = 1; ring < rings_.size(); ++ring) {
        const Point start = rings_[ring].start;
        for (; rings_[left].box_min.x < start.x; ++left) {
            quads_[left / 4].set(left % 4, rings_[left].box_min, rings_[left].box_max);
        }
        std::uint64_t smallest = std::numeric_limits<std::uint64_t>::max();  // of those found around the start
        for (std::size_t quad = (left + 3) / 4; quad-- > 0;) {
            for (unsigned around = quads_[quad].around(start); around != 0;) {
                const auto lane = static_cast<std::size_t>(std::bit_width(around) - 1);
                around &= ~(1U << lane);
                const std::size_t candidate = 4 * quad + lane;
                if (areas_[candidate] <= smallest) {
                    take_if_closer(items, ring, candidate);
                    smallest = rings_[ring].parent >= 0 ? areas_[static_cast<std::size_t>(rings_[ring].parent)] : smallest;
                }
            }
        }
    }
}

/// A sweep over the starts. The last box around a start is most often the parent's; the rest are asked while there is
/// patience, which only matters where contours cross.
void Nester::find_parents_among_many(std::span<const NestItem> items) {
    order_places();
    tree_.reset(static_cast<std::uint32_t>(rings_.size()));
    std::size_t patience = 4 * rings_.size() + 4096;
    std::size_t left = 0;  // rings that begin left of the start asked for, and are in the tree
    for (std::size_t ring = 1; ring < rings_.size(); ++ring) {
        const Point start = rings_[ring].start;
        for (; rings_[left].box_min.x < start.x; ++left) {
            tree_.add(places_[left], static_cast<std::int32_t>(left), rings_[left].box_min, rings_[left].box_max);
        }
        const std::int32_t last = tree_.last_around(start);
        if (last >= 0) {
            take_if_closer(items, ring, static_cast<std::size_t>(last));
            ask_all_around(items, ring, patience);
        }
    }
}

/// Asks all rings whose boxes lie around the start of `ring`, backwards, until the parent is known and patience at its end.
void Nester::ask_all_around(std::span<const NestItem> items, std::size_t ring, std::size_t& patience) {
    around_.clear();
    std::size_t unlimited = std::numeric_limits<std::size_t>::max();
    const bool found = rings_[ring].parent >= 0;
    tree_.all_around(rings_[ring].start, found ? patience : unlimited, around_);
    if (!found) {
        std::sort(around_.begin(), around_.end(), std::greater<>());
    }
    for (const std::int32_t around : around_) {
        if (!found && rings_[ring].parent >= 0 && patience-- == 0) {
            patience = 0;
            return;
        }
        take_if_closer(items, ring, static_cast<std::size_t>(around));
    }
}

/// Places in the tree follow the boxes' middles in y: one counting pass into as many strips as there are rings.
void Nester::order_places() {
    constexpr std::size_t most_strips = std::size_t{1} << 16;
    const auto middle = [](const Ring& ring) { return (std::int64_t{ring.box_min.y} + ring.box_max.y) >> 1; };
    std::int64_t low = grid_limit;
    std::int64_t high = -grid_limit;
    for (const Ring& ring : rings_) {
        low = std::min(low, middle(ring));
        high = std::max(high, middle(ring));
    }
    const std::size_t strips = std::min(std::bit_ceil(rings_.size()), most_strips);
    const int shift =
        std::max(0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(high - low))) - std::countr_zero(strips));
    const auto strip_of = [&](const Ring& ring) { return static_cast<std::size_t>((middle(ring) - low) >> shift); };
    strip_ends_.assign(strips, 0);
    for (const Ring& ring : rings_) {
        ++strip_ends_[strip_of(ring)];
    }
    std::exclusive_scan(strip_ends_.begin(), strip_ends_.end(), strip_ends_.begin(), 0U);
    places_.resize(rings_.size());
    for (std::size_t i = 0; i < rings_.size(); ++i) {
        places_[i] = strip_ends_[strip_of(rings_[i])]++;
    }
}

/// Makes `around`, whose box is known to lie around the start of `ring`, its parent if the contour does and is the smallest
/// so far, in whatever order they are asked.
void Nester::take_if_closer(std::span<const NestItem> items, std::size_t ring_index, std::size_t around_index) {
    Ring& ring = rings_[ring_index];
    Ring& around = rings_[around_index];
    if (ring.parent >= 0) {
        const auto best = static_cast<std::size_t>(ring.parent);
        if (areas_[around_index] > areas_[best] || around_index == best) {
            return;
        }
        if (areas_[around_index] == areas_[best]) {
            const std::strong_ordering order = compare_size(items[around.item], items[rings_[best].item]);
            if (std::is_gt(order) ||
                (std::is_eq(order) && around_index < best)) {  // of equal contours the first item is the later ring
                return;
            }
        }
    }
    if (inside(items[around.item], around, ring.start)) {
        ring.parent = static_cast<std::int32_t>(around_index);
    }
}

/// Long contours that are asked often get an index, so that many children cost their parent's points only once.
bool Nester::inside(const NestItem& contour, Ring& ring, Point query) {
    constexpr std::uint32_t long_contour = 256;
    constexpr std::uint32_t tests_before_index = 3;
    if (contour.count < long_contour || ring.tests < tests_before_index) {
        ++ring.tests;
        return nesting::strictly_inside(add_edges_, contour.points, contour.count, query);
    }
    if (ring.tests == tests_before_index) {
        ring.edge_index = edge_index_.add(contour.points, contour.count);
        ++ring.tests;
    }
    return edge_index_.strictly_inside(ring.edge_index, add_edges_, contour.points, contour.count, query);
}

/// The facets' sense stands as long as no winding number from the outside in is negative; below one that is, the number of
/// contours around decides.
void Nester::assign_roles(std::span<NestItem> items) {
    for (Ring& ring : rings_) {
        NestItem& item = items[ring.item];
        ring.winding = item.sense > 0 ? 1 : -1;
        if (ring.parent >= 0) {
            const Ring& around = rings_[static_cast<std::size_t>(ring.parent)];
            item.parent = static_cast<std::int32_t>(around.item);
            ring.winding += around.winding;
            ring.depth = around.depth + 1;
            ring.overruled = around.overruled;
        }
        ring.overruled |= ring.winding < 0;
        const bool outer = ring.overruled ? ring.depth % 2 == 0 : item.sense > 0;
        item.role = outer ? Role::outer : Role::hole;
        item.reverse = outer != (item.sense > 0);
        if (ring.overruled) {
            item.flags = static_cast<std::uint16_t>(item.flags | sense_overruled);
        }
    }
}

}  // namespace lamella
