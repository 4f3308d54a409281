// RegionRules: what follows from them, and their bounds. A caller learns of everything that cannot be done before anything
// is: what a rule says by itself before the mesh is read, what the grid cannot hold once its unit is known.
#pragma once

#include <string_view>

#include "lamella/error.hpp"
#include "lamella/options.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

/// How far contours may move. A corner that is cut lies up to 1.42 offsets away, one that is not up to the miter limit.
double moved_mm(const RegionRules& rules) noexcept;

/// True if no rule moves or drops contours but FillRule::non_zero.
bool keeps_solid(const RegionRules& rules) noexcept;

/// The rules as they work: the pieces of faces are united, whatever the fill rule.
RegionRules working_rules(const SliceOptions& options);

/// The bounds of all options, the order of layers, and whether all that is asked for has a region to be done to. Error:
/// invalid_argument, one line that names the option.
Status check_rules(const SliceOptions& options);

/// The unit for meshes within `bounds` and for what the rules make of their contours: choose_unit(), then check_reach().
Result<ChosenUnit> choose_unit_for(const Bounds& bounds, double asked_mm, bool coarser, const RegionRules& rules);

/// True if the lengths of `rules` are at least a unit, and the grid holds them around contours whose farthest coordinate is
/// `farthest_mm`. Precondition: check_rules() is content.
/// Error: invalid_argument, one line that names the rule and what is possible.
Status check_reach(const RegionRules& rules, double unit_mm, double farthest_mm);

/// True if every layer has a region, which `what` needs. Error: invalid_argument.
Status check_every_layer(const RegionRules& rules, std::string_view what);

}  // namespace lamella
