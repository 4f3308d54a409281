#include "slicing/parts/copies.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "base/guard.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/parts/roles.hpp"

namespace lamella {

std::vector<std::array<double, 3>> moves_mm(std::span<const Part> parts, std::size_t part, const Transform& frame) {
    const auto& m = frame.m;
    std::vector<std::array<double, 3>> moves;
    moves.reserve(parts[part].at_mm.size() + 1);
    for (const auto& [x, y, z] : parts[part].at_mm) {
        const std::array<double, 3> move{m[0] * x + m[1] * y + m[2] * z, m[4] * x + m[5] * y + m[6] * z,
                                         m[8] * x + m[9] * y + m[10] * z};
        if (!std::all_of(move.begin(), move.end(), [](double mm) { return std::abs(mm) <= largest_coordinate_mm; })) {
            throw Refused{refusal_of(part, "place " + std::to_string(moves.size()) + " is not finite or beyond 1e9 mm")};
        }
        moves.push_back(move);
    }
    if (moves.empty()) {
        moves.push_back({});
    }
    return moves;
}

CopyList list_copies(std::span<const Part> parts, const Transform& frame, double unit_mm) {
    CopyList list;
    const auto rounded = [unit_mm](double mm) {  // parts without triangles may go beyond the grid
        const double most = 2147483646 * unit_mm;
        return to_even_grid(std::clamp(mm, -most, most), unit_mm);
    };
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        list.first_copy.push_back(static_cast<std::uint32_t>(list.copies.size()));
        std::map<std::int32_t, std::uint32_t> cut_by_height;
        for (const auto& [x, y, z] : moves_mm(parts, p, frame)) {
            const std::int32_t up = rounded(z);
            const auto [cut, is_new] = cut_by_height.try_emplace(up, static_cast<std::uint32_t>(list.cuts.size()));
            if (is_new) {
                list.cuts.push_back({p, up, static_cast<std::uint32_t>(list.copies.size()), 0});
            }
            ++list.cuts[cut->second].copies;
            list.copies.push_back({cut->second, {rounded(x), rounded(y)}});
        }
    }
    return list;
}

Bounds moved(Bounds box, const std::array<double, 3>& mm) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.min_mm[axis] += mm[axis];
        box.max_mm[axis] += mm[axis];
    }
    return box;
}

Bounds box_of_copies(std::span<const Part> parts, std::span<const Bounds> bounds, const CopyList& list, double unit_mm) {
    Bounds all = Bounds::empty();
    Bounds solid = Bounds::empty();
    for (const auto& [c, move] : list.copies) {
        const Cut& cut = list.cuts[c];
        const Bounds box = moved(bounds[cut.part], {move.x * unit_mm, move.y * unit_mm, cut.up * unit_mm});
        all.add(box);
        if (parts[cut.part].role == PartRole::solid) {
            solid.add(box);
        }
    }
    return solid.max_mm[2] >= solid.min_mm[2] ? solid : all;
}

std::vector<PartLayers> layers_of(std::span<const Part> parts, const CopyList& list, std::span<const SliceResult> sliced) {
    std::vector<PartLayers> layers;
    layers.reserve(list.copies.size());
    for (const auto& [c, move] : list.copies) {
        const std::uint32_t part = list.cuts[c].part;
        layers.push_back({.alone = &sliced[c],
                          .label = part,
                          .number = static_cast<std::uint32_t>(layers.size()),
                          .move = move,
                          .is_support = is_support(parts[part].role)});
    }
    return layers;
}

std::vector<PartCopy> leave_first(const CopyList& list, std::vector<PartLayers>& layers) {
    std::vector<PartCopy> others;
    for (const PartLayers& part : layers) {
        const std::uint32_t first = list.cuts[list.copies[part.number].cut].first_copy;
        if (first != part.number) {
            const Point from = list.copies[first].move;
            others.push_back({part.number, first, {part.move.x - from.x, part.move.y - from.y}});
        }
    }
    std::erase_if(layers, [&list](const PartLayers& part) {
        return list.cuts[list.copies[part.number].cut].first_copy != part.number;
    });
    return others;
}

}  // namespace lamella
