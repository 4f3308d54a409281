// What stays open in a result, and how far ends would have to be joined: layers of which area and centroid are not known.
//
//     const lamella::Result<lamella::OpenLayers> open = lamella::find_open_layers(result);
//     if (open && open->layers > 0) {
//         std::printf("%s\n", describe(*open, "close_gaps_mm = ").c_str());
//     }
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/result.hpp"
#include "lamella/sink.hpp"

namespace lamella {

struct OpenLayers {
    std::uint64_t layers = 0;   ///< with open polylines
    std::uint64_t crossed = 0;  ///< layers that the mesh crosses
    std::uint64_t stuck = 0;    ///< of `layers`: those that stay open however far apart ends may be joined
    double height_mm = 0;       ///< of `layers`, from bottom to top
    double crossed_mm = 0;      ///< of `crossed`
    double reach_mm = 0;        ///< SliceOptions::close_gaps_mm that closes all but `stuck`, and what is closed already

    /// The share of the crossed height that `layers` stand for; of the crossed layers where these have no height.
    double share() const noexcept;
    /// Adds the layers of another range. Sums depend on the order in their last bits.
    void add(const OpenLayers& other) noexcept;
};

/// What one layer adds, its open polylines joined nearest first, each part by itself. O(contours), and for o open ones
/// O(o log o) unless they lie so that searches are slow. Errors: out_of_memory, cancelled.
Result<OpenLayers> find_open_layer(const LayerView& layer, GapSense sense = GapSense::kept,
                                   const StopCheck& stop = {}) noexcept;

/// Of all layers, by the result's own sense of gaps. The answer does not depend on threads. Errors: out_of_memory,
/// cancelled, invalid_argument (negative threads).
Result<OpenLayers> find_open_layers(const SliceResult& result, const Control& control = {}) noexcept;

/// "37 of 412 layers (8.1 % of the height) have open contours: their area is not known; --close-gaps 0.73 would close
/// them", where `option` is what stands before the length, here "--close-gaps ". The length is reach_mm, rounded up to two
/// digits. May throw std::bad_alloc.
std::string describe(const OpenLayers& open, std::string_view option);

}  // namespace lamella
