// Every source and every destination of a slice: what each gets is compared field by field with a result.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/slicing.hpp"

inline auto facts_of(const lamella::Layer& layer) {
    return std::tuple(layer.bottom_mm, layer.plane_mm, layer.top_mm, layer.contour_count, layer.segments, layer.plane);
}
/// Of a SliceInfo or a lamella_info.
template <class Info>
auto counters_of(const Info& info) {
    return std::array{
#define COUNTER(name) info.name,
#include "options/counters.inc"
    };
}
inline auto facts_of(const lamella::SliceInfo& info) {
    return std::tuple(counters_of(info), info.box, info.grid_mm, info.options.frame.transform, info.options.stitch_mm);
}

/// For points, contours and origins, which have no byte between their members.
template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    static_assert(sizeof(lamella::Contour) == 48 && sizeof(lamella::Point) == 8 && sizeof(lamella::PointOrigin) == 8);
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// The same layer, though indices may count from another place.
inline bool is_same(const lamella::LayerView& a, const lamella::LayerView& b) {
    const auto rebased = [](lamella::Contour contour, const lamella::LayerView& layer) {
        contour.first_point -= layer.first_point;
        contour.parent -= contour.parent < 0 ? 0 : static_cast<std::int64_t>(layer.first_contour);
        return contour;
    };
    const auto same_contour = [&](const lamella::Contour& x, const lamella::Contour& y) {
        const lamella::Contour both[] = {rebased(x, a), rebased(y, b)};
        return std::memcmp(both, both + 1, sizeof *both) == 0;
    };
    const auto same_stitch = [&](const lamella::Stitch& x, const lamella::Stitch& y) {
        return x.layer - a.index == y.layer - b.index && x.from == y.from && x.to == y.to;
    };
    const double areas[] = {a.area_mm2(), b.area_mm2()};  // which may be NaN
    return facts_of(a) == facts_of(b) && std::memcmp(areas, areas + 1, sizeof *areas) == 0 &&
           same_bytes(a.points, b.points) && same_bytes(a.origins, b.origins) &&
           std::equal(a.contours.begin(), a.contours.end(), b.contours.begin(), b.contours.end(), same_contour) &&
           std::equal(a.stitches.begin(), a.stitches.end(), b.stitches.begin(), b.stitches.end(), same_stitch);
}

inline void require_same(const lamella::SliceInfo& found, const lamella::SliceInfo& expected) {
    REQUIRE((facts_of(found) == facts_of(expected)));
    REQUIRE(found.layer_of == expected.layer_of);
}
inline void require_same(const lamella::SliceResult& found, const lamella::SliceResult& expected) {
    REQUIRE(same_bytes(found.contours.span(), expected.contours.span()));
    REQUIRE(found.stitches.size() == expected.stitches.size());
    REQUIRE(std::equal(found.begin(), found.end(), expected.begin(), expected.end(), is_same));
    require_same(found.info, expected.info);
}

/// A sink that compares each layer that it gets with that of a result, or of its layers from `first` on.
class ComparedLayers {
public:
    explicit ComparedLayers(const lamella::SliceResult& expected, std::size_t first = 0)
        : expected_(expected), first_(first), taken_(expected.size() - first) {}

    void operator()(const lamella::LayerView& found) noexcept {
        if (found.index >= taken_.size() || !is_same(found, expected_[first_ + found.index])) {
            same_ = false;
        } else {
            taken_[found.index].fetch_add(1);
        }
    }

    /// Requires each of the first `layers` once.
    void require_all(std::uint64_t layers) const {
        REQUIRE(same_);
        REQUIRE(static_cast<std::uint64_t>(std::count(taken_.begin(), taken_.end(), 1)) == layers);
        REQUIRE(std::all_of(taken_.begin(), taken_.begin() + static_cast<std::ptrdiff_t>(layers),
                            [](const auto& times) { return times == 1; }));
    }

private:
    const lamella::SliceResult& expected_;
    std::size_t first_;
    std::atomic<bool> same_{true};
    std::vector<std::atomic<int>> taken_;
};

struct ArraySizes {
    std::uint64_t points = 0;
    std::uint64_t contours = 0;
    std::uint64_t layers = 0;
    std::uint64_t stitches = 0;
    bool origins = false;
};
struct PointForm {
    lamella::Number type = lamella::Number::i32;
    std::size_t stride = 0;
    double scale = 1;
    std::size_t offset = 0;  ///< of the first point
};

/// Room for some objects, followed by bytes that nobody may touch.
class Guarded {
public:
    explicit Guarded(std::size_t size) : bytes_(size + guard, canary) {}

    std::byte* data() { return bytes_.data(); }
    const std::byte* data() const { return bytes_.data(); }
    template <class T>
    std::span<T> room() {
        return {reinterpret_cast<T*>(bytes_.data()), (bytes_.size() - guard) / sizeof(T)};
    }
    bool is_untouched(std::size_t from, std::size_t count) const {
        const std::byte* const begin = bytes_.data() + from;
        return std::all_of(begin, begin + count, [](std::byte byte) { return byte == canary; });
    }
    bool guard_stands() const { return is_untouched(bytes_.size() - guard, guard); }

private:
    static constexpr std::size_t guard = 256;
    static constexpr std::byte canary{0xA5};
    std::vector<std::byte> bytes_;
};

/// A host's arrays.
class GuardedArrays {
public:
    explicit GuardedArrays(const ArraySizes& sizes, const PointForm& form = {})
        : form_(form),
          stride_(form.stride == 0 ? 2 * size_of(form.type) : form.stride),
          points_(form.offset + sizes.points * stride_),
          contours_(sizes.contours * sizeof(lamella::Contour)),
          layers_(sizes.layers * sizeof(lamella::Layer)),
          stitches_(sizes.stitches * sizeof(lamella::Stitch)),
          origins_((sizes.origins ? sizes.points : 0) * sizeof(lamella::PointOrigin)),
          arrays{.points = points_.data() + form.offset,
                 .point_capacity = sizes.points,
                 .point_type = form.type,
                 .point_stride = form.stride,
                 .scale = form.scale,
                 .contours = contours_.room<lamella::Contour>(),
                 .layers = layers_.room<lamella::Layer>(),
                 .stitches = stitches_.room<lamella::Stitch>(),
                 .origins = origins_.room<lamella::PointOrigin>()} {}
    /// Just as large as a result needs.
    explicit GuardedArrays(const lamella::SliceResult& result, const PointForm& form = {})
        : GuardedArrays({result.points.size(), result.contours.size(), result.layers.size(), result.stitches.size(),
                         !result.origins.empty()},
                        form) {}

    /// True where no byte beyond a capacity, nor between two points, has changed.
    bool guards_stand() const {
        bool stand = points_.is_untouched(0, form_.offset);
        const std::size_t size = 2 * size_of(form_.type);
        for (std::uint64_t p = 0; p < arrays.point_capacity && stride_ > size; ++p) {
            stand = stand && points_.is_untouched(form_.offset + p * stride_ + size, stride_ - size);
        }
        const Guarded* const all[] = {&points_, &contours_, &layers_, &stitches_, &origins_};
        return stand && std::all_of(std::begin(all), std::end(all), [](const auto* own) { return own->guard_stands(); });
    }

    /// Requires the slice in them to be `expected`, and nothing else to be touched.
    void require_hold(const lamella::SliceResult& expected) const {
        REQUIRE(arrays.layers.size() >= expected.layers.size());
        REQUIRE(std::equal(expected.layers.begin(), expected.layers.end(), arrays.layers.begin(),
                           [](const lamella::Layer& a, const lamella::Layer& b) {
                               return facts_of(a) == facts_of(b) && a.first_contour == b.first_contour;
                           }));
        REQUIRE(same_bytes<lamella::Contour>(arrays.contours.first(expected.contours.size()), expected.contours));
        REQUIRE((arrays.stitches.empty() ||
                 std::equal(expected.stitches.begin(), expected.stitches.end(), arrays.stitches.begin(),
                            [](const lamella::Stitch& a, const lamella::Stitch& b) {
                                return std::tuple(a.layer, a.from, a.to) == std::tuple(b.layer, b.from, b.to);
                            })));
        REQUIRE((arrays.origins.empty() ||
                 same_bytes<lamella::PointOrigin>(arrays.origins.first(expected.origins.size()), expected.origins)));
        const std::span<const lamella::Point> points = expected.points;
        REQUIRE((form_.type == lamella::Number::i32   ? has_points_as<std::int32_t>(points)
                 : form_.type == lamella::Number::i64 ? has_points_as<std::int64_t>(points)
                 : form_.type == lamella::Number::f32 ? has_points_as<float>(points)
                                                      : has_points_as<double>(points)));
        REQUIRE(guards_stand());
    }

private:
    template <class T>
    bool has_points_as(std::span<const lamella::Point> points) const {
        using Factor = std::conditional_t<std::is_integral_v<T>, std::int64_t, double>;
        const auto factor = static_cast<Factor>(form_.scale);
        const auto is_written = [&, at = points_.data() + form_.offset](const lamella::Point& p) mutable {
            std::array<T, 2> xy;
            std::memcpy(xy.data(), std::exchange(at, at + stride_), sizeof xy);
            return xy == std::array<T, 2>{static_cast<T>(p.x * factor), static_cast<T>(p.y * factor)};
        };
        return std::all_of(points.begin(), points.end(), is_written);
    }

    PointForm form_;
    std::size_t stride_;
    Guarded points_;
    Guarded contours_;
    Guarded layers_;
    Guarded stitches_;
    Guarded origins_;

public:
    lamella::HostArrays arrays;
};

/// Requires that every destination gets `expected`. A Slicer serves one after the other.
inline void require_at_every_destination(const lamella::SliceResult& expected, const lamella::Source& source,
                                         const lamella::SliceOptions& options, const Way& way = {},
                                         const PointForm& form = {.type = lamella::Number::f64}) {
    lamella::Slicer slicer;
    const auto slice = [&](const lamella::Destination& to) {
        return value_of(slice_tuned(slicer, to, source, options, way.tuning, way.context));
    };
    lamella::SliceResult result;
    require_same(slice(result), expected.info);
    require_same(result, expected);
    for (const lamella::SinkOrder order : {lamella::SinkOrder::any, lamella::SinkOrder::ascending}) {
        INFO("to a sink, ascending " << (order == lamella::SinkOrder::ascending));
        ComparedLayers compared(expected);
        require_same(slice(lamella::LayerSink{.take = compared, .order = order}), expected.info);
        compared.require_all(expected.size());
    }
    for (const PointForm& own : {PointForm{}, form}) {
        INFO("to arrays of type " << static_cast<int>(own.type) << ", stride " << own.stride << ", scale " << own.scale);
        GuardedArrays host(expected, own);
        require_same(slice(host.arrays), expected.info);
        host.require_hold(expected);
    }
}
