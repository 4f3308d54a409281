// Sets of rings on small lattices and over the whole grid, combined by tables of labels. The answer must be structured as
// results are, must not depend on the order of sets, contours or starts, and its labels must share out what the union holds,
// to the last bit. What each set holds alone, and the answer as a set again, agree but for what rounding moves.
#include <bit>
#include <map>
#include <numeric>

#include "base/numbers.hpp"
#include "lamella/overlay.hpp"
#include "rings.hpp"

using namespace lamella;
using fuzz::Rings;
using rings::Int128;

namespace {

constexpr std::size_t most_sets = 4;
constexpr std::size_t most_rings_of_set = 5;

struct DrawnSet {
    Rings rings;
    FillRule fill_rule;
    double grow_mm;
};

DrawnSet drawn_set(fuzz::Bytes& bytes, const fuzz::Lattice& lattice) {
    constexpr FillRule rules[] = {FillRule::non_zero, FillRule::even_odd, FillRule::positive};
    DrawnSet set;
    const unsigned byte = bytes.next();
    set.fill_rule = rules[byte % 3];
    const double steps = byte / 8 % 4 == 1 ? bytes.next() % 16 * 0.25 * lattice.step : 0;
    set.grow_mm = steps < 1 ? 0 : std::min(steps, 1e8) * (byte / 32 % 2 == 0 ? 1 : -1);
    const std::size_t count = 1 + bytes.below(most_rings_of_set);
    while (!bytes.empty() && set.rings.size() < count) {
        set.rings.push_back(fuzz::drawn_ring(bytes, lattice));
    }
    return set;
}

/// Sets, and the spans that they view.
class Sets {
public:
    /// In the order of `numbers`.
    Sets(const std::vector<DrawnSet>& drawn, const std::vector<std::size_t>& numbers) {
        for (const std::size_t n : numbers) {
            views_.emplace_back(drawn[n].rings.begin(), drawn[n].rings.end());
        }
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            given_.push_back({views_[i], fuzz::unit_mm});
        }
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            sets.push_back(
                {.layers = given_[i], .grow_mm = drawn[numbers[i]].grow_mm, .fill_rule = drawn[numbers[i]].fill_rule});
        }
    }

    std::vector<LayerSet> sets;

private:
    std::vector<std::vector<std::span<const Point>>> views_;
    std::vector<ContourSet> given_;
};

Result<SliceResult> combined(std::span<const LayerSet> sets, const Rule& rule) {
    SliceResult result;
    Overlay overlay;
    const auto info = overlay.combine(result, sets, rule, {}, {.threads = 1});
    if (!info) {
        fuzz::require(info.error().code == ErrorCode::invalid_argument &&
                          info.error().message.find("beyond the grid") != std::string::npos,
                      info.error().message);
        return info.error();
    }
    fuzz::require_valid(result);
    return result;
}

/// Of each part, and in all.
std::map<std::uint32_t, Int128> twice_areas(const SliceResult& result) {
    std::map<std::uint32_t, Int128> areas;
    for (const Contour& contour : result.contours) {
        areas[contour.part] += to_int128(contour.twice_area);
    }
    return areas;
}
Int128 twice_area(const SliceResult& result) {
    Int128 sum = 0;
    for (const auto& [part, area] : twice_areas(result)) {
        sum += area;
    }
    return sum;
}

std::vector<std::size_t> numbers_to(std::size_t count) {
    std::vector<std::size_t> all(count);
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
}

/// The same of sets in another order, of which each has its rings in another order from other starts.
void check_order(std::vector<DrawnSet> drawn, const std::vector<std::uint32_t>& labels, std::uint32_t seed,
                 const SliceResult& expected) {
    std::vector<std::size_t> order = numbers_to(drawn.size());
    fuzz::shuffle(order, seed);
    for (DrawnSet& set : drawn) {
        set.rings = regions::shuffled(set.rings, seed);
    }
    std::vector<std::uint32_t> turned(labels.size());
    for (std::size_t in = 0; in < labels.size(); ++in) {
        std::size_t as_given = 0;
        for (std::size_t i = 0; i < order.size(); ++i) {
            as_given |= (in >> i & 1) << order[i];
        }
        turned[in] = labels[as_given];
    }
    const auto again = combined(Sets(drawn, order).sets, {.labels = turned});
    fuzz::require(again.ok() && again->hash() == expected.hash(), "order and starts do not change the answer");
}

/// A region for each membership: together the union, and of each set those that lie in it.
void check_shares(const std::vector<DrawnSet>& drawn, const Sets& given, double rounding) {
    std::vector<std::uint32_t> by_membership(std::size_t{1} << drawn.size());
    std::iota(by_membership.begin(), by_membership.end(), 0U);
    const SliceResult shared = fuzz::value_of(combined(given.sets, {.labels = by_membership}));
    fuzz::require(twice_area(shared) == twice_area(fuzz::value_of(combined(given.sets, unite))),
                  "labels share out the union");
    for (std::size_t s = 0; s < drawn.size(); ++s) {
        Int128 inside = 0;
        for (const auto& [part, area] : twice_areas(shared)) {
            inside += (part + 1) >> s & 1 ? area : Int128{0};
        }
        const SliceResult alone = fuzz::value_of(combined(std::span(given.sets).subspan(s, 1), unite));
        fuzz::require(std::abs(static_cast<double>(inside - twice_area(alone))) <= 2 * rounding,
                      "labels share out each set");
    }
}

/// The answer is a set, and each of its parts a region.
void check_again(const SliceResult& made, double rounding) {
    for (const auto& [part, area] : twice_areas(made)) {
        const LayerSet set[] = {{.layers = made, .part = part}};
        const SliceResult again = fuzz::value_of(combined(set, unite));
        fuzz::require(std::abs(static_cast<double>(area - twice_area(again))) <= 2 * rounding, "an answer is a set again");
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const std::uint32_t seed = bytes.next();
    const fuzz::Lattice lattice = fuzz::drawn_lattice(bytes);
    std::vector<DrawnSet> drawn(1 + bytes.below(most_sets));
    std::vector<std::uint32_t> labels(std::size_t{1} << drawn.size());
    for (std::size_t in = 1; in < labels.size(); ++in) {
        labels[in] = bytes.below(4);
    }
    for (DrawnSet& set : drawn) {
        set = drawn_set(bytes, lattice);
    }
    const Sets given(drawn, numbers_to(drawn.size()));
    const auto made = combined(given.sets, {.labels = labels});
    if (!made) {
        return 0;
    }
    auto label_of = [&labels](std::uint64_t in) noexcept { return labels[in]; };
    const SliceResult by_function = fuzz::value_of(combined(given.sets, {.label_of = label_of}));
    fuzz::require(by_function.hash() == made->hash(), "a function is as good as its table");
    check_order(drawn, labels, seed, *made);
    double rounding = fuzz::rounding_along(regions::rings_of(*made));
    for (const LayerSet& set : given.sets) {
        rounding += fuzz::rounding_along(regions::rings_of(fuzz::value_of(combined({&set, 1}, unite))));
    }
    check_shares(drawn, given, rounding);
    check_again(*made, rounding);
    return 0;
}
