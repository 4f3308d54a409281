// What the tests of slabs share.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"

namespace slab_tests {

using lamella::MeshView;
using lamella::SlabOptions;
using lamella::Slabs;
using lamella::SliceResult;

inline SlabOptions slabs_at(std::vector<double> heights_mm, double unit_mm = coarse_unit_mm) {
    SlabOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{std::move(heights_mm)};
    options.unit_mm = unit_mm;
    options.control.threads = 1;
    return options;
}

/// Requires success and two valid results.
inline Slabs slabs_of(const MeshView& mesh, const SlabOptions& options) {
    Slabs slabs = value_of(slice_slabs(mesh, options));
    require_ok(validate(slabs.top));
    require_ok(validate(slabs.bottom));
    return slabs;
}
inline Slabs slabs_of(const shapes::Soup& soup, const SlabOptions& options) {
    return slabs_of(view_of(soup), options);
}

inline std::uint64_t hash_of(const Slabs& slabs) {
    return hash_result(slabs.top) * 31 + hash_result(slabs.bottom);
}

/// Twice the net area of one layer, or of all, in square units.
inline oracle::Int128 twice_area(const SliceResult& result, const lamella::Layer& layer) {
    oracle::Int128 sum = 0;
    for (const lamella::Contour& contour : result.contours_of(layer)) {
        sum += (oracle::Int128{contour.twice_area.high} << 64) + contour.twice_area.low;
    }
    return sum;
}
inline oracle::Int128 twice_area(const SliceResult& result) {
    oracle::Int128 sum = 0;
    for (const lamella::Layer& layer : result.layers) {
        sum += twice_area(result, layer);
    }
    return sum;
}

inline oracle::Int128 twice_area(const oracle::Triangle& t) {
    const auto [a, b, c] = t;
    return oracle::Int128{b.x - a.x} * (c.y - a.y) - oracle::Int128{b.y - a.y} * (c.x - a.x);
}

/// Of all faces that look upward.
inline oracle::Int128 twice_upward_area(const shapes::Soup& soup, double unit_mm) {
    oracle::Int128 sum = 0;
    for (const oracle::Triangle& t : oracle::quantise(soup, unit_mm)) {
        sum += std::max<oracle::Int128>(0, twice_area(t));
    }
    return sum;
}

}  // namespace slab_tests
