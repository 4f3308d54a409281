// The promises of result.hpp, looked at by plain methods that share nothing with the slicing stages.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "base/numbers.hpp"
#include "lamella/result.hpp"
#include "lamella/source.hpp"

namespace lamella {

/// Where a promise is looked at.
struct ResultPlace {
    std::optional<std::size_t> layer{};
    std::optional<std::size_t> contour{};
    std::optional<std::size_t> point{};

    /// Throws Refused, which names the place, unless the promise is kept.
    void require(bool kept, std::string_view broken) const;
};

inline bool has_area(const Contour& contour) noexcept {
    return contour.role == Role::outer || contour.role == Role::hole;
}

/// True if no rule has made, cut or dropped contours of the layer.
inline bool keeps_contours(const SliceResult& result, std::size_t layer) noexcept {
    const SliceOptions& options = result.info.options;
    return options.content == LayerContent::section &&
           options.region.rule_of(result.info.first_layer + layer) == FillRule::contours;
}

/// Origins by themselves and, where there are parts, that points come from there. Precondition: contours lie within the points.
void check_origins(const SliceResult& result, std::span<const Part> parts);

}  // namespace lamella
