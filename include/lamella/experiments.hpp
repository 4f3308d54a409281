// What experiments vary and embedding hosts leave alone: how the work is cut up, and planes at random heights. No member of
// Tuning changes a byte of the result.
//
//     lamella::SliceOptions options;
//     options.tuning.band_planes = 16;                       // the sweep in bands of 16 planes
//     options.plan.spacing = lamella::RandomLayers{.seed = 7};
#pragma once

#include <cstdint>

namespace lamella {

/// The two forms of contour construction; their results are identical.
enum class ContourForm : std::uint8_t {
    swept,      ///< links live as long as the edges they join and change only at events: the faster
    assembled,  ///< every plane's segments are put together afresh: the paper's Algorithm 4 as stated
};

struct Tuning {
    int band_planes = 0;  ///< planes per z-band, more where triangles would be in too many; 0: by the work in them
    ContourForm form = ContourForm::swept;
};

/// Steps drawn uniformly from [min, max] by seed, from the mesh's lowest vertex up: the paper's adaptive experiment
/// (section 5). The generator is our own, so the same seed gives the same planes on every platform.
struct RandomLayers {
    double min_height_mm = 0.016;
    double max_height_mm = 0.032;
    std::uint64_t seed = 1;
};

}  // namespace lamella
