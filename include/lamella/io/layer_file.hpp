// Layer files: what printers, viewers and other programs read. One file for all layers, or a file a layer.
//
//     const auto written = lamella::write_layers(result, "part.cli");
//     if (written) {
//         std::printf("%llu contours\n", (unsigned long long)written->contours);
//     } else {
//         std::fprintf(stderr, "%s\n", written.error().message.c_str());
//     }
//
// The format is the one whose ending the name has, or the one that is asked for. What a format cannot hold, as LayerFormat
// says, is refused with how often it occurs: open contours (or, on request, left out and counted), layers of different
// heights. One that cannot hold contours which cross needs a fill rule.
//
// A name with {layer}, or {layer:05} for five digits, stands for a file a layer, numbered as in the plan, from 0:
// "out/{layer:05}.svg".
//
// A file is written aside and renamed when it is complete, so that no half-written one is left; a device or a pipe is
// written in place, and /dev/stdout is standard output wherever that leads. No file holds a clock: the same result has the
// same bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/io/screen.hpp"
#include "lamella/result.hpp"
#include "lamella/weld.hpp"

namespace lamella {

/// Which height of a layer a file states.
enum class LayerHeight : std::uint8_t { bottom, plane, top };

struct LayerFormat {
    std::string_view name;    ///< "cli-text"
    std::string_view ending;  ///< of file names, ".cli"; of several formats with one ending the first has it
    std::string_view what;    ///< "Common Layer Interface 2.0 as text"
    LayerHeight height;
    bool open_contours;   ///< can hold them
    bool uneven_heights;  ///< can hold layers of different heights
    bool single_layers;   ///< also serves as a file a layer
    bool parts;           ///< tells parts apart
    bool crossings;       ///< can hold contours that cross: else a fill rule has to be asked for
    bool on_screen;       ///< needs LayerFileOptions::screen
};

/// All of them.
std::span<const LayerFormat> layer_formats() noexcept;

struct LayerFileOptions {
    std::string_view format{};  ///< LayerFormat::name; empty: by the ending of the path
    /// Open contours are left out and counted where the format cannot hold them; else they are an error.
    bool leave_out_open = false;
    const WeldedMesh* welded = nullptr;         ///< what was sliced, if it was welded: SVG says so
    std::optional<Screen> screen{};             ///< that pictures are drawn for
    PrintTimes times{};                         ///< of SL1
    std::span<const std::string> part_names{};  ///< by Contour::part; those that lack one are "part 1" and so on
};

/// What was written.
struct LayerFileSummary {
    const LayerFormat* format = nullptr;
    std::uint64_t files = 0;
    std::uint64_t layers = 0;
    std::uint64_t contours = 0;
    std::uint64_t open_left_out = 0;
    std::uint64_t names_changed = 0;  ///< of parts: written with other characters
    double rounding_mm = 0;           ///< how far a written coordinate lies from the result's at most
};

/// O(points) time and 2 MiB of memory, on the calling thread; pictures of screens on the context's threads, with 6 MB and
/// the points of four layers each. 3mf-slices and vtp keep what does not fit in a file without a name beside the target, or
/// where there is no folder the system's for temporary files. Errors: unwritable_file, invalid_argument (no such format;
/// what the format cannot hold), cancelled, out_of_memory.
Result<LayerFileSummary> write_layers(const SliceResult& result, const std::filesystem::path& path,
                                      const LayerFileOptions& options = {}, const Context& context = {}) noexcept;

/// The same file, layer by layer, of a result that is never held: begin() with what is known before the first layer, then
/// add() each layer in ascending order, then finish(). Memory: 2 MiB, of SVG 8 bytes an open polyline. Errors are kept, and
/// finish() returns the first. One that ends without it leaves no file.
class LayerFile {
public:
    /// `info` as LayerSink::begin gives it. What `options` refer to must stay until the end.
    static Result<LayerFile> begin(const SliceInfo& info, const std::filesystem::path& path,
                                   const LayerFileOptions& options = {}, const Context& context = {}) noexcept;
    LayerFile(LayerFile&& other) noexcept;
    LayerFile& operator=(LayerFile&& other) noexcept;
    ~LayerFile();

    void add(const LayerView& layer) noexcept;
    /// Something failed: more layers are for nothing.
    bool failed() const noexcept;
    Result<LayerFileSummary> finish() noexcept;

private:
    struct State;
    explicit LayerFile(std::unique_ptr<State> state) noexcept;
    std::unique_ptr<State> state_;
};

}  // namespace lamella
