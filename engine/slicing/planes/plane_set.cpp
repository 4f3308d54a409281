#include "slicing/planes/plane_set.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "base/sort.hpp"
#include "base/words.hpp"
#include "lamella/result.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

constexpr std::int32_t below_all = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t above_all = std::numeric_limits<std::int32_t>::max();
constexpr double beyond_grid = 1.5 * grid_limit;  ///< in grid units
constexpr double most_planes = 2147483648.0 - 4;
constexpr std::size_t most_listed = std::size_t{1} << 27;  // more would not fit beyond either end of the grid

std::string mm_text(double mm) {
    return exact_text(mm) + " mm";
}

[[noreturn]] void refuse(ErrorCode code, std::string message, std::int64_t plane = -1) {
    throw Refused{{code, std::move(message), -1, plane}};
}

/// SplitMix64: a generator small enough to write out, so that a seed means the same planes on every platform.
class Generator {
public:
    explicit Generator(std::uint64_t seed) : state_(seed) {}
    /// Uniform in [0, 1), 53 bits.
    double next() noexcept {
        state_ += 0x9E3779B97F4A7C15U;
        return static_cast<double>(mix64(state_) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

}  // namespace

void PlaneSet::build(const SliceOptions& options, const std::optional<RandomHeights>& random, const SharedFrame& frame,
                     std::uint64_t memory_limit) {
    side_ = options.planes.side;
    layer_height_mm_ = 0;
    unit_mm_ = frame.unit.mm;
    number_ = frame.number;
    count_ = 0;
    first_kept_ = 0;
    inverse_step_ = 0;
    heights_mm_.clear();
    plane_of_listed_.clear();
    slabs_.clear();
    if (!options.slabs.empty()) {
        build_slabs(options);
    } else if (random) {
        build_random(*random, frame.bounds, memory_limit);
    } else if (options.heights_mm) {
        build_listed(*options.heights_mm);
    } else {
        build_uniform(options, frame.bounds, memory_limit);
    }
    planned_ = count_;
}

PlaneRange PlaneSet::range_of(std::uint64_t first_layer, std::uint64_t end_layer) const {
    if (count_ == 0) {
        return {0, 0};
    }
    if (first_layer >= std::min<std::uint64_t>(end_layer, count_)) {
        refuse(ErrorCode::bad_planes, "layers " + std::to_string(first_layer) + ":" + std::to_string(end_layer) +
                                          " are none of the " + counted(count_, "layer") + " of the plan");
    }
    return {static_cast<PlaneIndex>(first_layer), static_cast<PlaneIndex>(std::min<std::uint64_t>(end_layer, count_))};
}

void PlaneSet::keep(std::uint64_t first_layer, std::uint64_t end_layer) {
    const auto [first, end] = range_of(first_layer, end_layer);
    if (end - first == count_) {
        return;
    }
    std::copy(padded_.data() + 1 + first, padded_.data() + 1 + end, padded_.data() + 1);
    first_kept_ += first;
    count_ = end - first;
    padded_[count_ + 1] = above_all;
    first_step_ += static_cast<double>(first);
    make_table();
}

void PlaneSet::lower(std::int32_t by) {
    if (by == 0) {
        return;
    }
    for (PlaneIndex i = 0; i < count_; ++i) {
        const std::int64_t z = std::int64_t{padded_[i + 1]} - by;
        padded_[i + 1] = static_cast<std::int32_t>(std::clamp<std::int64_t>(z, below_all + 1, above_all - 2));
    }
    inverse_step_ = 0;  // vertices may be too far from the first for its arithmetic
    make_table();
}

void PlaneSet::build(const Array<Layer>& layers) {
    count_ = static_cast<PlaneIndex>(layers.size());
    planned_ = count_;
    first_kept_ = 0;
    layer_height_mm_ = 0;
    heights_mm_.clear();
    inverse_step_ = 0;
    padded_.resize_discarding(layers.size() + 2);
    padded_[0] = below_all;
    for (PlaneIndex i = 0; i < count_; ++i) {
        padded_[i + 1] = layers[i].plane.z();
    }
    padded_[count_ + 1] = above_all;
    if (count_ > 1) {  // evenly spaced planes are found by division again
        const double planes_per_unit = (count_ - 1) / (static_cast<double>(z(count_ - 1)) - z(0));
        bool even = true;
        for (PlaneIndex i = 0; i < count_; ++i) {
            even = even && std::abs((static_cast<double>(z(i)) - z(0)) * planes_per_unit - i) <= 1;
        }
        inverse_step_ = even ? planes_per_unit : 0;
    }
    make_table();
}

std::int32_t PlaneSet::round_height(double mm) const noexcept {
    const double as_vertex = number_ == Number::f32 ? static_cast<double>(static_cast<float>(mm)) : mm;
    const double reach_mm = beyond_grid * unit_mm_;  // what lies further cuts nothing, and would overflow
    return to_even_grid(std::clamp(as_vertex, -reach_mm, reach_mm), unit_mm_) + (side_ == PlaneSide::below ? -1 : 1);
}

void PlaneSet::check_count(double planes, std::uint64_t memory_limit) const {
    if (!(planes <= most_planes)) {
        refuse(ErrorCode::bad_planes, "more than 2^31 planes");
    }
    if (planes * static_cast<double>(sizeof(Layer) + 4 * sizeof(std::int32_t)) > static_cast<double>(memory_limit)) {
        refuse(ErrorCode::result_too_large, counted(static_cast<std::uint64_t>(planes), "layer") +
                                                " alone exceed the memory limit of " + std::to_string(memory_limit) +
                                                " bytes");
    }
}

/// Distinct after rounding, else the first pair that is not.
void PlaneSet::check_distinct() const {
    for (PlaneIndex i = 1; i < count_; ++i) {
        const double below = height_mm(i - 1);
        const double above = height_mm(i);
        if (above <= below || z(i) <= z(i - 1)) {
            refuse(ErrorCode::bad_planes,
                   "planes " + std::to_string(i - 1) + " and " + std::to_string(i) + " (" + mm_text(below) + ", " +
                       mm_text(above) + ") are the same on the grid",
                   static_cast<std::int64_t>(i));
        }
    }
}

void PlaneSet::build_uniform(const SliceOptions& options, const Bounds& bounds, std::uint64_t memory_limit) {
    const double h = options.layer_height_mm;
    const auto& [first_height_mm, datum, side, first_layer, end_layer] = options.planes;
    if (h < 2 * unit_mm_) {
        refuse(ErrorCode::bad_planes, "a layer height of " + mm_text(h) + " is under two grid units (" +
                                          mm_text(2 * unit_mm_) + "); choose a finer grid");
    }
    const double low = bounds.min_mm[2];
    const double high = bounds.max_mm[2];
    first_mm_ = (datum == Datum::zero ? 0 : low) + first_height_mm.value_or(h / 2);
    step_mm_ = h;
    layer_height_mm_ = h;
    // Layers continue below the datum only if the plan does not say where they start.
    const bool from_first = first_height_mm || datum == Datum::mesh_min;
    double step = std::floor((low - first_mm_) / h) - 1;
    step = from_first ? std::max(step, 0.0) : step;
    const double last_step = std::ceil((high - first_mm_) / h) + 1;
    const double candidates = std::max(last_step - step + 1, 0.0);
    check_count(candidates, memory_limit);
    const std::int32_t lowest = to_even_grid(low, unit_mm_);
    const std::int32_t highest = to_even_grid(high, unit_mm_);
    padded_.resize_discarding(static_cast<std::size_t>(candidates) + 2);
    first_step_ = step;
    for (std::uint32_t n = 0; n < static_cast<std::uint32_t>(candidates); ++n) {
        const double i = n;
        const double mm = first_mm_ + (step + i) * h;
        if (mm > high + h) {
            break;  // also keeps the rounding in range
        }
        if (mm < low - h) {
            first_step_ = step + i + 1;
            continue;
        }
        const std::int32_t z = round_height(mm);
        if (z < lowest) {
            first_step_ = step + i + 1;
        } else if (z < highest) {
            padded_[++count_] = z;
        }
    }
    check_distinct();
    padded_[0] = below_all;
    padded_[count_ + 1] = above_all;
    inverse_step_ = unit_mm_ / h;
    make_table();
}

/// Of the heights that are one plane, the slabs become one.
void PlaneSet::build_slabs(const SliceOptions& options) {
    const std::vector<Slab>& given = options.slabs;
    if (options.heights_mm && options.heights_mm->size() != given.size()) {
        refuse(ErrorCode::bad_planes,
               counted(given.size(), "slab") + " for " + counted(options.heights_mm->size(), "height"));
    }
    Vector<double> heights(heights_mm_.get_allocator());
    heights.reserve(given.size());
    for (std::size_t i = 0; i < given.size(); ++i) {
        const auto [bottom, top] = given[i];
        const double height = options.heights_mm ? (*options.heights_mm)[i] : middle_of(given[i]);
        if (!(bottom <= height && height <= top && std::isfinite(top - bottom))) {
            refuse(ErrorCode::bad_planes,
                   "slab " + std::to_string(i) + ", from " + mm_text(bottom) + " to " + mm_text(top) +
                       (options.heights_mm ? ", does not hold its plane at " + mm_text(height) : ", has no middle"),
                   static_cast<std::int64_t>(i));
        }
        heights.push_back(height);
    }
    build_listed(heights);
    slabs_.resize(heights_mm_.size(), {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()});
    for (std::size_t i = 0; i < given.size(); ++i) {
        Slab& slab = slabs_[plane_of_listed_[i]];
        slab = {std::min(slab.bottom_mm, given[i].bottom_mm), std::max(slab.top_mm, given[i].top_mm)};
    }
}

void PlaneSet::build_listed(std::span<const double> heights) {
    if (heights.size() > most_listed) {
        refuse(ErrorCode::bad_planes, "more than 2^27 planes listed");
    }
    for (std::size_t i = 0; i < heights.size(); ++i) {
        if (!std::isfinite(heights[i])) {
            refuse(ErrorCode::bad_planes, "plane " + std::to_string(i) + " is not finite", static_cast<std::int64_t>(i));
        }
    }
    listed_order_.resize(heights.size());
    std::iota(listed_order_.begin(), listed_order_.end(), PlaneIndex{0});
    if (!std::is_sorted(heights.begin(), heights.end())) {
        sort_briefly(listed_order_.begin(), listed_order_.end(),
                     [&](PlaneIndex a, PlaneIndex b) { return heights[a] != heights[b] ? heights[a] < heights[b] : a < b; });
    }
    heights_mm_.reserve(heights.size());
    plane_of_listed_.resize(heights.size());
    for (const PlaneIndex listed : listed_order_) {  // the least of the heights with one plane stays
        if (heights_mm_.empty() || !share_plane(heights_mm_.back(), heights[listed])) {
            heights_mm_.push_back(heights[listed]);
        }
        plane_of_listed_[listed] = static_cast<PlaneIndex>(heights_mm_.size() - 1);
    }
    fill_from_heights();
    make_table();
}

bool PlaneSet::within_reach(double mm) const noexcept {
    return std::abs(mm / unit_mm_) < beyond_grid;
}

/// Heights beyond the grid are not rounded: only equal ones share a plane.
bool PlaneSet::share_plane(double below_mm, double above_mm) const noexcept {
    return below_mm == above_mm ||
           (within_reach(below_mm) && within_reach(above_mm) && round_height(below_mm) == round_height(above_mm));
}

void PlaneSet::build_random(const RandomHeights& random, const Bounds& bounds, std::uint64_t memory_limit) {
    const double least = random.min_step_mm;
    const double most = random.max_step_mm;
    if (!(least > 0) || !(most >= least) || !std::isfinite(most)) {
        refuse(ErrorCode::invalid_argument, "random heights need 0 < minimum <= maximum");
    }
    if (least < 2 * unit_mm_) {
        refuse(ErrorCode::bad_planes, "a step of " + mm_text(least) + " is under two grid units; choose a finer grid");
    }
    const double low = bounds.min_mm[2];
    const double high = bounds.max_mm[2];
    check_count((high - low) / least + 2, memory_limit);
    const std::int32_t lowest = to_even_grid(low, unit_mm_);
    const std::int32_t highest = to_even_grid(high, unit_mm_);
    Generator generator(random.seed);
    double above = 0;  // the sum of the steps, so that heights do not depend on where the mesh stands
    for (;;) {
        above += least + (most - least) * generator.next();
        if (low + above > high) {
            break;
        }
        const std::int32_t z = round_height(low + above);
        if (z > lowest && z < highest) {
            heights_mm_.push_back(low + above);
        }
    }
    fill_from_heights();
    check_distinct();
    make_table();
}

/// Heights far outside the grid cut nothing and only keep their order: they get consecutive values at its ends.
void PlaneSet::fill_from_heights() {
    count_ = static_cast<PlaneIndex>(heights_mm_.size());
    padded_.resize_discarding(heights_mm_.size() + 2);
    padded_[0] = below_all;
    for (PlaneIndex i = 0; i < count_; ++i) {
        const double mm = heights_mm_[i];
        if (within_reach(mm)) {
            padded_[i + 1] = round_height(mm);
        } else {
            padded_[i + 1] = mm < 0 ? below_all + 3 + 2 * static_cast<std::int32_t>(i)
                                    : above_all - 2 - 2 * static_cast<std::int32_t>(count_ - 1 - i);
        }
    }
    padded_[count_ + 1] = above_all;
}

void PlaneSet::make_table() {
    if (count_ == 0) {
        first_z_ = last_guess_ = 0;
        table_.first.set_size(0);
        return;
    }
    first_z_ = z(0);
    last_guess_ = static_cast<double>(count_ - 1);
    table_.lowest = z(0);
    table_.highest = z(count_ - 1);
    const auto span = static_cast<std::uint64_t>(std::int64_t{table_.highest} - table_.lowest) + 1;
    table_.shift = 0;
    while ((span >> table_.shift) > 4 * static_cast<std::uint64_t>(count_)) {
        ++table_.shift;
    }
    const std::size_t cells = table_.cell(table_.highest) + 1;
    table_.first.resize_discarding(cells + 1);
    // From the highest plane down: a plane's cell gets the lowest plane in it, the empty cells below it the same plane.
    std::size_t open = cells + 1;
    for (PlaneIndex plane = count_; plane-- > 0;) {
        const std::size_t cell = table_.cell(z(plane));
        for (; open > cell + 1; --open) {
            table_.first[open - 1] = plane + 1;
        }
        table_.first[cell] = plane;
    }
}

PlaneIndex PlaneSet::by_table(std::int32_t z) const noexcept {
    if (count_ == 0) {
        return 0;
    }
    const std::int32_t* plane = padded_.data() + 1;
    const std::size_t cell = table_.cell(z);
    PlaneIndex low = table_.first[cell];
    low += plane[low] < z ? 1 : 0;  // no branch: it would be unpredictable
    low += plane[low] < z ? 1 : 0;
    if (plane[low] > z) {
        return low;
    }
    PlaneIndex length = table_.first[cell + 1] - low;
    // Invariant: the answer lies in [low, low + length].
    while (length > 0) {
        const PlaneIndex half = length / 2;
        const bool above = plane[low + half] < z;
        low = above ? low + half + 1 : low;
        length = above ? length - half - 1 : half;
    }
    return low;
}

double PlaneSet::bottom_mm(PlaneIndex i) const noexcept {
    if (!slabs_.empty()) {
        return slabs_[first_kept_ + i].bottom_mm;
    }
    if (heights_mm_.empty()) {
        return height_mm(i) - layer_height_mm_ / 2;
    }
    const std::size_t at = first_kept_ + std::size_t{i};
    const double here = heights_mm_[at];
    if (at > 0) {
        return (heights_mm_[at - 1] + here) / 2;
    }
    return planned_ > 1 ? here - (heights_mm_[1] - here) / 2 : here;
}

double PlaneSet::top_mm(PlaneIndex i) const noexcept {
    if (!slabs_.empty()) {
        return slabs_[first_kept_ + i].top_mm;
    }
    if (heights_mm_.empty()) {
        return height_mm(i) + layer_height_mm_ / 2;
    }
    const std::size_t at = first_kept_ + std::size_t{i};
    const double here = heights_mm_[at];
    if (at + 1 < planned_) {
        return (here + heights_mm_[at + 1]) / 2;
    }
    return at > 0 ? here + (here - heights_mm_[at - 1]) / 2 : here;
}

}  // namespace lamella
