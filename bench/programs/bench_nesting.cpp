// Times nesting alone, on layers of 10 to 10,000 contours.
#include <cmath>
#include <vector>

#include "base/numbers.hpp"
#include "measure.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella::bench {

namespace {

/// `count` square rings on a square lattice, of which every second is the hole of the one before it: outers
/// counter-clockwise, holes clockwise.
class RingLattice {
public:
    explicit RingLattice(std::uint32_t count) : points_(std::size_t{count} * 4 * steps), items_(count) {
        const auto row = static_cast<std::uint32_t>(std::ceil(std::sqrt(count / 2)));
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::int32_t length = i % 2 == 1 ? side / 2 : side;
            const Point centre{static_cast<std::int32_t>(i / 2 % row) * 2 * side,
                               static_cast<std::int32_t>(i / 2 / row) * 2 * side};
            const Point low{centre.x - length / 2, centre.y - length / 2};
            Point* const ring = points_.data() + std::size_t{i} * 4 * steps;
            for (std::int32_t at = 0; at < 4 * steps; ++at) {
                const std::int32_t along = at % steps * (length / steps);
                const Point turning[] = {{along, 0}, {length, along}, {length - along, length}, {0, length - along}};
                const auto [x, y] = turning[at / steps];
                ring[at] = i % 2 == 1 ? Point{low.x + y, low.y + x} : Point{low.x + x, low.y + y};
            }
            items_[i].points = ring;
            items_[i].count = 4 * steps;
            items_[i].twice_area = to_integer128((i % 2 == 1 ? -2 : 2) * Int128{length} * length);
            items_[i].box = {low, {low.x + length, low.y + length}};
            items_[i].closed = true;
        }
    }

    /// The items, without what nesting writes into them.
    std::vector<NestItem>& fresh_items() noexcept {
        for (NestItem& item : items_) {
            item.flags = 0;
            item.parent = -1;
        }
        return items_;
    }

    /// Outers have no parent; the parent of a hole is its outer.
    bool nested() const noexcept {
        for (std::size_t i = 0; i < items_.size(); ++i) {
            const bool hole = i % 2 == 1;
            if (items_[i].parent != (hole ? static_cast<std::int64_t>(i) - 1 : -1) ||
                items_[i].role != (hole ? Role::hole : Role::outer)) {
                return false;
            }
        }
        return true;
    }

private:
    static constexpr std::int32_t steps = 16;  // points on each side
    static constexpr std::int32_t side = 64 * steps;

    std::vector<Point> points_;
    std::vector<NestItem> items_;
};

void run_nesting(benchmark::State& state, std::uint32_t contours) {
    RingLattice lattice(contours);
    lamella::Worker worker;
    Nester nester(worker);
    nester.nest(lattice.fresh_items());
    if (!lattice.nested()) {
        fail("the rings are not nested as constructed");
    }
    std::vector<NestItem>* items = nullptr;
    measure(
        state, [&] { items = &lattice.fresh_items(); }, [&] { nester.nest(*items); });
    state.counters["contours/s"] = rate_of(contours);
}

}  // namespace

void add_nesting(const Options& options) {
    for (const std::uint32_t contours : {10U, 100U, 1'000U, 10'000U}) {
        add_benchmark("nesting/rings_" + std::to_string(contours) + "/series", 1, options,
                      [=](benchmark::State& state) { run_nesting(state, contours); });
    }
}

}  // namespace lamella::bench
