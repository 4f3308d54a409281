// What options say of themselves.
#include "lamella/options.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string>
#include <type_traits>

#include "base/words.hpp"
#include "options/option_words.hpp"

namespace lamella {

namespace {

template <class Choice>
std::string_view word_of(Choice choice) noexcept {
    return detail::words_of(choice)[static_cast<std::size_t>(choice)];
}

/// " must be finite and at least 0, not -1"; empty if an option may be so.
template <class Value>
std::string refusal_of(const Value& value, double least, bool exclusive, double special) {
    if constexpr (std::is_enum_v<Value>) {
        return static_cast<std::size_t>(value) < detail::words_of(value).size() ? "" : " is none of its choices";
    } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
        return value ? refusal_of(*value, least, exclusive, special) : "";
    } else if constexpr (std::is_same_v<Value, double>) {
        const bool in_bounds = std::isfinite(value) && (exclusive ? value > least : value >= least);
        if (!in_bounds && (special == 0 || value != special)) {
            return " must be finite" +
                   (least > -no_limit ? (exclusive ? " and more than " : " and at least ") + exact_text(least) : "") +
                   ", not " + exact_text(value);
        }
    }
    return {};
}

}  // namespace

Status check_limits(const SliceOptions& options) {
#define OPTION(kind, name, path, python, flag, least, exclusive, word, special, ...)               \
    if (const std::string no = refusal_of(options.path, least, exclusive, special); !no.empty()) { \
        return Error{ErrorCode::invalid_argument, #name + no};                                     \
    }
#include "options/options.inc"
    return {};
}

std::string_view needing_region(const SliceOptions& options) {
    const SliceOptions none;
#define OPTION(kind, name, path, python, flag, least, exclusive, word, special, needs_region, help) \
    if ((needs_region) && !(options.path == none.path)) {                                           \
        return python;                                                                              \
    }
#include "options/options.inc"
    return {};
}

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
