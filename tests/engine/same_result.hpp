// Whether two answers are the same, field by field.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

#include "lamella/lamella.hpp"

inline auto facts_of(const lamella::Layer& layer) {
    return std::tuple(layer.bottom_mm, layer.plane_mm, layer.top_mm, layer.first_contour, layer.contour_count,
                      layer.segments, layer.plane);
}
inline auto facts_of(const lamella::ClosedGap& gap) {
    return std::tuple(gap.layer, gap.from, gap.to);
}
inline auto facts_of(const lamella::SliceSummary& summary) {
    return std::tuple(std::array{summary.triangles, summary.degenerate, summary.crossed, summary.segments, summary.holes,
                                 summary.open_contours, summary.flat_contours, summary.overruled_contours,
                                 summary.near_contours, summary.emptied_layers},
                      std::to_array(summary.min_mm), std::to_array(summary.max_mm));
}

template <class T>
bool same_facts(std::span<const T> a, std::span<const T> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const T& x, const T& y) { return facts_of(x) == facts_of(y); });
}

/// Of points, contours and origins, which have no byte between their members.
template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    static_assert(sizeof(lamella::Contour) == 48 && sizeof(lamella::Point) == 8 && sizeof(lamella::PointOrigin) == 8);
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

inline void require_same(const lamella::SliceResult& found, const lamella::SliceResult& expected) {
    REQUIRE(same_facts(found.layers.span(), expected.layers.span()));
    REQUIRE(same_bytes(found.contours.span(), expected.contours.span()));
    REQUIRE(same_bytes(found.points.span(), expected.points.span()));
    REQUIRE(same_bytes(found.origins.span(), expected.origins.span()));
    REQUIRE(same_facts(found.closed_gaps.span(), expected.closed_gaps.span()));
    REQUIRE(found.unit_mm == expected.unit_mm);
    REQUIRE(found.frame.m == expected.frame.m);
    REQUIRE((facts_of(found.summary) == facts_of(expected.summary)));
}

inline void require_same_totals(const lamella::SliceTotals& totals, const lamella::SliceResult& result) {
    REQUIRE(totals.layers == result.layers.size());
    REQUIRE(totals.contours == result.contours.size());
    REQUIRE(totals.points == result.points.size());
    REQUIRE(totals.closed_gaps == result.closed_gaps.size());
    REQUIRE(totals.unit_mm == result.unit_mm);
    REQUIRE((facts_of(totals.summary) == facts_of(result.summary)));
}
