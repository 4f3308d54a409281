// Lengths of the host in the library. Part of the adapter, under its licence: AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <lamella/grid.hpp>

namespace Slic3r::lamella_adapter {

/// The library works in a frame of its own: 2^20 of the host's units of 1e-6 mm are what it calls a millimetre, so that its
/// default unit, 2^-20 mm, is the host's unit. A mesh too large for that gets a larger power of two by itself. In this frame
/// the library reads floats fastest.
inline constexpr float frame_per_mm = 15625.0F / 16384;
static_assert(frame_per_mm * 0x1p20 == 1e6 && lamella::default_unit_mm == 0x1p-20);

/// Rounds to float, as the host does where it scales a coordinate.
constexpr float in_frame(float mm) {
    return mm * frame_per_mm;
}

}  // namespace Slic3r::lamella_adapter
