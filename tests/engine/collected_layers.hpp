// A sink that keeps what it gets, and compares it with a result.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "engine/same_result.hpp"
#include "lamella/lamella.hpp"

class CollectedLayers {
public:
    void operator()(const lamella::LayerView& view) noexcept {
        const std::lock_guard lock(mutex_);
        ++calls_;
        Layer& layer = layers_[view.index];
        layer.layer = view.layer;
        layer.contours.assign(view.contours.begin(), view.contours.end());
        layer.points.assign(view.points.begin(), view.points.end());
        layer.gaps.assign(view.closed_gaps.begin(), view.closed_gaps.end());
        layer.area_mm2 = view.area_mm2();
    }

    /// Where the layers are not those of `result`, byte for byte; empty where they are.
    std::string difference(const lamella::SliceResult& result) const {
        if (calls_ != result.layers.size() || layers_.size() != calls_) {
            return std::to_string(calls_) + " calls for " + std::to_string(result.layers.size()) + " layers";
        }
        std::size_t gap = 0;
        for (const auto& [index, own] : layers_) {
            const lamella::Layer& layer = result.layers[index];
            lamella::Layer moved = own.layer;
            moved.first_contour += layer.first_contour;
            if (facts_of(moved) != facts_of(layer) ||
                std::bit_cast<std::uint64_t>(own.area_mm2) != std::bit_cast<std::uint64_t>(result.area_mm2(layer))) {
                return "layer " + std::to_string(index);
            }
            if (!has_contours_of(own, result, layer)) {
                return "contours of layer " + std::to_string(index);
            }
            for (const lamella::ClosedGap& closed : own.gaps) {
                if (gap == result.closed_gaps.size() || facts_of(closed) != facts_of(result.closed_gaps[gap++])) {
                    return "gaps of layer " + std::to_string(index);
                }
            }
        }
        return gap == result.closed_gaps.size() ? "" : "gaps are missing";
    }

private:
    struct Layer {
        lamella::Layer layer;
        std::vector<lamella::Contour> contours;
        std::vector<lamella::Point> points;
        std::vector<lamella::ClosedGap> gaps;
        double area_mm2 = 0;
    };

    static bool has_contours_of(const Layer& own, const lamella::SliceResult& result, const lamella::Layer& layer) {
        const std::span<const lamella::Contour> contours = result.contours_of(layer);
        if (own.contours.size() != contours.size()) {
            return false;
        }
        if (contours.empty()) {
            return own.points.empty();
        }
        const std::uint64_t first_point = contours.front().first_point;
        for (std::size_t c = 0; c < contours.size(); ++c) {
            lamella::Contour moved = own.contours[c];
            moved.first_point += first_point;
            moved.parent += moved.parent < 0 ? 0 : static_cast<std::int64_t>(layer.first_contour);
            if (!same_bytes(std::span<const lamella::Contour>(&moved, 1), contours.subspan(c, 1))) {
                return false;
            }
        }
        return same_bytes(std::span<const lamella::Point>(own.points),
                          result.points.span().subspan(
                              first_point, contours.back().first_point + contours.back().point_count - first_point));
    }

    std::mutex mutex_;
    std::size_t calls_ = 0;
    std::map<std::uint64_t, Layer> layers_;
};
