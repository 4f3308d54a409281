// How the choices among options are spelled. Written by generate.py.
#pragma once

#include <array>
#include <string_view>

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
