// The options that were asked for, as outputs tell them: in values, sentences and short lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "lamella/options.hpp"

namespace lamella {

/// True if anything but one fill rule for all layers was asked for.
bool goes_beyond_one_rule(const RegionRules& rules) noexcept;

/// Cut these layers of the plan only.
void set_layers(SliceOptions& options, std::uint64_t first, std::uint64_t end) noexcept;
bool are_all_layers(const SliceOptions& options) noexcept;

/// A member of a report.
struct AskedValue {
    std::string_view name;
    std::variant<std::nullptr_t, bool, std::uint64_t, double, std::string> value;
};
std::vector<AskedValue> values_of_plan(const SliceOptions& options);
std::vector<AskedValue> values_of_stitching(const SliceOptions& options);
std::vector<AskedValue> values_of_rules(const RegionRules& rules);

/// Where the planes lie and how each was rounded, as one sentence.
std::string describe_planes(const SliceOptions& options);

/// The rows of the frame's matrix, as a sentence.
std::string describe_frame(const Frame& frame);

/// The fill rules, and what the regions went through, as sentences.
std::string describe_rules(const RegionRules& rules);

/// "of at most 0.5 mm", as gaps are that were closed.
std::string describe_stitching(const SliceOptions& options);

/// "0.2 mm apart, datum zero, the first half a layer above it"
std::string heights_in_short(const SliceOptions& options);

/// Where a plane passes a vertex of its height: "down (side below)".
std::string side_in_short(const SliceOptions& options);

/// What became of closed contours, as lines of a summary, each a keyword and the rest. `flagged`: how many
/// contours closing would change.
std::string rules_in_short(const RegionRules& rules, const std::string& flagged);

}  // namespace lamella
