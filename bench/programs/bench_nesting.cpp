// Times nesting alone, on layers of 10 to 10,000 contours.
#include <vector>

#include "base/numbers.hpp"
#include "measure.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella::bench {

namespace {

/// Resets what nesting writes into an item.
void forget(std::vector<NestItem>& items) {
    for (NestItem& item : items) {
        item.flags = 0;
        item.parent = -1;
    }
}

/// `count` rings on a square lattice. Every second ring is the hole of the ring before it.
class RingLattice {
public:
    explicit RingLattice(std::uint32_t count) {
        points_.reserve(std::size_t{count} * ring_points);
        std::uint32_t row = 1;
        while (row * row * 2 < count) {
            ++row;
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            const bool hole = i % 2 == 1;
            const std::uint32_t cell = i / 2;
            add_ring(static_cast<std::int32_t>(cell % row) * pitch, static_cast<std::int32_t>(cell / row) * pitch,
                     hole ? side / 2 : side, hole);
        }
    }
    std::vector<NestItem>& items() noexcept { return items_; }

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
    static constexpr std::uint32_t ring_points = 4 * steps;
    static constexpr std::int32_t side = 64 * steps;
    static constexpr std::int32_t pitch = 2 * side;

    /// A square from its lower left corner, counter-clockwise; clockwise for a hole.
    void add_ring(std::int32_t centre_x, std::int32_t centre_y, std::int32_t length, bool hole) {
        const Point* ring = points_.data() + points_.size();
        const Point low{centre_x - length / 2, centre_y - length / 2};
        for (std::int32_t i = 0; i < 4 * steps; ++i) {
            const std::int32_t along = i % steps * (length / steps);
            const Point right[] = {{along, 0}, {length, along}, {length - along, length}, {0, length - along}};
            const Point& at = right[i / steps];
            points_.push_back(hole ? Point{low.x + at.y, low.y + at.x} : Point{low.x + at.x, low.y + at.y});
        }
        NestItem& item = items_.emplace_back();
        item.points = ring;
        item.count = ring_points;
        item.twice_area = to_integer128((hole ? -2 : 2) * Int128{length} * length);
        item.box = {low, {low.x + length, low.y + length}};
        item.closed = true;
    }

    std::vector<Point> points_;
    std::vector<NestItem> items_;
};

void run_nesting(benchmark::State& state, std::uint32_t contours) {
    RingLattice lattice(contours);
    lamella::Worker worker;
    Nester nester(worker);
    nester.nest(lattice.items());
    if (!lattice.nested()) {
        fail("the rings are not nested as constructed");
    }
    measure(
        state, [&] { forget(lattice.items()); }, [&] { nester.nest(lattice.items()); });
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
