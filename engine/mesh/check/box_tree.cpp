#include "mesh/check/box_tree.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

#include "base/parallel_sort.hpp"

namespace lamella {

namespace {

constexpr int key_bits = 21;  ///< an axis: three fit 64
constexpr std::size_t box_grain = 8192;
constexpr std::size_t items_a_part = std::size_t{1} << 13;

struct Keyed {
    std::uint64_t key;
    std::uint32_t item;
};

struct KeyedLess {
    bool operator()(const Keyed& a, const Keyed& b) const noexcept {
        return a.key != b.key ? a.key < b.key : a.item < b.item;
    }
};

constexpr Box nothing() {
    constexpr std::int32_t least = std::numeric_limits<std::int32_t>::min();
    constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
    return {{most, most, most}, {least, least, least}};
}

/// Two zeros between any two bits.
std::uint64_t spread(std::uint64_t bits) {
    bits = (bits | bits << 32) & 0x001F00000000FFFF;
    bits = (bits | bits << 16) & 0x001F0000FF0000FF;
    bits = (bits | bits << 8) & 0x100F00F00F00F00F;
    bits = (bits | bits << 4) & 0x10C30C30C30C30C3;
    return (bits | bits << 2) & 0x1249249249249249;
}

/// Of the box's middle, in a cube around everything.
class MortonKey {
public:
    explicit MortonKey(const Box& all) : low_(all.low) {
        std::int64_t extent = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            extent = std::max(extent, std::int64_t{all.high[axis]} - all.low[axis]);
        }
        shift_ = std::max(0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(extent))) - key_bits);
    }

    std::uint64_t operator()(const Box& box) const {
        std::uint64_t key = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t middle = (std::int64_t{box.low[axis]} + box.high[axis]) / 2 - low_[axis];
            key |= spread(static_cast<std::uint64_t>(std::max<std::int64_t>(middle, 0)) >> shift_) << axis;
        }
        return key;
    }

private:
    std::array<std::int32_t, 3> low_;
    int shift_ = 0;
};

}  // namespace

Box Box::around(std::span<const GridVertex> points) noexcept {
    Box box = nothing();
    for (const GridVertex& p : points) {
        box.include({{p.x, p.y, p.z}, {p.x, p.y, p.z}});
    }
    return box;
}

void Box::include(const Box& other) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], other.low[axis]);
        high[axis] = std::max(high[axis], other.high[axis]);
    }
}

BoxTree::BoxTree(std::size_t count, BoxOf box_of, const Parallel& parallel) {
    assert(count < std::numeric_limits<std::uint32_t>::max());
    Array<Box> boxes;
    boxes.resize_discarding(count);
    parallel.run_ranges(count, box_grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i != end; ++i) {
            boxes[i] = box_of(i);
        }
    });
    sort_items(boxes, parallel);
    levels_.emplace_back().resize_discarding(count);
    parallel.run_ranges(count, box_grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i != end; ++i) {
            levels_[0][i] = boxes[items_[i]];
        }
    });
    while (levels_.back().size() > fan) {
        Array<Box> level;
        level.resize_discarding((levels_.back().size() + fan - 1) / fan);
        const Array<Box>& below = levels_.back();
        parallel.run_ranges(level.size(), box_grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i != end; ++i) {
                level[i] = nothing();
                for (std::size_t j = i * fan; j < std::min(below.size(), (i + 1) * fan); ++j) {
                    level[i].include(below[j]);
                }
            }
        });
        levels_.push_back(std::move(level));
    }
    assert(levels_.size() <= deepest);
}

/// In Morton order.
void BoxTree::sort_items(const Array<Box>& boxes, const Parallel& parallel) {
    const std::size_t count = boxes.size();
    std::vector<Box> own(static_cast<std::size_t>(parallel.threads()), nothing());
    parallel.run_ranges(count, box_grain, [&](std::size_t begin, std::size_t end, int worker) {
        for (std::size_t i = begin; i != end; ++i) {
            own[static_cast<std::size_t>(worker)].include(boxes[i]);
        }
    });
    Box all = nothing();
    for (const Box& box : own) {
        all.include(box);
    }
    const MortonKey key(count == 0 ? Box{} : all);
    const auto keyed = [&](std::size_t i) { return Keyed{key(boxes[i]), static_cast<std::uint32_t>(i)}; };
    const Splitters<Keyed, KeyedLess> splitters(count, parts_for(count, items_a_part), KeyedLess{}, keyed);
    Distributed<Keyed> parts =
        distribute<Keyed>(count, splitters.parts(), parallel, [&](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t i = begin; i != end; ++i) {
                const Keyed item = keyed(i);
                emit(splitters.part_of(item), item);
            }
        });
    items_.resize_discarding(count);
    parallel.run(parts.size(), [&](std::size_t part, int) {
        const std::span<Keyed> sorted = parts.of(part);
        std::sort(sorted.begin(), sorted.end(), KeyedLess{});
        std::transform(sorted.begin(), sorted.end(), items_.begin() + parts.firsts[part],
                       [](const Keyed& item) { return item.item; });
    });
}

}  // namespace lamella
