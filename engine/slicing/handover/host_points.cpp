#include "slicing/handover/host_points.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

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

Error refusal(std::string message) {
    return {ErrorCode::invalid_argument, std::move(message)};
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

Status check_array(const void* array, std::uint64_t capacity, std::string_view what) {
    if (array == nullptr && capacity > 0) {
        return refusal("there is no memory for " + std::string(what) + ", but a capacity of " + std::to_string(capacity));
    }
    return {};
}

}  // namespace

std::size_t point_bytes(PointType type) noexcept {
    return 2 * facts_of(type).bytes;
}

Status check_host(const HostOutput& output) {
    if (static_cast<std::size_t>(output.type) >= type_facts.size()) {
        return refusal("there is no such type of points");
    }
    if (output.stride != 0 && output.stride < point_bytes(output.type)) {
        return refusal("a stride of " + counted(output.stride, "byte") + " is too short for points of " +
                       std::string(facts_of(output.type).name) + ", which take " + std::to_string(point_bytes(output.type)));
    }
    const bool in_range = is_integer(output.type)
                              ? output.scale >= 1 && output.scale <= most_scale && output.scale == std::floor(output.scale)
                              : output.scale > 0 && std::isfinite(output.scale);
    if (!in_range) {
        return refusal("the scale of points of " + std::string(facts_of(output.type).name) + " must be " +
                       (is_integer(output.type) ? "a whole number from 1 to 2^53" : "finite and above 0") + ", not " +
                       exact_text(output.scale));
    }
    for (const Status& status : {check_array(output.points, output.point_capacity, "points"),
                                 check_array(output.contours, output.contour_capacity, "contours"),
                                 check_array(output.layers, output.layer_capacity, "layers"),
                                 check_array(output.closed_gaps, output.closed_gap_capacity, "closed gaps")}) {
        if (!status) {
            return status;
        }
    }
    return {};
}

Status check_scale(const HostOutput& output, double farthest) {
    if (farthest * output.scale > facts_of(output.type).most) {
        return refusal("coordinates up to " + exact_text(farthest) + " grid units times a scale of " +
                       exact_text(output.scale) + " do not fit " + std::string(facts_of(output.type).name));
    }
    return {};
}

bool is_plain(const HostOutput& output) noexcept {
    return output.type == PointType::i32 && output.scale == 1 && (output.stride == 0 || output.stride == sizeof(Point)) &&
           reinterpret_cast<std::uintptr_t>(output.points) % alignof(Point) == 0;
}

HostPoints::HostPoints(const HostOutput& output) noexcept
    : output_(output), stride_(output.stride == 0 ? point_bytes(output.type) : output.stride) {
    constexpr std::array<Convert, 4> by_type = {convert<std::int32_t>, convert<std::int64_t>, convert<float>,
                                                convert<double>};
    convert_ = by_type[static_cast<std::size_t>(output.type)];
}

void HostPoints::write(std::uint64_t first, std::span<const Point> points) const noexcept {
    convert_(points, output_.scale, static_cast<std::byte*>(output_.points) + first * stride_, stride_);
}

}  // namespace lamella
