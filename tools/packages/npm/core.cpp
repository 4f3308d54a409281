// The calls of src/slicer.ts, which reads layers and contours in words of 8 bytes. A result stays until the next call.
#include <string>
#include <type_traits>

#include "lamella/lamella.h"
#include "lamella/slice.hpp"

static_assert(sizeof(lamella_layer) == 56 && offsetof(lamella_layer, contour_count) == 32);
static_assert(sizeof(lamella_contour) == 48 && offsetof(lamella_contour, role) == 40);

namespace {

lamella::Slicer slicer;
lamella::SliceResult result;
std::string text;

/// `given` holds a number for each option, or NaN, and then the heights.
lamella::SliceOptions options_of(const double* given, int heights) {
    lamella::SliceOptions to;
    const auto take = [&](auto&... it) {
        ((it = *given == *given ? static_cast<std::remove_reference_t<decltype(it)>>(*given) : it, ++given), ...);
    };
    take(to.layer_height_mm, to.planes.first_height_mm, to.planes.first_layer, to.planes.end_layer, to.stitch_mm,
         to.region.fill_rule, to.region.closing_mm, to.region.offset_mm, to.region.simplify_mm, to.frame.grid_mm);
    to.heights_mm = heights < 0 ? std::nullopt : std::optional(std::vector(given, given + heights));
    return to;
}

}  // namespace

/// The error's code and message, or null.
extern "C" __attribute__((used)) const char* slice(const double* given, int heights, const void* vertices, std::size_t count,
                                                   int type, const void* indices, std::size_t triangles, double unit) {
    lamella::MeshView mesh{vertices, count, triangles, indices};
    mesh.vertex_type = static_cast<lamella::Number>(type);
    mesh.mm_per_unit = unit;
    const lamella::Context context{.threads = 1, .memory_limit_bytes = std::uint64_t{1} << 31};  // half of 32 bits
    const auto done = slicer.slice_to(result, mesh, options_of(given, heights), context);
    text = done ? "" : lamella_status_name(static_cast<int>(done.error().code) + 1) + (' ' + done.error().message);
    return done ? nullptr : text.c_str();
}
/// Where the arrays of the result lie, the halves of its hash, the grid, and how much there is of what counters.inc names.
extern "C" __attribute__((used)) const double* found() {
    static double numbers[32];
    double* to = numbers;
    const std::uint64_t hash = result.hash();
    for (const auto place : {std::uintptr_t(result.layers.data()), std::uintptr_t(result.contours.data()),
                             std::uintptr_t(result.points.data()), std::uintptr_t(hash >> 32), std::uintptr_t(hash)}) {
        *to++ = static_cast<double>(place);
    }
    *to++ = result.info.grid_mm;
#define COUNTER(name) *to++ = static_cast<double>(result.info.name);
#include "options/counters.inc"
    return numbers;
}
