// Triangles that lie in the lists of their first planes already, of which some planes are swept: a file that is cut in
// ranges of layers. Nothing is copied: the records are lent to the buckets while a range is swept.
//
//     planes of the whole    ... 41 |   42    43   44  | 45 ...
//     records                       | t7 t2 | t9 | t1 t4 | ...      a range of three planes, number 0 of which is `base`
//                                     of which t7 begins at plane 40, and reaches into the range
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "slicing/buckets/triangle_source.hpp"

namespace lamella {

struct ListedTriangles {
    Array<CrossedTriangle>& records;            ///< by first plane, or that of the range if it is higher
    std::span<const std::uint32_t> list_begin;  ///< of the range's planes, and one more: where lists begin in `records`
    std::span<const std::uint32_t> segments;    ///< triangles that each plane cuts
    PlaneIndex base = 0;                        ///< the first plane of the range, from which records count on while swept
};

/// The `triangles` records. Scattering takes them, and give_back() returns them: planes count from the range's first then.
class ListedSource final : public TriangleSource {
public:
    ListedSource(const ListedTriangles& listed, std::uint64_t triangles, const SharedFrame& frame,
                 const SourceTools& tools) noexcept
        : TriangleSource({triangles, &frame}, tools), listed_(listed) {}

    Bounds measure(double /*asked_mm*/) override { return info.frame->bounds; }
    void count(double unit_mm) override;
    std::size_t scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                        bool origins) override;
    void give_back() noexcept override;

private:
    const ListedTriangles listed_;
};

/// Brings records that begin at planes from `base` on, or below it and then count as such, to their lists, in place.
/// `list_begin`: of planes from `base` on, and one more; the first is 0, and the last the number of records. O(n), with 8
/// bytes a thread and plane. No order within a list. Throws Stopped, std::bad_alloc.
void sort_into_lists(std::span<CrossedTriangle> records, PlaneIndex base, std::span<const std::uint32_t> list_begin,
                     const Parallel& parallel);

}  // namespace lamella
