// measure(), as the list of its stages:
//
//     box        of the layer's closed contours; what is summed is taken about its middle
//     sum        each contour, then islands to the layer
//     finish     sums about the centroid, exactly; then, in doubles, what is reported

#include "lamella/measures.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/measures/angle.hpp"
#include "slicing/measures/double_double.hpp"
#include "slicing/measures/feret.hpp"
#include "slicing/measures/moments.hpp"
#include "slicing/slicer.hpp"

namespace lamella {

namespace {

/// What contours of a layer or an island sum up to, about the layer's middle.
struct SectionSums {
    Moments all;
    Word128 outer_twice_area = 0;
    double outer_length = 0;
    FlatBox box = FlatBox::nothing();
    std::int32_t islands = 0;
    std::int32_t holes = 0;

    void add(const SectionSums& other) noexcept {
        all.add(other.all);
        outer_twice_area += other.outer_twice_area;
        outer_length += other.outer_length;
        box.include(other.box);
        islands += other.islands;
        holes += other.holes;
    }
};

/// An axis of inertia: moments in units of the grid, and a direction along it.
struct Axes {
    double least = 0;
    double most = 0;
    double angle_rad = SectionMeasures::unknown;
};

/// `ix`, `iy`, `ixy`: about the centroid. The difference that makes the least moment is taken of twice the digits, as that
/// of a needle loses half of them.
Axes axes_of(DoubleDouble ix, DoubleDouble iy, DoubleDouble ixy, bool all_alike) noexcept {
    const auto cross = static_cast<double>(DoubleDouble(2.0) * ixy);
    const auto difference = static_cast<double>(iy - ix);
    const double across = std::sqrt(cross * cross + difference * difference);
    Axes axes;
    axes.most = (static_cast<double>(ix + iy) + across) / 2;
    axes.least = static_cast<double>((ix * iy - ixy * ixy) / DoubleDouble(axes.most));
    if (!all_alike) {  // a direction of half the angle of (difference, cross)
        axes.angle_rad = difference >= 0
                             ? angle_of_line(across + difference, cross)
                             : angle_of_line(std::abs(cross), cross < 0 ? difference - across : across - difference);
    }
    return axes;
}

/// Writes centroid, moments and angle. `box`: about the middle that the moments are about.
void finish_moments(const Moments& sums, const FlatBox& box, Point middle, double grid_mm, SectionMeasures& row) noexcept {
    const auto twice_area = static_cast<Int128>(sums.twice_area);
    const auto six_x = static_cast<Int128>(sums.six_x);
    const auto six_y = static_cast<Int128>(sums.six_y);
    const Int128 limit = Int128{3} * twice_area;
    // Within the box: |quotient| < 2^31.
    const bool has_centre = twice_area > 0 && six_x >= limit * box.low.x && six_x <= limit * box.high.x &&
                            six_y >= limit * box.low.y && six_y <= limit * box.high.y;
    if (!has_centre) {
        for (double* const moment : {&row.ix_mm4, &row.iy_mm4, &row.ixy_mm4, &row.imin_mm4, &row.imax_mm4, &row.polar_mm4}) {
            *moment = SectionMeasures::unknown;
        }
        return;
    }
    const auto p = static_cast<std::int64_t>(six_x / limit);
    const auto q = static_cast<std::int64_t>(six_y / limit);
    const Moments own = sums.moved(p, q);
    const DoubleDouble area2(twice_area);
    const DoubleDouble x6(static_cast<Int128>(own.six_x));
    const DoubleDouble y6(static_cast<Int128>(own.six_y));
    row.centroid_mm = {(static_cast<double>(middle.x + p) + static_cast<double>(x6 / (area2 * 3.0))) * grid_mm,
                       (static_cast<double>(middle.y + q) + static_cast<double>(y6 / (area2 * 3.0))) * grid_mm};
    // From (p, q) to the centroid, less than a unit farther: 12 ix = yy - 2/3 y6^2 / area2, and so on.
    const DoubleDouble ix = (DoubleDouble(static_cast<Int128>(own.twelve_yy)) - y6 * y6 * 2.0 / (area2 * 3.0)) / 12.0;
    const DoubleDouble iy = (DoubleDouble(static_cast<Int128>(own.twelve_xx)) - x6 * x6 * 2.0 / (area2 * 3.0)) / 12.0;
    const DoubleDouble ixy = (DoubleDouble(static_cast<Int128>(own.twenty_four_xy)) - x6 * y6 * 4.0 / (area2 * 3.0)) / 24.0;
    // Exactly: equal but for a multiple of 2^128, and so near that this is 0.
    const bool is_round = std::abs(static_cast<double>(ix - iy)) <= 0x1p-80 * static_cast<double>(ix + iy) &&
                          std::abs(static_cast<double>(ixy)) <= 0x1p-80 * static_cast<double>(ix + iy) &&
                          Word128{3} * sums.twice_area * (own.twelve_xx - own.twelve_yy) ==
                              Word128{2} * (own.six_x * own.six_x - own.six_y * own.six_y) &&
                          Word128{3} * sums.twice_area * own.twenty_four_xy == Word128{4} * own.six_x * own.six_y;
    const Axes axes = axes_of(ix, iy, ixy, is_round);
    const double mm4 = grid_mm * grid_mm * grid_mm * grid_mm;
    row.ix_mm4 = static_cast<double>(ix) * mm4;
    row.iy_mm4 = static_cast<double>(iy) * mm4;
    row.ixy_mm4 = static_cast<double>(ixy) * mm4;
    row.imin_mm4 = axes.least * mm4;
    row.imax_mm4 = axes.most * mm4;
    row.polar_mm4 = static_cast<double>(ix + iy) * mm4;
    row.angle_rad = axes.angle_rad;
}

/// The layers of a thread.
class SectionMeasuring {
public:
    SectionMeasuring(bool feret, Worker& worker)
        : feret_(feret), worker_(worker), rings_(worker.memory()), boxes_(worker.memory()) {}

    /// Fills `islands` where it is not null. Throws Refused.
    SectionMeasures measure(const LayerView& layer, SectionMeasures* islands);

private:
    void begin(const LayerView& layer);
    void add_contour(const LayerView& layer, const Contour& contour, SectionSums& sums);
    /// `first_ring`: of the outers among them.
    SectionMeasures row_of(const LayerView& layer, const SectionSums& sums, std::size_t first_ring);
    void require_fits(const LayerView& layer, const SectionSums& sums) const;

    const bool feret_;
    Worker& worker_;
    std::int32_t open_ = 0;
    Vector<std::span<const Point>> rings_;  ///< outers
    Vector<FlatBox> boxes_;                 ///< of each contour
    Point middle_;
    double reach_ = 0;  ///< largest coordinate about the middle
};

void SectionMeasuring::begin(const LayerView& layer) {
    rings_.clear();
    boxes_.clear();
    open_ = 0;
    FlatBox box = FlatBox::nothing();
    for (const Contour& contour : layer.contours) {
        open_ += contour.role == Role::open ? 1 : 0;
        boxes_.push_back(contour.encloses_area() ? FlatBox::around(layer.points_of(contour)) : FlatBox::nothing());
        box.include(boxes_.back());
    }
    if (exceeds(box.low, box.high)) {
        return;  // there are none
    }
    require_on_grid(box, layer.index);
    middle_ = {box.low.x + static_cast<std::int32_t>(width_of(box) / 2),
               box.low.y + static_cast<std::int32_t>(height_of(box) / 2)};
    reach_ = static_cast<double>(std::max(width_of(box), height_of(box))) / 2 + 1;
}

void SectionMeasuring::add_contour(const LayerView& layer, const Contour& contour, SectionSums& sums) {
    const std::span<const Point> points = layer.points_of(contour);
    const double before = sums.all.length;
    sums.all.add(points, contour.twice_area, middle_);
    if (contour.role == Role::outer) {
        ++sums.islands;
        sums.outer_twice_area += static_cast<Word128>(to_int128(contour.twice_area));
        sums.outer_length += sums.all.length - before;
        sums.box.include(boxes_[static_cast<std::size_t>(&contour - layer.contours.data())]);
        rings_.push_back(points);
    } else {
        ++sums.holes;
    }
    worker_.spend(2 * points.size());
}

/// A winding number w at (x, y) takes an edge up and one down for each turn, so that the integrals of |w| x^2 and |w| y^2
/// are at most the length times the cube of the reach. Where that bound leaves 128 bits, sums of doubles tell.
void SectionMeasuring::require_fits(const LayerView& layer, const SectionSums& sums) const {
    constexpr double most = 0x1p126;
    if (24 * reach_ * reach_ * reach_ * sums.all.length < most) {
        return;
    }
    std::array<double, 3> found{};
    for (const Contour& contour : layer.contours) {
        std::array<double, 3> own{};
        if (const std::span<const Point> points = layer.points_of(contour); contour.encloses_area()) {
            Point a = points.back();
            for (const Point b : points) {
                const double ax = static_cast<double>(a.x) - middle_.x;
                const double ay = static_cast<double>(a.y) - middle_.y;
                const double bx = static_cast<double>(b.x) - middle_.x;
                const double by = static_cast<double>(b.y) - middle_.y;
                const double k = ax * by - ay * bx;
                own[0] += k * (ax * ax + ax * bx + bx * bx);
                own[1] += k * (ay * ay + ay * by + by * by);
                own[2] += k * (ax * (2 * ay + by) + bx * (2 * by + ay));
                a = b;
            }
        }
        for (std::size_t i = 0; i < found.size(); ++i) {
            found[i] += std::abs(own[i]);
        }
    }
    if (std::max({found[0], found[1], found[2]}) >= most) {
        throw Refused{{ErrorCode::invalid_argument,
                       "layer " + std::to_string(layer.index) +
                           ": its contours wind around so much that second moments exceed 128 bits; a fill rule helps"}};
    }
}

/// All that is not known.
void forget(SectionMeasures& row) noexcept {
    for (double* const sum :
         {&row.area_mm2, &row.outer_area_mm2, &row.perimeter_mm, &row.outer_perimeter_mm, &row.ix_mm4, &row.iy_mm4,
          &row.ixy_mm4, &row.imin_mm4, &row.imax_mm4, &row.polar_mm4, &row.equivalent_diameter_mm}) {
        *sum = SectionMeasures::unknown;
    }
    row.known = false;
}

SectionMeasures SectionMeasuring::row_of(const LayerView& layer, const SectionSums& sums, std::size_t first_ring) {
    const double grid_mm = layer.grid_mm;
    const auto area_of = [grid_mm](Word128 twice_area) {
        return static_cast<double>(static_cast<Int128>(twice_area)) / 2 * grid_mm * grid_mm;
    };
    SectionMeasures row;
    row.layer = layer.index;
    row.z_mm = layer.plane_mm;
    row.islands = sums.islands;
    row.holes = sums.holes;
    row.open = open_;
    if (open_ > 0) {
        forget(row);
        return row;
    }
    require_fits(layer, sums);
    row.area_mm2 = area_of(sums.all.twice_area);
    row.outer_area_mm2 = area_of(sums.outer_twice_area);
    row.perimeter_mm = sums.all.length * grid_mm;
    row.outer_perimeter_mm = sums.outer_length * grid_mm;
    row.equivalent_diameter_mm = std::sqrt(4 * row.area_mm2 / pi);
    if (sums.islands > 0) {
        const auto& [low, high] = sums.box;
        row.circularity = 4 * pi * row.outer_area_mm2 / (row.outer_perimeter_mm * row.outer_perimeter_mm);
        row.box_min_mm = {low.x * grid_mm, low.y * grid_mm};
        row.box_max_mm = {high.x * grid_mm, high.y * grid_mm};
        const FlatBox about = {{low.x - middle_.x, low.y - middle_.y}, {high.x - middle_.x, high.y - middle_.y}};
        finish_moments(sums.all, about, middle_, grid_mm, row);
    }
    if (feret_ && sums.islands > 0) {
        const Feret feret = find_feret(std::span(rings_).subspan(first_ring), worker_);
        row.feret_max_mm = feret.most * grid_mm;
        row.feret_min_mm = feret.least * grid_mm;
        row.feret_angle_rad = feret.angle_rad;
    }
    return row;
}

SectionMeasures SectionMeasuring::measure(const LayerView& layer, SectionMeasures* islands) {
    begin(layer);
    SectionSums whole;
    const Contour* const contours = layer.contours.data();
    for (std::size_t i = 0; i < layer.contours.size();) {
        const Contour& first = contours[i];
        const std::size_t first_ring = rings_.size();
        SectionSums island;  // an outer with the holes after it
        do {
            if (contours[i].encloses_area()) {
                add_contour(layer, contours[i], island);
            }
            ++i;
        } while (i < layer.contours.size() && contours[i].role == Role::hole);
        whole.add(island);
        if (islands != nullptr && first.role == Role::outer) {
            *islands = row_of(layer, island, first_ring);
            islands++->contour = static_cast<std::int64_t>(layer.first_contour) + (&first - contours);
        }
    }
    return row_of(layer, whole, 0);
}

std::size_t outers_of(std::span<const Contour> contours) {
    return static_cast<std::size_t>(
        std::count_if(contours.begin(), contours.end(), [](const Contour& contour) { return contour.role == Role::outer; }));
}

/// Where the islands of each layer begin among all. Throws Refused where rows exceed the limit.
Vector<std::size_t> first_islands(const SliceResult& result, bool islands, const Context& context) {
    Vector<std::size_t> first(result.size() + 1, 0, context.memory);
    for (std::size_t i = 0; i < result.size(); ++i) {
        first[i + 1] = first[i] + (islands ? outers_of(result.contours_of(result.layers[i])) : 0);
    }
    const std::uint64_t limit = detail::memory_limit(context.memory_limit_bytes);
    const std::uint64_t bytes = (result.size() + first.back()) * sizeof(SectionMeasures);
    if (bytes > limit) {
        throw Refused{{ErrorCode::result_too_large,
                       "measures of " + std::to_string(result.size()) + " layers and " + std::to_string(first.back()) +
                           " islands need more than the memory limit of " + std::to_string(limit) + " bytes"}};
    }
    return first;
}

}  // namespace

Result<Measures> measure(const SliceResult& result, const MeasureOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<Measures> {
        const Parallel parallel(context);
        const Vector<std::size_t> first = first_islands(result, options.islands, context);
        Measures found(context.memory);
        found.layers.resize_discarding(result.size());
        found.islands.resize_discarding(first.back());
        constexpr std::size_t enough_points = 1 << 14;  // for a thread to be woken for
        const std::size_t grain = 1 + result.size() * enough_points / (result.points.size() + 1);
        parallel.begin_stage(1);
        parallel.run_ranges(result.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            Worker worker(parallel.memory(), parallel.stop());
            SectionMeasuring measuring(options.feret, worker);
            for (std::size_t i = begin; i < end; ++i) {
                found.layers[i] = measuring.measure(result[i], options.islands ? found.islands.data() + first[i] : nullptr);
            }
        });
        parallel.finish();
        return found;
    });
}

Result<Measures> measure(const LayerView& layer, const MeasureOptions& options) noexcept {
    return guarded([&]() -> Result<Measures> {
        Worker worker;
        Measures found;
        found.layers.resize_discarding(1);
        found.islands.resize_discarding(options.islands ? outers_of(layer.contours) : 0);
        found.layers[0] =
            SectionMeasuring(options.feret, worker).measure(layer, options.islands ? found.islands.data() : nullptr);
        return found;
    });
}

}  // namespace lamella
