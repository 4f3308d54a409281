// A host's own arrays to be sliced into, and whether they hold a result.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>
#include <vector>

#include "engine/same_result.hpp"
#include "lamella/lamella.hpp"

/// Arrays of a host, each followed by bytes that nobody may touch.
struct HostArrays {
    using PointType = lamella::PointType;
    HostArrays(std::uint64_t points, std::uint64_t contours, std::uint64_t layers, PointType type = PointType::i32,
               std::size_t stride = 0, double scale = 1, std::size_t offset = 0)
        : stride(stride == 0 ? bytes_of(type) : stride),
          offset(offset),
          point_bytes(offset + points * this->stride + guard, canary),
          contour_bytes(contours * sizeof(lamella::Contour) + guard, canary),
          layer_bytes(layers * sizeof(lamella::Layer) + guard, canary),
          output{.type = type,
                 .points = point_bytes.data() + offset,
                 .point_capacity = points,
                 .stride = stride,
                 .scale = scale,
                 .contours = reinterpret_cast<lamella::Contour*>(contour_bytes.data()),
                 .contour_capacity = contours,
                 .layers = reinterpret_cast<lamella::Layer*>(layer_bytes.data()),
                 .layer_capacity = layers} {}

    /// Whether no byte beyond a capacity, nor between two points, has changed.
    bool guards_stand() const {
        const auto is_canary = [](std::byte byte) { return byte == canary; };
        bool stand = true;
        for (std::uint64_t p = 0; p < output.point_capacity; ++p) {
            const auto begin = point_bytes.begin() + static_cast<std::ptrdiff_t>(offset + p * stride);
            stand = stand && std::all_of(begin + static_cast<std::ptrdiff_t>(bytes_of(output.type)),
                                         begin + static_cast<std::ptrdiff_t>(stride), is_canary);
        }
        return stand &&
               std::all_of(point_bytes.begin(), point_bytes.begin() + static_cast<std::ptrdiff_t>(offset), is_canary) &&
               std::all_of(point_bytes.end() - guard, point_bytes.end(), is_canary) &&
               std::all_of(contour_bytes.end() - guard, contour_bytes.end(), is_canary) &&
               std::all_of(layer_bytes.end() - guard, layer_bytes.end(), is_canary);
    }

    bool has_points_of(const lamella::SliceResult& result) const {
        switch (output.type) {
            case PointType::i32:
                return has_points_as<std::int32_t>(result);
            case PointType::i64:
                return has_points_as<std::int64_t>(result);
            case PointType::f32:
                return has_points_as<float>(result);
            case PointType::f64:
                return has_points_as<double>(result);
        }
        return false;
    }
    bool has_contours_of(const lamella::SliceResult& result) const {
        return same_bytes(std::span<const lamella::Contour>(output.contours, result.contours.size()),
                          result.contours.span());
    }
    bool has_layers_of(const lamella::SliceResult& result) const {
        return same_facts(std::span<const lamella::Layer>(output.layers, result.layers.size()), result.layers.span());
    }

    static constexpr std::ptrdiff_t guard = 256;
    static constexpr std::byte canary{0xA5};
    std::size_t stride;
    std::size_t offset;
    std::vector<std::byte> point_bytes;
    std::vector<std::byte> contour_bytes;
    std::vector<std::byte> layer_bytes;
    lamella::HostOutput output;

private:
    static std::size_t bytes_of(PointType type) { return type == PointType::i32 || type == PointType::f32 ? 8 : 16; }

    template <class T>
    bool has_points_as(const lamella::SliceResult& result) const {
        using Factor = std::conditional_t<std::is_integral_v<T>, std::int64_t, double>;
        const auto factor = static_cast<Factor>(output.scale);
        for (std::size_t p = 0; p < result.points.size(); ++p) {
            std::array<T, 2> xy;
            std::memcpy(xy.data(), point_bytes.data() + offset + p * stride, sizeof xy);
            const auto [x, y] = result.points[p];
            if (xy != std::array<T, 2>{static_cast<T>(x * factor), static_cast<T>(y * factor)}) {
                return false;
            }
        }
        return true;
    }
};
