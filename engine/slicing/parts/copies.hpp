// Copies of parts: a part with places stands once at each. It is cut once for each height that these have, and its contours
// are moved in the plane.
//
//     parts    0 at (0 0 0) (9 0 0) (0 0 5)       1, which stays where it is
//     cuts     part 0 raised by 0                 copy 0 as it is, copy 1 moved by (9 0)
//              part 0 raised by 5                 copy 2
//              part 1                             copy 3
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lamella/options.hpp"
#include "lamella/result.hpp"
#include "lamella/source.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/parts/part_layers.hpp"

namespace lamella {

struct Cut {
    std::uint32_t part;
    std::int32_t up;           ///< grid units, even: planes lie so much lower above the part
    std::uint32_t first_copy;  ///< of those that share it
    std::uint64_t copies;      ///< how many these are
};

struct Copy {
    std::uint32_t cut;
    Point move;  ///< even
};

struct CopyList {
    std::vector<Cut> cuts;                  ///< by part
    std::vector<Copy> copies;               ///< by part and place; their numbers are those of parts in the result
    std::vector<std::uint32_t> first_copy;  ///< of each part
};

/// How far each place of a part moves it, after `frame`: at least one move. Throws
/// Refused where one is too far, or no number.
std::vector<std::array<double, 3>> moves_mm(std::span<const Part> parts, std::size_t part, const Transform& frame);

/// With moves rounded to the even grid.
CopyList list_copies(std::span<const Part> parts, const Transform& frame, double unit_mm);

Bounds moved(Bounds box, const std::array<double, 3>& mm) noexcept;

/// The box around all copies that are solid, or of all where none is. `bounds`: of each part.
Bounds box_of_copies(std::span<const Part> parts, std::span<const Bounds> bounds, const CopyList& list, double unit_mm);

/// Of each copy, from its cut.
std::vector<PartLayers> layers_of(std::span<const Part> parts, const CopyList& list, std::span<const SliceResult> sliced);

/// Leaves the first copy of each cut in `layers`. Returns the others.
std::vector<PartCopy> leave_first(const CopyList& list, std::vector<PartLayers>& layers);

}  // namespace lamella
