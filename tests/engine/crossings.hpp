// Comparison of what find_crossings() answers.
#pragma once

#include <cstddef>

#include <catch2/catch.hpp>

#include "lamella/audit/crossings.hpp"

/// Checks that both are the same in every member.
inline void check_equal(const lamella::Crossings& one, const lamella::Crossings& other) {
    CHECK(other.count == one.count);
    CHECK(other.at_least == one.at_least);
    REQUIRE(other.layers.size() == one.layers.size());
    for (std::size_t i = 0; i < one.layers.size(); ++i) {
        CHECK(other.layers[i].layer == one.layers[i].layer);
        CHECK(other.layers[i].count == one.layers[i].count);
        CHECK(other.layers[i].at_least == one.layers[i].at_least);
        CHECK(other.layers[i].first == one.layers[i].first);
        CHECK(other.layers[i].contours == one.layers[i].contours);
    }
}
