// What options.toml says of each option by itself: how its choices are spelled, written by generate.py, its bounds, and
// whether it needs a region.
#pragma once

#include <array>
#include <limits>
#include <string_view>

#include "lamella/error.hpp"
#include "lamella/options.hpp"

namespace lamella::detail {

// begin words
constexpr std::array<std::string_view, 2> words_of(StitchDirection /*any*/) {
    return {"oriented", "any"};
}
constexpr std::array<std::string_view, 3> words_of(LayerContent /*any*/) {
    return {"section", "upward-faces", "downward-faces"};
}
constexpr std::array<std::string_view, 2> words_of(Datum /*any*/) {
    return {"mesh-min", "zero"};
}
constexpr std::array<std::string_view, 2> words_of(PlaneSide /*any*/) {
    return {"below", "above"};
}
constexpr std::array<std::string_view, 5> words_of(FillRule /*any*/) {
    return {"contours", "even-odd", "non-zero", "positive", "outermost"};
}
// end words

}  // namespace lamella::detail

namespace lamella {

inline constexpr double no_limit = std::numeric_limits<double>::infinity();  ///< for options.inc

/// Error: invalid_argument, which begins with the option's name in C++ and C.
Status check_limits(const SliceOptions& options);

/// The first option asked for that needs a region, as Python spells it and almost as C++, C and the tool do; empty if none.
std::string_view needing_region(const SliceOptions& options);

}  // namespace lamella
