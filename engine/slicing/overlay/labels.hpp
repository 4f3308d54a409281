// A Rule at work: labels by membership.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "lamella/error.hpp"
#include "lamella/overlay.hpp"

namespace lamella {

/// The bounds of a rule for so many sets. Error: invalid_argument.
Status check_rule(const Rule& rule, std::size_t sets);

/// The bounds of a label. Error: invalid_argument.
Status check_label(std::uint32_t label);

/// How many parts the answer has. Where the host's function gives the labels: not known, 0.
std::uint64_t parts_of(const Rule& rule, std::size_t sets) noexcept;

/// The label of what is in these sets.
inline std::uint32_t label_of(const Rule& rule, std::uint64_t in) noexcept {
    if (rule.label_of) {
        return rule.label_of(in);
    }
    if (!rule.labels.empty()) {
        return rule.labels[in];
    }
    const bool holds = (in & rule.any) != 0 && (in & rule.all) == rule.all && (in & rule.none) == 0 &&
                       (rule.not_all == 0 || (in & rule.not_all) != rule.not_all) &&
                       (!rule.odd || std::popcount(in) % 2 == 1);
    if (!holds) {
        return 0;
    }
    return rule.last_wins ? static_cast<std::uint32_t>(std::bit_width(in & rule.any)) : 1;
}

}  // namespace lamella
