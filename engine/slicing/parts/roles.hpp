// Roles of parts: in each layer of an object one overlay of its parts' regions.
//
//     solid, negative, modifier    sets of the overlay, in the order of the parts
//     membership                   in no solid, or in a negative one: empty; else the last modifier or else the last solid
//     label                        Contour::part
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/result.hpp"
#include "lamella/source.hpp"
#include "slicing/parts/part_layers.hpp"

namespace lamella {

/// Supports stand beside the overlay.
inline bool is_support(PartRole role) noexcept {
    return role >= PartRole::support_blocker;
}

/// What is wrong with a part.
Error refusal_of(std::size_t part, const std::string& why);

/// True if some part is negative or a modifier.
bool have_roles(std::span<const Part> parts) noexcept;

/// Throws Refused where a role is none, or an object has too many parts for an overlay, or some at other places.
void check_roles(std::span<const Part> parts);

/// The layers of each object that has roles, from its parts' regions. Adds them to `layers`, which are by part and place.
/// Copies that share what they are cut from share them too. Throws Refused, Stopped, std::bad_alloc.
std::deque<SliceResult> label_objects(std::span<const Part> parts, std::span<const std::uint32_t> first_copy,
                                      std::span<PartLayers> layers, const Context& context);

}  // namespace lamella
