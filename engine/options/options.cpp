// What options say of themselves.
#include "lamella/options.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "options/option_words.hpp"

namespace lamella {

namespace {

template <class Choice>
std::string_view word_of(Choice choice) noexcept {
    return detail::words_of(choice)[static_cast<std::size_t>(choice)];
}

}  // namespace

std::string_view name_of(StitchDirection direction) noexcept {
    return word_of(direction);
}
std::string_view name_of(LayerContent content) noexcept {
    return word_of(content);
}
std::string_view name_of(Datum datum) noexcept {
    return word_of(datum);
}
std::string_view name_of(PlaneSide side) noexcept {
    return word_of(side);
}
std::string_view name_of(FillRule rule) noexcept {
    return word_of(rule);
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
