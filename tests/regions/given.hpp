// Contours of a host's own, as a set of layers refers to them.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "lamella/overlay.hpp"
#include "regions/region.hpp"

namespace regions {

/// Contours that a set refers to.
struct Given {
    explicit Given(Polygons of, double grid_mm = 1) : polygons(std::move(of)), views(polygons.begin(), polygons.end()) {
        set.contours = views;
        set.grid_mm = grid_mm;
    }
    Given(const Given&) = delete;
    Given& operator=(const Given&) = delete;

    Polygons polygons;
    std::vector<std::span<const lamella::Point>> views;
    lamella::ContourSet set;
};

}  // namespace regions
