// Files of layers, as the list of what happens:
//
//     begin     the format, by name or ending; the file, or the pattern of a file a layer
//     add       what the format cannot hold is counted, all else written
//     finish    the file is put in its place, or what was counted is the error
#include "lamella/io/layer_file.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/text/text.hpp"
#include "lamella/io/name_text.hpp"

namespace lamella {

namespace {

// clang-format off
constexpr bool yes = true;
constexpr bool no = false;
constexpr std::array makers = {
    //                                                                                open uneven single parts crossings screen
    LayerFormatMaker{{"svg", ".svg", "layered SVG in Slic3r's convention",
                      LayerHeight::plane,                                             yes, yes,   yes,   yes,  yes,      no}, make_svg},
    LayerFormatMaker{{"cli", ".cli", "Common Layer Interface 2.0, binary",
                      LayerHeight::top,                                               yes, yes,   no,    yes,  yes,      no}, make_cli},
    LayerFormatMaker{{"cli-text", ".cli", "Common Layer Interface 2.0, text",
                      LayerHeight::top,                                               yes, yes,   no,    yes,  yes,      no}, make_cli_text},
    LayerFormatMaker{{"3mf-slices", ".3mf", "3MF slice stack; its mesh is a box",
                      LayerHeight::top,                                               no,  yes,   no,    yes,  no,       no}, make_slice_stack},
    LayerFormatMaker{{"dxf", ".dxf", "DXF R12 polylines",
                      LayerHeight::plane,                                             yes, yes,   yes,   yes,  yes,      no}, make_dxf},
    LayerFormatMaker{{"geojson", ".geojson", "GeoJSON polygons, in mm",
                      LayerHeight::plane,                                             yes, yes,   yes,   yes,  no,       no}, make_geojson},
    LayerFormatMaker{{"vtp", ".vtp", "VTK XML polylines, in the mesh's frame",
                      LayerHeight::plane,                                             yes, yes,   no,    yes,  yes,      no}, make_vtp},
    LayerFormatMaker{{"sl1", ".sl1", "pictures for Prusa's SL1",
                      LayerHeight::top,                                               no,  no,    no,    no,   yes,     yes}, make_sl1},
    LayerFormatMaker{{"sl1s", ".sl1s", "the same for the SL1S",
                      LayerHeight::top,                                               no,  no,    no,    no,   yes,     yes}, make_sl1s},
    LayerFormatMaker{{"png-zip", ".zip", "PNG pictures for resin printers",
                      LayerHeight::top,                                               no,  no,    no,    no,   yes,     yes}, make_png_zip},
};
// clang-format on

constexpr auto all_formats = [] {
    std::array<LayerFormat, makers.size()> formats;
    for (std::size_t i = 0; i < makers.size(); ++i) {
        formats[i] = makers[i].format;
    }
    return formats;
}();

Refused refusal(const std::filesystem::path& path, const std::string& why) {
    return {{ErrorCode::invalid_argument, "'" + printable(path_text(path)) + "': " + why}};
}

std::string list_of(std::string_view LayerFormat::*member) {
    std::string all;
    for (const LayerFormat& format : all_formats) {
        if (all.find(format.*member) == std::string::npos) {
            all += (all.empty() ? "" : ", ") + std::string(format.*member);
        }
    }
    return all;
}

const LayerFormatMaker& format_of(const std::filesystem::path& path, std::string_view asked) {
    const std::string name = lower_case(path_text(path.filename()));
    for (const LayerFormatMaker& maker : makers) {
        if (asked.empty() ? name.ends_with(maker.format.ending) : asked == maker.format.name) {
            return maker;
        }
    }
    throw refusal(path, asked.empty()
                            ? "its name ends as no layer file does: " + list_of(&LayerFormat::ending)
                            : "'" + std::string(asked) + "' is no format of layer files: " + list_of(&LayerFormat::name));
}

}  // namespace

namespace layers {

/// The name of a layer's file, where a name has "{layer}" or "{layer:05}" in it.
class NumberedPath {
public:
    static std::optional<NumberedPath> of(const std::filesystem::path& path) {
        constexpr std::u8string_view start = u8"{layer";
        const std::u8string all = path.u8string();
        const std::size_t begin = all.find(start);
        const std::size_t end = all.find(u8'}', begin == all.npos ? 0 : begin);
        if (begin == all.npos || end == all.npos) {
            return std::nullopt;
        }
        NumberedPath numbered{all.substr(0, begin), all.substr(end + 1)};
        const std::u8string width = all.substr(begin + start.size(), end - begin - start.size());
        const bool is_width = width.size() == 3 && width.starts_with(u8":0") && width[2] >= u8'1' && width[2] <= u8'9';
        if (!width.empty() && !is_width) {
            throw refusal(path, "numbers of layers are {layer}, or {layer:05} for five digits");
        }
        numbered.digits_ = is_width ? static_cast<std::size_t>(width[2] - u8'0') : 1;
        return numbered;
    }

    std::filesystem::path of_layer(std::uint64_t layer) const {
        const std::string number = std::to_string(layer);
        std::u8string name = before_ + std::u8string(digits_ - std::min(digits_, number.size()), u8'0');
        name.append(number.begin(), number.end());
        return name + after_;
    }

private:
    NumberedPath(std::u8string before, std::u8string after) : before_(std::move(before)), after_(std::move(after)) {}

    std::u8string before_;
    std::u8string after_;
    std::size_t digits_ = 1;
};

/// How many layers have something, and the first of them.
struct Counted {
    std::uint64_t layers = 0;
    double first_mm = 0;

    void add(const LayerView& layer) {
        first_mm = layers == 0 ? layer.plane_mm : first_mm;
        ++layers;
    }
};

}  // namespace layers

struct LayerFile::State {
    State(const SliceInfo& of, std::filesystem::path to, const LayerFileOptions& asked, const Context& host)
        : info(of),
          path(std::move(to)),
          options(asked),
          stop(host.stop),
          context(host),
          maker(format_of(path, asked.format)) {
        context.stop = stop.check();
        summary.format = &maker.format;
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        for (const std::filesystem::path& file : written) {
            std::error_code ignored;
            std::filesystem::remove(file, ignored);
        }
    }

    void begin() {
        numbered = layers::NumberedPath::of(path);
        if (!numbered) {
            begin_file(path);
        } else if (!maker.format.single_layers) {
            throw refusal(path, std::string(maker.format.name) + " holds all layers in one file");
        }
    }

    void begin_file(const std::filesystem::path& file) {
        out.emplace(require(OutputFile::create(file)));
        writer = maker.make({info, options, file, printable(path_text(file)), context}, *out);
    }

    void end_file() {
        writer->finish();
        summary.rounding_mm = std::max(summary.rounding_mm, writer->rounding_mm());
        summary.names_changed = std::max(summary.names_changed, writer->names_changed());
        writer.reset();
        require(out->commit());
        ++summary.files;
    }

    void add(const LayerView& layer) {
        stop.stop_if_asked();
        if (!maker.format.crossings && info.options.region.rule_of(info.first_layer + layer.index) == FillRule::contours) {
            throw refusal(path, "needs a fill rule: without one contours may cross, which " +
                                    std::string(maker.format.name) + " cannot hold");
        }
        std::uint64_t open = 0;
        for (const Contour& contour : layer.contours) {
            open += contour.role == Role::open ? 1 : 0;
        }
        if (open > 0 && !maker.format.open_contours) {
            with_open.add(layer);
            summary.open_left_out += open;
        }
        const double height_mm = layer.top_mm - layer.bottom_mm;
        layer_mm = summary.layers == 0 ? height_mm : layer_mm;
        if (!maker.format.uneven_heights && std::abs(height_mm - layer_mm) > info.grid_mm) {
            uneven.add(layer);
        }
        ++summary.layers;
        if (is_refused()) {
            return;
        }
        summary.contours += layer.contours.size() - (maker.format.open_contours ? 0 : open);
        if (numbered) {
            const std::filesystem::path file = numbered->of_layer(info.first_layer + layer.index);
            begin_file(file);
            writer->add(layer);
            end_file();
            written.push_back(file);
        } else {
            writer->add(layer);
        }
    }

    bool is_refused() const noexcept { return (with_open.layers > 0 && !options.leave_out_open) || uneven.layers > 0; }

    LayerFileSummary finish() {
        const auto share = [this](const layers::Counted& some, const std::string& what) {
            return refusal(path, std::to_string(some.layers) + " of " + counted(summary.layers, "layer") + what +
                                     ", the first at z = " + exact_text(some.first_mm) + " mm, which " +
                                     std::string(maker.format.name) + " cannot hold");
        };
        if (uneven.layers > 0) {
            throw share(uneven, " differ from " + exact_text(layer_mm) + " mm in height");
        }
        if (is_refused()) {
            throw share(with_open, with_open.layers == 1 ? " has open contours" : " have open contours");
        }
        if (!numbered) {
            end_file();
        }
        written.clear();
        return summary;
    }

    const SliceInfo info;
    const std::filesystem::path path;
    const LayerFileOptions options;
    PacedStop stop;
    Context context;
    const LayerFormatMaker& maker;
    std::optional<layers::NumberedPath> numbered;
    std::optional<OutputFile> out;
    std::unique_ptr<LayerWriter> writer;
    std::vector<std::filesystem::path> written;  ///< of a file a layer: removed where the end is not reached
    LayerFileSummary summary;
    layers::Counted with_open;
    layers::Counted uneven;
    double layer_mm = 0;  ///< height of the first layer
    Status done{};
};

LayerFile::LayerFile(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}
LayerFile::LayerFile(LayerFile&&) noexcept = default;
LayerFile& LayerFile::operator=(LayerFile&&) noexcept = default;
LayerFile::~LayerFile() = default;

std::span<const LayerFormat> layer_formats() noexcept {
    return all_formats;
}

Result<LayerFile> LayerFile::begin(const SliceInfo& info, const std::filesystem::path& path, const LayerFileOptions& options,
                                   const Context& context) noexcept {
    return guarded(context, [&]() -> Result<LayerFile> {
        auto state = std::make_unique<State>(info, path, options, context);
        state->begin();
        return LayerFile(std::move(state));
    });
}

void LayerFile::add(const LayerView& layer) noexcept {
    if (state_->done) {
        state_->done = guarded([&]() -> Status {
            state_->add(layer);
            return {};
        });
    }
}

bool LayerFile::failed() const noexcept {
    return !state_->done || (state_->out && state_->out->failed());
}

Result<LayerFileSummary> LayerFile::finish() noexcept {
    if (!state_->done) {
        return state_->done.error();
    }
    return guarded([&]() -> Result<LayerFileSummary> { return state_->finish(); });
}

Result<LayerFileSummary> write_layers(const SliceResult& result, const std::filesystem::path& path,
                                      const LayerFileOptions& options, const Context& context) noexcept {
    Result<LayerFile> file = LayerFile::begin(result.info, path, options, context);
    if (!file) {
        return file.error();
    }
    ProgressMeter progress(context.progress);
    for (std::size_t index = 0; index < result.size() && !file->failed(); ++index) {
        file->add(result[index]);
        progress.reach(static_cast<double>(index) / static_cast<double>(result.size()));
    }
    Result<LayerFileSummary> summary = file->finish();
    if (summary) {
        progress.finish();
    }
    return summary;
}

}  // namespace lamella
