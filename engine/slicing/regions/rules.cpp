#include <algorithm>
#include <array>

#include "lamella/region.hpp"

namespace lamella {

std::string_view name_of(FillRule rule) noexcept {
    constexpr std::array<std::string_view, 5> names = {"contours", "even-odd", "non-zero", "positive", "outermost"};
    return names[static_cast<std::size_t>(rule)];
}

FillRule RegionRules::rule_of(std::uint64_t layer) const noexcept {
    const auto after = std::upper_bound(fill_from.begin(), fill_from.end(), layer,
                                        [](std::uint64_t own, const FillFrom& from) { return own < from.first_layer; });
    return after == fill_from.begin() ? fill_rule : std::prev(after)->rule;
}

bool RegionRules::keeps_contours() const noexcept {
    return fill_rule == FillRule::contours && std::all_of(fill_from.begin(), fill_from.end(), [](const FillFrom& from) {
               return from.rule == FillRule::contours;
           });
}

}  // namespace lamella
