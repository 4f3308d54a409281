// Compares two answers field by field.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <tuple>

#include <catch2/catch.hpp>

#include "lamella/result.hpp"

inline auto facts_of(const lamella::Layer& layer) {
    return std::tuple(layer.bottom_mm, layer.plane_mm, layer.top_mm, layer.first_contour, layer.contour_count,
                      layer.segments, layer.plane);
}
inline auto facts_of(const lamella::Stitch& stitch) {
    return std::tuple(stitch.layer, stitch.from, stitch.to);
}
inline auto facts_of(const lamella::SliceInfo& info) {
    return std::tuple(std::array{info.triangles, info.degenerate, info.crossed, info.layers, info.segments, info.contours,
                                 info.points, info.stitches, info.holes, info.open_contours, info.flat_contours,
                                 info.overruled_contours, info.would_close_contours, info.emptied_layers,
                                 info.cancelled_layers, info.part_count, info.first_layer, info.planned_layers},
                      info.box, info.grid_mm, info.options.frame.transform, info.options.stitch_mm);
}

template <class T>
bool same_facts(std::span<const T> a, std::span<const T> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const T& x, const T& y) { return facts_of(x) == facts_of(y); });
}

/// For points, contours and origins, which have no byte between their members.
template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    static_assert(sizeof(lamella::Contour) == 48 && sizeof(lamella::Point) == 8 && sizeof(lamella::PointOrigin) == 8);
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

inline void require_same(const lamella::SliceInfo& found, const lamella::SliceInfo& expected) {
    REQUIRE((facts_of(found) == facts_of(expected)));
    REQUIRE(found.layer_of == expected.layer_of);
}

inline void require_same(const lamella::SliceResult& found, const lamella::SliceResult& expected) {
    REQUIRE(same_facts(found.layers.span(), expected.layers.span()));
    REQUIRE(same_bytes(found.contours.span(), expected.contours.span()));
    REQUIRE(same_bytes(found.points.span(), expected.points.span()));
    REQUIRE(same_bytes(found.origins.span(), expected.origins.span()));
    REQUIRE(same_facts(found.stitches.span(), expected.stitches.span()));
    require_same(found.info, expected.info);
}
