// Every source and every destination of a slice: what each gets is compared as a result.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/same_result.hpp"
#include "engine/slicing.hpp"

/// A sink that compares each layer that it gets with that of a result.
class ComparedLayers {
public:
    explicit ComparedLayers(const lamella::SliceResult& expected) : expected_(expected), taken_(expected.size()) {}

    void operator()(const lamella::LayerView& found) noexcept {
        const bool known = found.index < expected_.size();
        if (!known || !is_same(found, expected_[found.index])) {
            same_ = false;
        }
        taken_[known ? found.index : 0].fetch_add(1);
    }

    /// Requires each layer once. `info` is what the slice returned.
    void require_all(const lamella::SliceInfo& info) const {
        REQUIRE(same_);
        REQUIRE(std::all_of(taken_.begin(), taken_.end(), [](const auto& times) { return times == 1; }));
        require_same(info, expected_.info);
    }

private:
    static bool is_same(const lamella::LayerView& found, const lamella::LayerView& expected) {
        const auto same_contour = [&](lamella::Contour own, const lamella::Contour& other) {
            own.first_point += expected.first_point;
            own.parent += own.parent < 0 ? 0 : static_cast<std::int64_t>(expected.first_contour);
            return std::memcmp(&own, &other, sizeof own) == 0;
        };
        const double areas[] = {found.area_mm2(), expected.area_mm2()};
        lamella::Layer layer = found;
        layer.first_contour += expected.first_contour;  // in a sink 0
        return facts_of(layer) == facts_of(expected) && same_bytes(found.points, expected.points) &&
               std::equal(found.contours.begin(), found.contours.end(), expected.contours.begin(), expected.contours.end(),
                          same_contour) &&
               same_bytes(found.origins, expected.origins) && same_facts(found.stitches, expected.stitches) &&
               std::memcmp(areas, areas + 1, sizeof *areas) == 0;
    }

    const lamella::SliceResult& expected_;
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

/// A host's arrays, each followed by bytes that nobody may touch.
class GuardedArrays {
public:
    explicit GuardedArrays(const ArraySizes& sizes, const PointForm& form = {})
        : form_(form),
          stride_(form.stride == 0 ? 2 * size_of(form.type) : form.stride),
          points_(form.offset + sizes.points * stride_ + guard, canary),
          contours_(sizes.contours * sizeof(lamella::Contour) + guard, canary),
          layers_(sizes.layers * sizeof(lamella::Layer) + guard, canary),
          stitches_(sizes.stitches * sizeof(lamella::Stitch) + guard, canary),
          origins_(sizes.origins ? sizes.points * sizeof(lamella::PointOrigin) + guard : 0, canary),
          arrays{.points = points_.data() + form.offset,
                 .point_capacity = sizes.points,
                 .point_type = form.type,
                 .point_stride = form.stride,
                 .scale = form.scale,
                 .contours = room_in<lamella::Contour>(contours_, sizes.contours),
                 .layers = room_in<lamella::Layer>(layers_, sizes.layers),
                 .stitches = room_in<lamella::Stitch>(stitches_, sizes.stitches),
                 .origins = room_in<lamella::PointOrigin>(origins_, sizes.origins ? sizes.points : 0)} {}
    /// Just as large as a result needs.
    explicit GuardedArrays(const lamella::SliceResult& result, const PointForm& form = {})
        : GuardedArrays({result.points.size(), result.contours.size(), result.layers.size(), result.stitches.size(),
                         !result.origins.empty()},
                        form) {}

    /// True where no byte beyond a capacity, nor between two points, has changed.
    bool guards_stand() const {
        const auto are_canaries = [](const std::byte* begin, std::size_t count) {
            return std::all_of(begin, begin + count, [](std::byte byte) { return byte == canary; });
        };
        bool stand = are_canaries(points_.data(), form_.offset);
        const std::size_t size = 2 * size_of(form_.type);
        for (std::uint64_t p = 0; p < arrays.point_capacity && stride_ > size; ++p) {
            stand = stand && are_canaries(first_point() + p * stride_ + size, stride_ - size);
        }
        for (const auto* bytes : {&points_, &contours_, &layers_, &stitches_, &origins_}) {
            stand = stand && (bytes->empty() || are_canaries(bytes->data() + bytes->size() - guard, guard));
        }
        return stand;
    }

    /// Requires the slice in them to be `expected`, and nothing else to be touched.
    void require_hold(const lamella::SliceResult& expected) const {
        REQUIRE(same_facts(first(arrays.layers, expected.layers), expected.layers.span()));
        REQUIRE(same_bytes(first(arrays.contours, expected.contours), expected.contours.span()));
        if (!arrays.stitches.empty()) {
            REQUIRE(same_facts(first(arrays.stitches, expected.stitches), expected.stitches.span()));
        }
        if (!arrays.origins.empty()) {
            REQUIRE(same_bytes(first(arrays.origins, expected.origins), expected.origins.span()));
        }
        const std::span<const lamella::Point> points = expected.points;
        REQUIRE((form_.type == lamella::Number::i32   ? has_points_as<std::int32_t>(points)
                 : form_.type == lamella::Number::i64 ? has_points_as<std::int64_t>(points)
                 : form_.type == lamella::Number::f32 ? has_points_as<float>(points)
                                                      : has_points_as<double>(points)));
        REQUIRE(guards_stand());
    }

private:
    static constexpr std::size_t guard = 256;
    static constexpr std::byte canary{0xA5};

    template <class T>
    static std::span<T> room_in(std::vector<std::byte>& bytes, std::uint64_t count) {
        return {reinterpret_cast<T*>(bytes.data()), count};
    }
    template <class T>
    static std::span<const T> first(std::span<T> room, const lamella::Array<T>& expected) {
        REQUIRE(room.size() >= expected.size());
        return room.first(expected.size());
    }

    template <class T>
    bool has_points_as(std::span<const lamella::Point> points) const {
        using Factor = std::conditional_t<std::is_integral_v<T>, std::int64_t, double>;
        const auto factor = static_cast<Factor>(form_.scale);
        const auto is_written = [&, at = first_point()](const lamella::Point& p) mutable {
            std::array<T, 2> xy;
            std::memcpy(xy.data(), std::exchange(at, at + stride_), sizeof xy);
            return xy == std::array<T, 2>{static_cast<T>(p.x * factor), static_cast<T>(p.y * factor)};
        };
        return std::all_of(points.begin(), points.end(), is_written);
    }
    const std::byte* first_point() const { return points_.data() + form_.offset; }

    PointForm form_;
    std::size_t stride_;
    std::vector<std::byte> points_;
    std::vector<std::byte> contours_;
    std::vector<std::byte> layers_;
    std::vector<std::byte> stitches_;
    std::vector<std::byte> origins_;

public:
    lamella::HostArrays arrays;
};

/// A mesh as every source that can be made of it in memory.
class EverySource {
public:
    EverySource(const shapes::Soup& soup, const lamella::Frame& frame)
        : soup_(view_of(soup)),
          indexed_(shapes::indexed(soup)),
          prepared_(value_of(prepare(soup_, frame))),
          part_{{.mesh = soup_}} {}

    std::vector<std::pair<std::string, lamella::Source>> all() const {
        return {{"soup", soup_}, {"indexed", indexed_}, {"prepared", prepared_}, {"part", part_}};
    }

private:
    lamella::MeshView soup_;
    shapes::Indexed indexed_;
    lamella::PreparedMesh prepared_;
    std::vector<lamella::Part> part_;
};

/// Requires that every destination gets `expected`. A Slicer serves one after the other.
inline void require_at_every_destination(const lamella::SliceResult& expected, const lamella::Source& source,
                                         const lamella::SliceOptions& options, const Way& way = {}) {
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
        compared.require_all(slice(lamella::LayerSink{.take = compared, .order = order}));
    }
    for (const lamella::Number type : {lamella::Number::i32, lamella::Number::f64}) {
        INFO("to arrays of type " << static_cast<int>(type));
        GuardedArrays host(expected, {.type = type});
        require_same(slice(host.arrays), expected.info);
        host.require_hold(expected);
    }
}
