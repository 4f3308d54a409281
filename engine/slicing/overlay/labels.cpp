#include "slicing/overlay/labels.hpp"

#include <algorithm>
#include <bit>
#include <string>

namespace lamella {

Status check_rule(const Rule& rule, std::size_t sets) {
    constexpr std::size_t most_for_table = 20;
    if (!rule.labels.empty() && (sets > most_for_table || rule.labels.size() != std::size_t{1} << sets)) {
        return Error{ErrorCode::invalid_argument, "a table of labels has 2^n of them for n sets, which are at most " +
                                                      std::to_string(most_for_table) + ": " + std::to_string(sets) +
                                                      " sets do not go with " + std::to_string(rule.labels.size()) +
                                                      " labels"};
    }
    if ((rule.all | rule.not_all) >> sets != 0) {
        return Error{ErrorCode::invalid_argument, "the rule is about set " +
                                                      std::to_string(std::bit_width(rule.all | rule.not_all) - 1) +
                                                      ", but there are " + std::to_string(sets)};
    }
    for (const std::uint32_t label : rule.labels) {
        if (Status status = check_label(label); !status) {
            return status;
        }
    }
    if (const std::uint32_t outside = label_of(rule, 0); outside != 0) {
        return Error{ErrorCode::invalid_argument,
                     "what lies in no set has the label " + std::to_string(outside) + ", but must have none: 0"};
    }
    return {};
}

Status check_label(std::uint32_t label) {
    if (label > most_labels) {
        return Error{ErrorCode::invalid_argument,
                     "the label " + std::to_string(label) + " is over " + std::to_string(most_labels)};
    }
    return {};
}

std::uint64_t parts_of(const Rule& rule, std::size_t sets) noexcept {
    if (rule.label_of) {
        return 0;
    }
    if (!rule.labels.empty()) {
        return *std::max_element(rule.labels.begin(), rule.labels.end());
    }
    return rule.last_wins ? sets : 1;
}

}  // namespace lamella
