// A format of layer files: what it can hold, and how a file of it is written. Each has a source of its own beside this one.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/layer_file.hpp"

namespace lamella {

/// All that is known before the first layer.
struct LayerFilePlan {
    const SliceInfo& info;
    const LayerFileOptions& options;
    const std::filesystem::path& path;
    std::string name;  ///< of the file, for messages
    const Context& context;

    /// As given, or "part 1" for the first.
    std::string part_name(std::uint64_t part) const {
        return part < options.part_names.size() ? options.part_names[part] : "part " + std::to_string(part + 1);
    }
};

/// Writes a file that is open, layer by layer. Made when its first layer comes. Functions throw Refused, Stopped,
/// std::bad_alloc; after that no other is called. Layers that come are such as the format can hold, but contours of role
/// open come to all.
class LayerWriter {
public:
    LayerWriter() = default;
    virtual ~LayerWriter() = default;
    LayerWriter(const LayerWriter&) = delete;
    LayerWriter& operator=(const LayerWriter&) = delete;

    virtual void add(const LayerView& layer) = 0;
    /// What the file ends with. Where layers were none, the file is complete then too.
    virtual void finish() = 0;
    /// See LayerFileSummary.
    virtual double rounding_mm() const noexcept = 0;
    virtual std::uint64_t names_changed() const noexcept { return 0; }
};

/// A format, and its writer of an empty file.
struct LayerFormatMaker {
    LayerFormat format;
    std::unique_ptr<LayerWriter> (*make)(const LayerFilePlan& plan, OutputFile& out);
};

std::unique_ptr<LayerWriter> make_svg(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_cli(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_cli_text(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_slice_stack(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_dxf(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_geojson(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_vtp(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_sl1(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_sl1s(const LayerFilePlan& plan, OutputFile& out);
std::unique_ptr<LayerWriter> make_png_zip(const LayerFilePlan& plan, OutputFile& out);

}  // namespace lamella
