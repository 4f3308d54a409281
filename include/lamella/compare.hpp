// How alike two stacks of layers are: overlap of areas, and distances of contours, layer by layer.
//
//     lamella::SliceOptions grown = result.info.options;
//     grown.region.fill_rule = lamella::FillRule::non_zero;
//     grown.region.offset_mm = 0.1;
//     const auto larger = lamella::slice(mesh, grown);
//     const auto compared = lamella::compare(result, *larger);
//     if (compared) {
//         for (const lamella::LayerComparison& layer : compared->layers) {
//             std::printf("%g mm: Dice %g, at most %g mm apart\n", layer.z_mm, layer.dice, layer.hausdorff_mm);
//         }
//         std::printf("all: Dice %g\n", compared->stack.dice);
//     }
//
// Not known is NaN: the numbers of a layer in which a contour is open, and those of the stack where there is such a layer.
// Of two empty layers they are NaN, too. Where one is empty, Dice and Jaccard are 0 and distances infinite, so that a miss
// improves no mean.
#pragma once

#include <cstdint>
#include <limits>

#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/result.hpp"

namespace lamella {

struct LayerComparison {
    static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

    std::uint64_t layer = 0;  ///< index into SliceResult::layers; of the stack 0
    double z_mm = unknown;
    double first_mm2 = unknown;  ///< area of the first; of the stack volumes, mm3
    double second_mm2 = unknown;
    double both_mm2 = unknown;  ///< of what lies in both
    double dice = unknown;      ///< 2 both / (first + second)
    double jaccard = unknown;   ///< both / (first + second - both)
    /// From points on the contours of each to the nearest of the other, over the length of both: by Simpson's rule along
    /// each edge.
    double mean_distance_mm = unknown;
    double hausdorff_mm = unknown;  ///< the largest of them, anywhere on edges, to a grid unit
};

struct Comparison {
    explicit Comparison(const Memory* memory = nullptr) noexcept : layers(memory) {}

    Array<LayerComparison> layers;
    LayerComparison stack;  ///< of all layers together, each as thick as its slab
};

struct CompareOptions {
    bool distances = true;  ///< else they stay unknown
};

/// The two have the same planes on the same grid. Of contours that bound no region yet, the rule non-zero makes one for
/// areas; distances are of contours as they are, those of flat ones left out.
///
/// Layers in parallel: areas as Overlay::combine(); distances O(q log q) for q points where the two lie near one another.
/// The same on every platform and number of threads. Errors: those of Overlay::combine(); invalid_argument (other planes,
/// with the first layer).
Result<Comparison> compare(const SliceResult& first, const SliceResult& second, const CompareOptions& options = {},
                           const Context& context = {}) noexcept;

}  // namespace lamella
