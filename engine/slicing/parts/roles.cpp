#include "slicing/parts/roles.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <string>

#include "base/guard.hpp"
#include "lamella/overlay.hpp"

namespace lamella {

namespace {

/// Parts by object, supports left out, of objects that have roles.
using PartsOfObjects = std::map<std::uint32_t, std::vector<std::uint32_t>>;

PartsOfObjects list_objects(std::span<const Part> parts) {
    PartsOfObjects objects;
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        if (!is_support(parts[p].role)) {
            objects[parts[p].object].push_back(p);
        }
    }
    std::erase_if(objects, [parts](const auto& object) {
        return std::all_of(object.second.begin(), object.second.end(),
                           [parts](std::uint32_t p) { return parts[p].role == PartRole::solid; });
    });
    return objects;
}

/// Which sets of an overlay have which role, as bits.
struct RoleSets {
    std::uint64_t solid = 0;
    std::uint64_t negative = 0;
    std::uint64_t modifier = 0;

    void add(PartRole role, std::size_t set) noexcept {
        (role == PartRole::solid ? solid : role == PartRole::negative ? negative : modifier) |= std::uint64_t{1} << set;
    }
    /// 1 + the number of the set.
    std::uint32_t label_of(std::uint64_t in) const noexcept {
        if ((in & solid) == 0 || (in & negative) != 0) {
            return 0;
        }
        return static_cast<std::uint32_t>(std::bit_width((in & modifier) != 0 ? in & modifier : in & solid));
    }
};

/// `layers_of`: of each part in `own`.
SliceResult label_object(std::span<const Part> parts, std::span<const std::uint32_t> own,
                         std::span<PartLayers* const> layers_of, Overlay& overlay, const Context& context) {
    RoleSets roles;
    std::vector<LayerSet> sets;
    for (const PartLayers* const layers : layers_of) {
        roles.add(parts[layers->label].role, sets.size());
        sets.push_back({.layers = *layers->alone});
    }
    const auto label = [&roles](std::uint64_t in) noexcept { return roles.label_of(in); };
    SliceResult result(context.memory);
    require(overlay.combine(result, sets, {.label_of = label}, {}, context));
    for (Contour& contour : result.contours) {
        contour.part = own[contour.part];
    }
    return result;
}

}  // namespace

Error refusal_of(std::size_t part, const std::string& why) {
    Error error{ErrorCode::invalid_argument, "part " + std::to_string(part) + ": " + why};
    error.part = static_cast<std::int64_t>(part);
    return error;
}

bool have_roles(std::span<const Part> parts) noexcept {
    return std::any_of(parts.begin(), parts.end(),
                       [](const Part& part) { return part.role == PartRole::negative || part.role == PartRole::modifier; });
}

void check_roles(std::span<const Part> parts) {
    for (std::size_t p = 0; p < parts.size(); ++p) {
        if (parts[p].role > PartRole::support) {
            throw Refused{refusal_of(p, "there is no role " + std::to_string(static_cast<unsigned>(parts[p].role)))};
        }
    }
    if (!have_roles(parts)) {
        return;
    }
    for (const auto& [object, own] : list_objects(parts)) {
        for (const std::uint32_t p : own) {
            const auto places = parts[p].at_mm;
            const auto others = parts[own[0]].at_mm;
            if (!std::equal(places.begin(), places.end(), others.begin(), others.end())) {
                throw Refused{refusal_of(p, "roles act among parts at the same places, and part " + std::to_string(own[0]) +
                                                " of its object stands at others")};
            }
        }
        if (own.size() > most_layer_sets) {
            throw Refused{{ErrorCode::invalid_argument, "object " + std::to_string(object) + " has " +
                                                            std::to_string(own.size()) +
                                                            " parts; of an object with roles at most " +
                                                            std::to_string(most_layer_sets) + " can be overlaid"}};
        }
    }
}

std::deque<SliceResult> label_objects(std::span<const Part> parts, std::span<const std::uint32_t> first_copy,
                                      std::span<PartLayers> layers, const Context& context) {
    std::deque<SliceResult> labelled;  // layers refer to them
    Overlay overlay;
    for (const auto& [object, own] : list_objects(parts)) {
        std::map<const SliceResult*, const SliceResult*> by_cut;  // of the first part: the others stand at its places
        for (std::size_t place = 0; place < std::max<std::size_t>(1, parts[own[0]].at_mm.size()); ++place) {
            std::vector<PartLayers*> copy;
            for (const std::uint32_t p : own) {
                copy.push_back(&layers[first_copy[p] + place]);
            }
            const SliceResult*& known = by_cut[copy[0]->alone];
            if (known == nullptr) {
                known = &labelled.emplace_back(label_object(parts, own, copy, overlay, context));
            }
            for (PartLayers* const part : copy) {
                part->labelled = known;
            }
        }
    }
    return labelled;
}

}  // namespace lamella
