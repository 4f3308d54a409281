#include "slicing/handover/sink_target.hpp"

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
#include "slicing/regions/rules.hpp"

namespace lamella {

namespace {

constexpr double most_scale = 9007199254740992;  // 2^53: doubles hold every whole number up to it

struct TypeFacts {
    std::string_view name;
    double most;
};

/// By Number; a point of unsigned numbers is none.
constexpr std::array<TypeFacts, 4> type_facts = {{{"32-bit floats", std::numeric_limits<float>::max()},
                                                  {"64-bit floats", std::numeric_limits<double>::max()},
                                                  {"32-bit integers", 2147483647.0},
                                                  {"64-bit integers", 9223372036854774784.0}}};

const TypeFacts& facts_of(Number type) noexcept {
    return type_facts[static_cast<std::size_t>(type)];
}

bool is_integer(Number type) noexcept {
    return type == Number::i32 || type == Number::i64;
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

/// Bytes of x and y.
std::size_t point_bytes(Number type) noexcept {
    return 2 * size_of(type);
}

/// Refuses arrays and scales that make no sense; returns the others.
const HostArrays& checked(const HostArrays& output) {
    if (static_cast<std::size_t>(output.point_type) >= type_facts.size()) {
        refuse("there is no such type of points");
    }
    if (output.point_stride != 0 && output.point_stride < point_bytes(output.point_type)) {
        refuse("a stride of " + counted(output.point_stride, "byte") + " is too short for points of " +
               std::string(facts_of(output.point_type).name) + ", which take " +
               std::to_string(point_bytes(output.point_type)));
    }
    const bool in_range = is_integer(output.point_type)
                              ? output.scale >= 1 && output.scale <= most_scale && output.scale == std::floor(output.scale)
                              : output.scale > 0 && std::isfinite(output.scale);
    if (!in_range) {
        refuse("the scale of points of " + std::string(facts_of(output.point_type).name) + " must be " +
               (is_integer(output.point_type) ? "a whole number from 1 to 2^53" : "finite and above 0") + ", not " +
               exact_text(output.scale));
    }
    const auto check_array = [](const void* array, std::uint64_t capacity, const char* what) {
        if (array == nullptr && capacity > 0) {
            refuse("there is no memory for " + std::string(what) + ", but a capacity of " + std::to_string(capacity));
        }
    };
    check_array(output.points, output.point_capacity, "points");
    check_array(output.contours.data(), output.contours.size(), "contours");
    check_array(output.layers.data(), output.layers.size(), "layers");
    check_array(output.stitches.data(), output.stitches.size(), "stitches");
    check_array(output.origins.data(), output.origins.size(), "origins");
    if (!output.origins.empty() && output.origins.size() < output.point_capacity) {
        refuse("there is memory for " + counted(output.origins.size(), "origin") + ", but for " +
               counted(output.point_capacity, "point"));
    }
    return output;
}

/// Refuses a scale by which a coordinate of at most `farthest` grid units may exceed the type.
void check_scale(const HostArrays& output, double farthest) {
    if (farthest * output.scale > facts_of(output.point_type).most) {
        refuse("coordinates up to " + exact_text(farthest) + " grid units times a scale of " + exact_text(output.scale) +
               " do not fit " + std::string(facts_of(output.point_type).name));
    }
}

/// True where the points are those of the grid as they are in memory.
bool is_plain(const HostArrays& output) noexcept {
    return output.point_type == Number::i32 && output.scale == 1 &&
           (output.point_stride == 0 || output.point_stride == sizeof(Point)) &&
           reinterpret_cast<std::uintptr_t>(output.points) % alignof(Point) == 0;
}

/// A bound on the coordinates of contours, in grid units.
double farthest_units(const SliceInfo& info) noexcept {
    double farthest_mm = 0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        farthest_mm = std::max({farthest_mm, std::abs(info.box.min_mm[axis]), std::abs(info.box.max_mm[axis])});
    }
    // Vertices are rounded by a unit at most, points of regions by another. Miters reach as far as check_reach() says.
    const double moved = moved_mm(info.options.region);
    return std::min(std::ceil((farthest_mm + moved) / info.grid_mm) + 2, double{grid_limit});
}

}  // namespace

HostTarget::HostTarget(const HostArrays& host)
    : host_(checked(host)), stride_(host.point_stride == 0 ? point_bytes(host.point_type) : host.point_stride) {}

void HostTarget::admit_layers(std::uint64_t layers, const SliceInfo& info) {
    layers_ = std::max(layers_, layers);
    if (layers > host_.layers.size()) {
        refuse(
            "the slice has " + counted(layers, "layer") + ", but there is memory for " + std::to_string(host_.layers.size()),
            ErrorCode::result_too_large);
    }
    check_scale(host_, farthest_units(info));
}

void HostTarget::begin(const OutputPlan& plan) {
    std::span<Point> straight;
    if (is_plain(host_)) {
        straight = detail::span_of(static_cast<Point*>(host_.points), host_.point_capacity);
    }
    const bool origins = plan.origins && !host_.origins.empty();
    begin_placing(plan, straight, host_.origins.first(origins ? host_.point_capacity : 0), origins, false);
}

void HostTarget::write(std::uint64_t first, std::span<const Point> points) const noexcept {
    constexpr std::array convert_to = {convert<float>, convert<double>, convert<std::int32_t>, convert<std::int64_t>};
    convert_to[static_cast<std::size_t>(host_.point_type)](points, host_.scale,
                                                           static_cast<std::byte*>(host_.points) + first * stride_, stride_);
}

/// Where there is too little room, nothing more is written, and all is counted before the slice is refused.
void HostTarget::finish() {
    const std::uint64_t stitches = host_.stitches.empty() ? 0 : all_.stitches;
    if (all_.points <= host_.point_capacity && all_.contours <= host_.contours.size() && stitches <= host_.stitches.size()) {
        write_layers(host_.layers, host_.contours, host_.stitches.first(stitches));
    } else if (plan_->first_index + plan_->layers == layers_) {
        refuse("the slice has " + counted(all_.contours, "contour") + ", " + counted(all_.points, "point") + " and " +
                   counted(all_.stitches, "stitch", "stitches") + ", but there is memory for " +
                   std::to_string(host_.contours.size()) + ", " + std::to_string(host_.point_capacity) + " and " +
                   std::to_string(host_.stitches.size()),
               ErrorCode::result_too_large);
    }
}

}  // namespace lamella
