// Layered SVG: a picture of a result that printers and viewers of layers read too.
//
//     const lamella::Status written = lamella::write_svg(result, "layers.svg");
//     if (!written) {
//         std::fprintf(stderr, "%s\n", written.error().message.c_str());
//     }
#pragma once

#include <filesystem>
#include <memory>

#include "lamella/context.hpp"
#include "lamella/destination.hpp"
#include "lamella/error.hpp"
#include "lamella/result.hpp"
#include "lamella/weld.hpp"

namespace lamella {

struct SvgOptions {
    const WeldedMesh* welded = nullptr;  ///< what was sliced, if it was welded: the file then says so
};

/// Writes `result` in the convention of Slic3r: a `<g id="layerN" slic3r:z="mm" lamella:cut-z="mm">` per layer, with the
/// height asked for and the one cut (grid.hpp says how far apart they may be), in it a `<polygon>` of
/// `slic3r:type` contour, hole or flat per contour, and a `<polyline>` of type open per open one. Coordinates are in mm,
/// rounded to 1e-6 mm or to the grid, whichever is coarser. A transform turns y up, and the viewBox lies around the mesh.
/// `<desc>` holds the grid, the rounding rule, the datum and the frame.
///
/// The file is written aside and renamed when complete, so that no half-written one is left; a device or a pipe is written
/// in place, and /dev/stdout is standard output wherever that leads. O(points) time and 1 MiB of memory, on the calling
/// thread. Errors: unwritable_file, invalid_argument (negative threads), cancelled, out_of_memory.
Status write_svg(const SliceResult& result, const std::filesystem::path& path, const SvgOptions& options = {},
                 const Context& context = {}) noexcept;

/// The same file, layer by layer, of a result that is never held: begin() with what is known before the first layer, then
/// add() each layer in ascending order, then finish(). 1 MiB of memory, and 8 bytes an open polyline. Errors are kept, and
/// finish() returns the first; a stream that ends without it leaves no file.
class SvgStream {
public:
    /// `info` as LayerSink::begin gives it.
    static Result<SvgStream> begin(const SliceInfo& info, const std::filesystem::path& path, const SvgOptions& options = {},
                                   const Context& context = {}) noexcept;
    SvgStream(SvgStream&& other) noexcept;
    SvgStream& operator=(SvgStream&& other) noexcept;
    ~SvgStream();

    void add(const LayerView& layer) noexcept;
    /// Something failed: more layers are for nothing.
    bool failed() const noexcept;
    Status finish() noexcept;

private:
    struct State;
    explicit SvgStream(std::unique_ptr<State> state) noexcept;
    std::unique_ptr<State> state_;
};

}  // namespace lamella
