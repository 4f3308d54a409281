// Regions of polygons on small lattices and over the whole grid, by every rule. A region must keep its promises, must not
// depend on the contours' order or starts, must be its own region, and closing must agree with closing everything.

#include "rings.hpp"

using namespace lamella;
using fuzz::Lattice;
using fuzz::Ring;
using fuzz::Rings;

namespace {

using fuzz::unit_mm;
constexpr std::size_t most_rings = 12;
constexpr std::size_t most_points = 96;

RegionRules drawn_rules(fuzz::Bytes& bytes, const Lattice& lattice) {
    constexpr FillRule rules[] = {FillRule::even_odd, FillRule::non_zero, FillRule::positive, FillRule::outermost};
    constexpr double limits[] = {1, 1.2, 3, 10};
    RegionRules drawn;
    const unsigned first = bytes.next();
    drawn.fill_rule = rules[first % 4];
    drawn.largest_only = first / 4 % 8 == 0;
    drawn.drop_collinear = first / 32 % 2 == 0;
    drawn.miter_limit = limits[first / 64];
    const unsigned second = bytes.next();
    // Eighths of a lattice's step, and a few units more or less.
    const auto length = [&](unsigned byte) {
        const double steps = byte % 16 * 0.25 * lattice.step + (byte / 16 % 4) * 0.5;
        return steps < 1 ? 0 : std::min(steps, grid_limit / drawn.miter_limit);
    };
    if (second % 4 != 0) {
        drawn.closing_mm = length(bytes.next());
    }
    if (second / 4 % 4 == 1) {
        drawn.offset_mm = length(bytes.next());
    } else if (second / 4 % 4 == 2) {
        drawn.offset_mm = -length(bytes.next());
    }
    return drawn;
}

/// Empty where the region leads beyond the grid: nothing else may refuse one.
Result<SliceResult> region(const Rings& rings, const RegionRules& rules) {
    auto made = regions::region(rings, rules, unit_mm);
    if (!made) {
        const Error& error = made.error();
        fuzz::require(error.code == ErrorCode::invalid_argument &&
                          (rules.closing_mm > 0 || rules.offset_mm != 0 || rules.flag_closing_mm > 0) &&
                          error.message.find("beyond the grid") != std::string::npos,
                      error.message);
    }
    return made;
}

/// The same whatever the order and the starts of the contours; it keeps the promises of regions.
Result<SliceResult> sound_region(const Rings& rings, const RegionRules& rules, std::uint32_t seed) {
    auto made = region(rings, rules);
    const auto again = region(regions::shuffled(rings, seed), rules);
    fuzz::require(made.ok() == again.ok() && (!made || regions::same(*made, *again)),
                  "order and starts do not change the region, nor its marks");
    const std::string broken = made ? regions::broken_promise(*made) : "";
    fuzz::require(broken.empty(), broken);
    return made;
}

/// What `a` has and `b` has not, in square units.
double area_outside(const SliceResult& a, const SliceResult& b) {
    Rings rings = regions::rings_of(a);
    for (Ring& ring : regions::rings_of(b)) {
        std::reverse(ring.begin(), ring.end());
        rings.push_back(std::move(ring));
    }
    return regions::area_of(*region(rings, {.fill_rule = FillRule::positive}));
}

/// What is thinner than a unit may vanish: an edge that was moved can pass a pixel that it did not pass before.
void check_itself(const SliceResult& made) {
    const auto again = region(regions::rings_of(made), {.fill_rule = FillRule::positive});
    fuzz::require(regions::difference_of(made, *again) <= fuzz::rounding_along(regions::rings_of(made)),
                  "a region is its own region");
}

/// What rounding may move where `dilated` is eroded. It turns an edge of length L by up to 2 / L, and erosion may make the
/// edge longer by what the miters at both ends add: little for a long edge, but as good as any direction for one of a unit,
/// which is what a corner where three moved edges meet may become.
double rounding_of_erosion(const SliceResult& dilated, const RegionRules& rules) {
    const double added = 2 * rules.closing_mm * std::max(1.0, std::sqrt(rules.miter_limit * rules.miter_limit - 1));
    double sum = 0;
    for (const Ring& ring : regions::rings_of(dilated)) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i];
            const Point b = ring[(i + 1) % ring.size()];
            const double length = std::hypot(double(b.x) - a.x, double(b.y) - a.y);
            sum += (length + added) * (length + added) / length;
        }
    }
    return sum;
}

/// Against closing everything, where the grid holds that: the dilated contours need as much room around them once more.
void check_closing(const Rings& rings, RegionRules rules, const SliceResult& made) {
    if (rules.largest_only || rules.fill_rule == FillRule::outermost || rules.closing_mm == 0 || rules.offset_mm != 0) {
        return;
    }
    const auto everywhere = regions::closed_everywhere(rings, rules, unit_mm);
    if (!everywhere) {
        fuzz::require(everywhere.error().message.find("beyond the grid") != std::string::npos, everywhere.error().message);
        return;
    }
    RegionRules dilating = rules;
    dilating.offset_mm = rules.closing_mm;
    dilating.closing_mm = 0;
    RegionRules filling = dilating;
    filling.offset_mm = 0;
    const double rounding = fuzz::rounding_along(regions::rings_of(*region(rings, filling))) +
                            rounding_of_erosion(*region(rings, dilating), rules);
    const double difference = regions::difference_of(made, *everywhere);
    fuzz::require(difference >= 0 && difference <= rounding, "closing agrees with closing everything");
}

/// What is dilated contains the region, and the region what is eroded.
void check_offset(const Rings& rings, RegionRules rules, const SliceResult& made) {
    if (rules.largest_only || rules.fill_rule == FillRule::outermost || rules.closing_mm != 0 || rules.offset_mm == 0) {
        return;
    }
    const bool dilated = rules.offset_mm > 0;
    rules.offset_mm = 0;
    const auto plain = region(rings, rules);
    fuzz::require(
        area_outside(dilated ? *plain : made, dilated ? made : *plain) <= fuzz::rounding_along(regions::rings_of(*plain)),
        "offsets move outwards or inwards only");
}

void check_marks(const Rings& rings, RegionRules rules) {
    rules.flag_closing_mm = rules.closing_mm;
    rules.closing_mm = rules.offset_mm = 0;
    (void)sound_region(rings, rules, 5);
}

/// What is simplified keeps its contours, their starts and roles, and crosses nowhere.
void check_simplified(const Rings& rings, RegionRules rules, const SliceResult& made) {
    rules.simplify_mm = std::max(1.0, rules.closing_mm);
    const auto simplified = sound_region(rings, rules, 7);
    fuzz::require(simplified.ok(), "what is a region can be simplified");
    const bool same_contours = std::equal(made.contours.begin(), made.contours.end(), simplified->contours.begin(),
                                          simplified->contours.end(), [&](const Contour& a, const Contour& b) {
                                              return a.role == b.role && a.parent == b.parent &&
                                                     a.point_count >= b.point_count &&
                                                     made.points[a.first_point] == simplified->points[b.first_point];
                                          });
    fuzz::require(same_contours, "simplification keeps contours, starts, roles and parents");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const std::uint32_t seed = bytes.next();
    const Lattice lattice = fuzz::drawn_lattice(bytes);
    const RegionRules rules = drawn_rules(bytes, lattice);
    Rings rings;
    std::size_t points = 0;
    while (!bytes.empty() && rings.size() < most_rings && points < most_points) {
        rings.push_back(fuzz::drawn_ring(bytes, lattice));
        points += rings.back().size();
    }
    const auto made = sound_region(rings, rules, seed);
    check_marks(rings, rules);
    if (!made) {
        return 0;
    }
    check_itself(*made);
    check_closing(rings, rules, *made);
    check_offset(rings, rules, *made);
    check_simplified(rings, rules, *made);
    return 0;
}
