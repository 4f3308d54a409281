#include "methods.hpp"

#include "join_hashed.hpp"
#include "join_sweepline.hpp"
#include "join_trivial.hpp"
#include "ldni.hpp"
#include "mcmains.hpp"
#include "slic3r_way.hpp"
#include "slice_huang.hpp"
#include "slice_incremental.hpp"
#include "slice_sort_first.hpp"
#include "slice_tata.hpp"
#include "slice_trivial.hpp"
#include "topological.hpp"

namespace lamella::baselines {

std::span<const SlicingMethod* const> slicing_methods() noexcept {
    static constexpr const SlicingMethod* all[] = {&trivial_slicing,    &tata_slicing,        &huang_slicing,
                                                   &sort_first_slicing, &incremental_slicing, &presorted_slicing};
    return all;
}

std::span<const ContourMethod* const> contour_methods() noexcept {
    static constexpr const ContourMethod* all[] = {&trivial_contours, &hashed_contours,
#ifdef LAMELLA_BASELINES_CGAL
                                                   &sweepline_contours
#endif
    };
    return all;
}

std::span<const WholeMethod* const> whole_methods() noexcept {
    static constexpr const WholeMethod* all[] = {&slic3r_way, &mcmains, &topological, &ldni};
    return all;
}

}  // namespace lamella::baselines
