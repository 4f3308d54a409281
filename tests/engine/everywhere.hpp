// Every source and every destination of a slice: what each gets is compared as a result.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/same_result.hpp"
#include "engine/slicing.hpp"

/// A sink that keeps what it gets.
class CollectedLayers {
public:
    void operator()(const lamella::LayerView& view) noexcept {
        const std::lock_guard lock(mutex_);
        ++calls_;
        layers_[view.index] = {view,
                               {view.contours.begin(), view.contours.end()},
                               {view.points.begin(), view.points.end()},
                               {view.origins.begin(), view.origins.end()},
                               {view.stitches.begin(), view.stitches.end()},
                               view.area_mm2()};
    }

    /// Requires each layer once. `info` is what the slice returned.
    lamella::SliceResult result(const lamella::SliceInfo& info) const {
        REQUIRE(calls_ == info.layers);
        REQUIRE(layers_.size() == info.layers);
        std::vector<lamella::Layer> layers;
        std::vector<lamella::Contour> contours;
        std::vector<lamella::Point> points;
        std::vector<lamella::PointOrigin> origins;
        std::vector<lamella::Stitch> stitches;
        for (const auto& [index, own] : layers_) {
            REQUIRE(own.layer.first_contour == 0);
            layers.push_back(own.layer);
            layers.back().first_contour = contours.size();
            for (lamella::Contour contour : own.contours) {
                contour.first_point += points.size();
                contour.parent += contour.parent < 0 ? 0 : static_cast<std::int64_t>(layers.back().first_contour);
                contours.push_back(contour);
            }
            points.insert(points.end(), own.points.begin(), own.points.end());
            origins.insert(origins.end(), own.origins.begin(), own.origins.end());
            stitches.insert(stitches.end(), own.stitches.begin(), own.stitches.end());
        }
        lamella::SliceResult result;
        fill(result.layers, layers);
        fill(result.contours, contours);
        fill(result.points, points);
        fill(result.origins, origins);
        fill(result.stitches, stitches);
        result.info = info;
        for (const auto& [index, own] : layers_) {
            const double area_mm2 = result[index].area_mm2();
            REQUIRE(std::memcmp(&own.area_mm2, &area_mm2, sizeof area_mm2) == 0);
        }
        return result;
    }

private:
    struct Own {
        lamella::Layer layer;
        std::vector<lamella::Contour> contours;
        std::vector<lamella::Point> points;
        std::vector<lamella::PointOrigin> origins;
        std::vector<lamella::Stitch> stitches;
        double area_mm2 = 0;
    };

    std::mutex mutex_;
    std::size_t calls_ = 0;
    std::map<std::uint64_t, Own> layers_;
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
            stand = stand && are_canaries(points_.data() + form_.offset + p * stride_ + size, stride_ - size);
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
        REQUIRE(has_points_of(expected));
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

    bool has_points_of(const lamella::SliceResult& result) const {
        switch (form_.type) {
            case lamella::Number::i32:
                return has_points_as<std::int32_t>(result);
            case lamella::Number::i64:
                return has_points_as<std::int64_t>(result);
            case lamella::Number::f32:
                return has_points_as<float>(result);
            default:
                return has_points_as<double>(result);
        }
    }
    template <class T>
    bool has_points_as(const lamella::SliceResult& result) const {
        using Factor = std::conditional_t<std::is_integral_v<T>, std::int64_t, double>;
        const auto factor = static_cast<Factor>(form_.scale);
        for (std::size_t p = 0; p < result.points.size(); ++p) {
            std::array<T, 2> xy;
            std::memcpy(xy.data(), points_.data() + form_.offset + p * stride_, sizeof xy);
            const auto [x, y] = result.points[p];
            if (xy != std::array<T, 2>{static_cast<T>(x * factor), static_cast<T>(y * factor)}) {
                return false;
            }
        }
        return true;
    }

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
        CollectedLayers collected;
        require_same(collected.result(slice(lamella::LayerSink{.take = collected, .order = order})), expected);
    }
    for (const lamella::Number type : {lamella::Number::i32, lamella::Number::f64}) {
        INFO("to arrays of type " << static_cast<int>(type));
        GuardedArrays host(expected, {.type = type});
        require_same(slice(host.arrays), expected.info);
        host.require_hold(expected);
    }
}
