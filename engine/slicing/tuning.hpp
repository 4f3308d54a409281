// What experiments vary, and hosts do not see. None of it changes a byte of the result, but for random heights, which are
// another plan.
//
//     lamella::Slicer slicer;
//     lamella::SliceResult result;
//     const auto info = lamella::slice_tuned(slicer, result, mesh, options, {.form = lamella::ContourForm::assembled});
#pragma once

#include <cstdint>
#include <optional>

#include "base/dispatch.hpp"
#include "lamella/slice.hpp"

namespace lamella {

/// How contours are built.
enum class ContourForm : std::uint8_t {
    swept,      ///< links live from plane to plane: only what changes is linked anew
    assembled,  ///< every plane's segments are linked afresh: the paper's Algorithm 4 as stated
};

/// The paper's adaptive experiment (section 5): steps drawn uniformly between two bounds. A seed means the same planes on
/// every platform.
struct RandomHeights {
    double min_step_mm = 0.01;
    double max_step_mm = 0.2;
    std::uint64_t seed = 1;
};

struct Tuning {
    std::int64_t band_planes = 0;  ///< swept as one task; 0: chosen by the work in them
    ContourForm form = ContourForm::swept;
    std::optional<InstructionSet> instructions{};   ///< of kernels; none: the highest level that the processor runs
    std::optional<RandomHeights> random_heights{};  ///< in place of the options' plan; SliceInfo::options then lists them
};

/// Slicer::slice_to(), tuned.
Result<SliceInfo> slice_tuned(Slicer& slicer, const Destination& to, const Source& from, const SliceOptions& options,
                              const Tuning& tuning, const Context& context = {}) noexcept;

}  // namespace lamella
