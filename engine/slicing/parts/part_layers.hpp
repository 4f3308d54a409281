// What parts are between slicing and merging: each has a result of its own, and shares one with its object where that has
// roles.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "lamella/result.hpp"

namespace lamella {

struct PartLayers {
    const SliceResult* alone;               ///< as the part was sliced; all parts have as many layers
    const SliceResult* labelled = nullptr;  ///< its object's, whose contours of `label` stand for the closed ones
    std::uint32_t label = 0;                ///< the part's index
    std::uint32_t number = 0;               ///< the copy's, which its contours get
    Point move{};                           ///< what its points are moved by
    bool is_support = false;

    Point moved(Point point) const noexcept { return {point.x + move.x, point.y + move.y}; }

    /// Of a layer's labelled contours, which lie by part.
    std::span<const Contour> labelled_in(std::size_t layer) const noexcept {
        const auto all = labelled->contours_of(labelled->layers[layer]);
        const auto begin = std::partition_point(all.begin(), all.end(), [this](const Contour& c) { return c.part < label; });
        const auto end = std::partition_point(begin, all.end(), [this](const Contour& c) { return c.part == label; });
        return {begin, end};
    }

    /// Calls use(result, contour) for each contour of a layer, in the order of a result's.
    template <class Use>
    void each_contour(std::size_t layer, Use use) const {
        const auto own = alone->contours_of(alone->layers[layer]);
        if (labelled == nullptr) {
            for (const Contour& contour : own) {
                use(*alone, contour);
            }
            return;
        }
        const auto is_open = [](const Contour& contour) { return contour.role == Role::open; };
        auto open = std::find_if(own.begin(), own.end(), is_open);
        for (const Contour& contour : labelled_in(layer)) {
            const Point start = labelled->points[contour.first_point];
            while (contour.role != Role::hole && open != own.end() && alone->points[open->first_point] < start) {
                use(*alone, *open);
                open = std::find_if(open + 1, own.end(), is_open);
            }
            use(*labelled, contour);
        }
        for (; open != own.end(); open = std::find_if(open + 1, own.end(), is_open)) {
            use(*alone, *open);
        }
    }
};

}  // namespace lamella
