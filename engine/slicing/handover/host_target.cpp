#include "slicing/handover/host_target.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"

namespace lamella {

namespace {

constexpr double most_scale = 9007199254740992;  // 2^53: doubles hold every whole number up to it

struct TypeFacts {
    std::string_view name;
    std::size_t bytes;  ///< of a coordinate
    double most;
};

constexpr std::array<TypeFacts, 4> type_facts = {{{"32-bit integers", 4, 2147483647.0},
                                                  {"64-bit integers", 8, 9223372036854774784.0},
                                                  {"32-bit floats", 4, std::numeric_limits<float>::max()},
                                                  {"64-bit floats", 8, std::numeric_limits<double>::max()}}};

const TypeFacts& facts_of(PointType type) noexcept {
    return type_facts[static_cast<std::size_t>(type)];
}

bool is_integer(PointType type) noexcept {
    return type == PointType::i32 || type == PointType::i64;
}

[[noreturn]] void refuse(std::string message, ErrorCode code = ErrorCode::invalid_argument) {
    throw Refused{{code, std::move(message)}};
}

template <class T>
T scaled(std::int32_t units, double scale) noexcept {
    if constexpr (std::is_integral_v<T>) {
        return static_cast<T>(static_cast<std::int64_t>(units) * static_cast<std::int64_t>(scale));
    } else {
        return static_cast<T>(units * scale);
    }
}

/// `Stride` 0: as given. A stride that the compiler knows lets it use vectors.
template <class T, std::size_t Stride>
void convert_by(std::span<const Point> points, double scale, std::byte* to, std::size_t stride) noexcept {
    for (const Point& point : points) {
        const T xy[2] = {scaled<T>(point.x, scale), scaled<T>(point.y, scale)};
        std::memcpy(to, xy, sizeof xy);
        to += Stride == 0 ? stride : Stride;
    }
}

template <class T>
void convert(std::span<const Point> points, double scale, std::byte* to, std::size_t stride) noexcept {
    if (stride == 2 * sizeof(T)) {
        convert_by<T, 2 * sizeof(T)>(points, scale, to, stride);
    } else {
        convert_by<T, 0>(points, scale, to, stride);
    }
}

void check_array(const void* array, std::uint64_t capacity, std::string_view what) {
    if (array == nullptr && capacity > 0) {
        refuse("there is no memory for " + std::string(what) + ", but a capacity of " + std::to_string(capacity));
    }
}

/// Bytes of x and y.
std::size_t point_bytes(PointType type) noexcept {
    return 2 * facts_of(type).bytes;
}

/// Refuses arrays and scales that make no sense; returns the others.
const HostOutput& checked(const HostOutput& output) {
    if (static_cast<std::size_t>(output.type) >= type_facts.size()) {
        refuse("there is no such type of points");
    }
    if (output.stride != 0 && output.stride < point_bytes(output.type)) {
        refuse("a stride of " + counted(output.stride, "byte") + " is too short for points of " +
               std::string(facts_of(output.type).name) + ", which take " + std::to_string(point_bytes(output.type)));
    }
    const bool in_range = is_integer(output.type)
                              ? output.scale >= 1 && output.scale <= most_scale && output.scale == std::floor(output.scale)
                              : output.scale > 0 && std::isfinite(output.scale);
    if (!in_range) {
        refuse("the scale of points of " + std::string(facts_of(output.type).name) + " must be " +
               (is_integer(output.type) ? "a whole number from 1 to 2^53" : "finite and above 0") + ", not " +
               exact_text(output.scale));
    }
    check_array(output.points, output.point_capacity, "points");
    check_array(output.contours, output.contour_capacity, "contours");
    check_array(output.layers, output.layer_capacity, "layers");
    check_array(output.closed_gaps, output.closed_gap_capacity, "closed gaps");
    return output;
}

/// Refuses a scale by which a coordinate of at most `farthest` grid units may exceed the type.
void check_scale(const HostOutput& output, double farthest) {
    if (farthest * output.scale > facts_of(output.type).most) {
        refuse("coordinates up to " + exact_text(farthest) + " grid units times a scale of " + exact_text(output.scale) +
               " do not fit " + std::string(facts_of(output.type).name));
    }
}

/// True where the points are those of the grid as they are in memory.
bool is_plain(const HostOutput& output) noexcept {
    return output.type == PointType::i32 && output.scale == 1 && (output.stride == 0 || output.stride == sizeof(Point)) &&
           reinterpret_cast<std::uintptr_t>(output.points) % alignof(Point) == 0;
}

/// A bound on the coordinates of contours, in grid units.
double farthest_units(const SliceResult& result) noexcept {
    double farthest_mm = 0;
    for (int axis = 0; axis < 2; ++axis) {
        farthest_mm = std::max({farthest_mm, std::abs(result.summary.min_mm[axis]), std::abs(result.summary.max_mm[axis])});
    }
    // Vertices are rounded by a unit at most, points of regions by another. Miters reach as far as check_reach() says.
    const RegionRules& rules = result.region;
    const double reach_mm = std::max(2.0, rules.miter_limit) * (rules.close_mm + std::abs(rules.offset_mm));
    return std::min(std::ceil((farthest_mm + reach_mm) / result.unit_mm) + 2, double{grid_limit});
}

}  // namespace

HostPoints::HostPoints(const HostOutput& output) noexcept
    : output_(output), stride_(output.stride == 0 ? point_bytes(output.type) : output.stride) {
    constexpr std::array<Convert, 4> by_type = {convert<std::int32_t>, convert<std::int64_t>, convert<float>,
                                                convert<double>};
    convert_ = by_type[static_cast<std::size_t>(output.type)];
}

void HostPoints::write(std::uint64_t first, std::span<const Point> points) const noexcept {
    convert_(points, output_.scale, static_cast<std::byte*>(output_.points) + first * stride_, stride_);
}

HostTarget::HostTarget(const HostOutput& host) : host_(checked(host)), writer_(host) {}

void HostTarget::admit(const SweepInput& input, std::uint64_t /*memory_limit*/) {
    if (input.planes.size() > host_.layer_capacity) {
        refuse("the slice has " + counted(input.planes.size(), "layer") + ", but there is memory for " +
                   std::to_string(host_.layer_capacity),
               ErrorCode::result_too_large);
    }
    check_scale(host_, farthest_units(input.result));
}

BandTarget& HostTarget::begin(const SweepInput& input) {
    PointRoom room;
    if (!is_plain(host_)) {
        room.writer = &writer_;
    } else if (host_.point_capacity > 0) {
        room.points = {static_cast<Point*>(host_.points), host_.point_capacity};
    }
    if (input.origins && host_.origins != nullptr) {
        room.origins = {host_.origins, host_.point_capacity};
    }
    input.scratch.placement.begin(input.bands, input.lead(), room, input.parallel.stop());
    return input.scratch.placement;
}

void HostTarget::finish(const SweepInput& input) {
    const Placement& placement = input.scratch.placement;
    check_room(placement);
    const std::span<Layer> layers(host_.layers, input.planes.size());
    fill_layers(input, layers);
    placement.write_contours(input.parallel, {host_.contours, placement.contour_count()}, layers);
    if (host_.closed_gaps != nullptr) {
        placement.write_closed_gaps({host_.closed_gaps, placement.closed_gap_count()}, input.parallel.stop());
    }
    set_counts(placement.contour_counts(), input.result.region.keeps_contours() ? 0 : count_emptied(layers),
               input.result.summary);
    layers_ = layers.size();
    contours_ = placement.contour_count();
    points_ = placement.point_count();
    closed_gaps_ = placement.closed_gap_count();
}

void HostTarget::check_room(const Placement& placement) const {
    const std::uint64_t gaps = host_.closed_gaps == nullptr ? 0 : placement.closed_gap_count();
    if (placement.point_count() > host_.point_capacity || placement.contour_count() > host_.contour_capacity ||
        gaps > host_.closed_gap_capacity) {
        refuse("the slice has " + counted(placement.contour_count(), "contour") + ", " +
                   counted(placement.point_count(), "point") + " and " +
                   counted(placement.closed_gap_count(), "closed gap") + ", but there is memory for " +
                   std::to_string(host_.contour_capacity) + ", " + std::to_string(host_.point_capacity) + " and " +
                   std::to_string(host_.closed_gap_capacity),
               ErrorCode::result_too_large);
    }
}

SliceTotals HostTarget::totals(SliceResult& result) const {
    return {layers_,
            contours_,
            points_,
            closed_gaps_,
            result.unit_mm,
            result.close_gaps_mm,
            result.first_layer,
            result.all_layers,
            std::move(result.layer_of),
            result.summary};
}

}  // namespace lamella
