// The order of a layer's contours in the result, whatever the order of the walk: by start, each outer followed by its holes.
//
//     contours      c0   c1   c2   c3          as walked
//     items         c2   c0   c3   c1          by start; nested in this order
//     result        c2 [ c3 ] | c0 [ c1 ]      outers with their holes
#pragma once

#include <cassert>
#include <cstdint>
#include <numeric>
#include <span>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella {

/// One per thread; scratch is kept.
class CanonicalOrder {
public:
    explicit CanonicalOrder(Worker& worker) noexcept : worker_(worker) {}

    /// Sorts by comes_before(). O(q log q). Throws std::bad_alloc.
    void sort_by_start(std::span<const Path> contours) {
        by_start_.clear();
        for (std::uint32_t i = 0; i < contours.size(); ++i) {
            const NestItem& item = contours[i].item;
            worker_.spend(item_work);
            by_start_.push_back({nesting::key_of(item.points[item.start]), i});
        }
        nesting::sort_keys(by_start_, spare_keys_, worker_);
        nesting::sort_equal_keys(by_start_, [contours](const nesting::SortKey& key_a, const nesting::SortKey& key_b) {
            return comes_before(contours[key_a.index], contours[key_b.index]);
        });
    }

    /// The path that comes `item`-th by start.
    std::uint32_t path_of(std::size_t item) const noexcept { return by_start_[item].index; }
    std::size_t size() const noexcept { return by_start_.size(); }

    /// Finds the place in the result of each item; `items` are by start and nested. O(q). Throws std::bad_alloc.
    /// A hole's leader is the nearest outer around it, any other item its own. The outer starts before the hole, or at the
    /// same point where they touch there. Groups are counted, then filled: leaders first, holes by start.
    void put_holes_after_outers(std::span<const NestItem> items) {
        const std::size_t count = items.size();
        next_place_.assign(count, 0);
        place_of_.resize(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const NestItem& item = items[i];
            worker_.spend(item_work);
            assert((item.role != Role::hole || item.parent >= 0) && "a hole lies in something");
            const auto around = static_cast<std::uint32_t>(item.parent);
            assert(item.role != Role::hole || around < i || items[around].role == Role::outer);
            place_of_[i] = item.role != Role::hole ? i : (around < i ? place_of_[around] : around);  // its leader
            ++next_place_[place_of_[i]];
        }
        std::exclusive_scan(next_place_.begin(), next_place_.end(), next_place_.begin(), 0U);
        item_at_.resize(count);
        for (const bool holes : {false, true}) {
            worker_.spend(count);
            for (std::uint32_t i = 0; i < count; ++i) {
                if ((items[i].role == Role::hole) == holes) {
                    place_of_[i] = next_place_[place_of_[i]]++;
                    item_at_[place_of_[i]] = i;
                }
            }
        }
    }

    std::uint32_t place_of(std::size_t item) const noexcept { return place_of_[item]; }
    /// The items in the order of the result.
    std::span<const std::uint32_t> items() const noexcept { return item_at_; }

private:
    static constexpr std::size_t item_work = 8;  ///< as StopPace counts it

    Worker& worker_;
    Vector<nesting::SortKey> by_start_{worker_.memory()}, spare_keys_{worker_.memory()};
    Vector<std::uint32_t> next_place_{worker_.memory()};  // of each leader: its group's size, then where the next goes
    Vector<std::uint32_t> place_of_{worker_.memory()};    // of each item: its leader, then its place
    Vector<std::uint32_t> item_at_{worker_.memory()};     // at each place
};

/// The contours of a layer on their way to the result. One per thread; scratch is kept.
struct LayerContours {
    static constexpr std::size_t contour_work = 32;  ///< of a pass over contours, as StopPace counts it
    explicit LayerContours(Worker& worker) noexcept
        : paths(worker.memory()), items(worker.memory()), order(worker), nester(worker), worker(worker) {}

    /// Lists the items of the paths by start.
    void sort_by_start() {
        order.sort_by_start(paths);
        items.clear();
        reserve_more(items, paths.size());
        for (std::size_t i = 0; i < paths.size(); ++i) {
            worker.spend(contour_work);
            items.push_back(path_of(i).item);
        }
    }
    Path& path_of(std::size_t item) noexcept { return paths[order.path_of(item)]; }

    Vector<Path> paths;      // in any order
    Vector<NestItem> items;  // of the paths, by start
    CanonicalOrder order;
    Nester nester;
    bool with_origins = false;
    Worker& worker;
};

}  // namespace lamella
