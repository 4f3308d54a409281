#include "lamella/medical/table.hpp"

#include <memory>
#include <variant>

#include <nlohmann/json.hpp>

#include "base/words.hpp"
#include "io/text/text.hpp"
#include "io/write/output_file.hpp"
#include "lamella/audit.hpp"
#include "lamella/check.hpp"
#include "lamella/io/text_file.hpp"
#include "lamella/measures.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

std::string json_text(const std::string& text) {
    return nlohmann::json(utf8_text(text)).dump();
}

/// A number that is NaN is not known.
using Cell = std::variant<std::string, std::uint64_t, double, std::vector<std::string>>;
/// Cells by the names of their columns.
using Row = std::vector<std::pair<std::string, Cell>>;

/// As CSV or JSON writes it.
std::string text_of(const Cell& cell, bool csv) {
    if (const auto* const text = std::get_if<std::string>(&cell)) {
        return csv ? csv_text(*text) : json_text(*text);
    }
    if (const auto* const count = std::get_if<std::uint64_t>(&cell)) {
        return std::to_string(*count);
    }
    if (const auto* const number = std::get_if<double>(&cell)) {
        return !std::isnan(*number) ? exact_text(*number + 0.0) : csv ? "" : "null";  // never -0
    }
    std::string list;
    for (const std::string& text : std::get<std::vector<std::string>>(cell)) {
        list += (list.empty() ? "" : csv ? "; " : ",") + (csv ? text : json_text(text));
    }
    return csv ? csv_text(list) : "[" + list + "]";
}

std::string names_line(const Row& row) {
    std::string line;
    for (const auto& [name, cell] : row) {
        line += (line.empty() ? "" : ",") + name;
    }
    return line + "\n";
}

/// `kind`: what a row of JSON is of.
std::string line_of(const Row& row, bool csv, const char* kind) {
    std::string line = csv ? "" : std::string("{\"kind\":\"") + kind + "\"";
    for (const auto& [name, cell] : row) {
        line += csv && &name == &row.front().first ? "" : ",";
        line += (csv ? "" : "\"" + name + "\":") + text_of(cell, csv);
    }
    return line + (csv ? "\n" : "}\n");
}

using Place = std::array<double, 3>;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Where something of a layer lies: in LPS where the layer is one of an image.
Place placed(const LayerView& view, double x_mm, double y_mm, const ImageGeometry* image) {
    const Place place = {x_mm, y_mm, view.cut_mm()};
    return image != nullptr ? image->to_lps(place) : place;
}

/// Least and largest coordinates of the points of contours.
std::array<Place, 2> reach_of(const LayerView& view, std::span<const Contour> contours, const ImageGeometry* image) {
    Place low = {unknown, unknown, unknown};
    Place high = low;
    for (const Contour& contour : contours) {
        for (const Point& point : view.points_of(contour)) {
            const Place at = placed(view, point.x * view.grid_mm, point.y * view.grid_mm, image);
            for (std::size_t axis = 0; axis < 3; ++axis) {  // of a number and NaN, these give the number
                low[axis] = std::fmin(low[axis], at[axis]);
                high[axis] = std::fmax(high[axis], at[axis]);
            }
        }
    }
    return {low, high};
}

/// With `image`, heights and places are the patient's, and the names say so. `contours`: those of the layer or the island.
Row section_row(const std::string& mesh, const LayerView& layer, const SectionMeasures& found,
                std::span<const Contour> contours, const ImageGeometry* image) {
    const auto count = [](std::int64_t number) { return static_cast<std::uint64_t>(number); };
    const char* const mm = image != nullptr ? "_lps_mm" : "_mm";
    std::array<std::pair<std::string, double>, 4> heights = {
        {{"height", layer.plane_mm}, {"cut", layer.cut_mm()}, {"bottom", layer.bottom_mm}, {"top", layer.top_mm}}};
    for (auto& [what, height] : heights) {
        height = image != nullptr ? image->height_lps_mm(height) : height;
    }
    if (heights[2].second > heights[3].second) {  // the slices follow one another downwards
        std::swap(heights[2].second, heights[3].second);
    }
    Row row = {{"mesh", text_of_name(mesh)}, {"layer", layer.index}};
    for (const auto& [what, height] : heights) {
        row.emplace_back(what + mm, height);
    }
    const auto flat = std::count_if(contours.begin(), contours.end(), [](const Contour& c) { return c.role == Role::flat; });
    row.insert(row.end(), {{"area_mm2", found.area_mm2},
                           {"perimeter_mm", found.perimeter_mm},
                           {"contours", contours.size()},
                           {"islands", count(found.islands)},
                           {"holes", count(found.holes)},
                           {"open", count(found.open)},
                           {"flat", count(flat)}});
    // Three coordinates in the patient, else two in the layer.
    const auto [low, high] = reach_of(layer, contours, image);
    const Place centroid = placed(layer, found.centroid_mm[0], found.centroid_mm[1], image);
    for (const auto& [what, place] : {std::pair{"centroid_", centroid}, {"min_", low}, {"max_", high}}) {
        for (std::size_t axis = 0; axis < (image != nullptr ? 3 : 2); ++axis) {
            row.emplace_back(std::string(what) + "xyz"[axis] + mm, place[axis]);
        }
    }
    row.insert(row.end(), {{"outer_area_mm2", found.outer_area_mm2},
                           {"outer_perimeter_mm", found.outer_perimeter_mm},
                           {"ix_mm4", found.ix_mm4},
                           {"iy_mm4", found.iy_mm4},
                           {"ixy_mm4", found.ixy_mm4},
                           {"imin_mm4", found.imin_mm4},
                           {"imax_mm4", found.imax_mm4},
                           {"angle_rad", found.angle_rad},
                           {"polar_mm4", found.polar_mm4},
                           {"feret_max_mm", found.feret_max_mm},
                           {"feret_min_mm", found.feret_min_mm},
                           {"feret_angle_rad", found.feret_angle_rad},
                           {"equivalent_diameter_mm", found.equivalent_diameter_mm},
                           {"circularity", found.circularity}});
    return row;
}

/// Of the whole mesh.
Row mesh_row(const TablePart& part) {
    const MeshFacts& facts = *part.facts;
    return {{"mesh", text_of_name(part.name)},  {"triangles", facts.triangles},     {"volume_mm3", facts.volume_mm3},
            {"surface_mm2", facts.surface_mm2}, {"certificate", facts.certificate}, {"warnings", facts.warnings}};
}

}  // namespace

/// A table that is being written.
struct TableFile : OutputStream {
    bool csv;
    std::string name;  ///< of the mesh
    std::optional<ImageGeometry> image;
    bool islands = false;  ///< a row each, not one a layer

    /// The format is that of the end of the file's name. Throws Refused, also where it is not that of a table.
    static TableFile begin(const std::string& name, const std::filesystem::path& path, const ImageGeometry* image,
                           bool islands) {
        const std::string end = lower_case(path.extension().string());
        if (end != ".csv" && end != ".jsonl") {
            refuse_output(path, "a table's name ends in .csv or .jsonl");
        }
        TableFile table{{require(OutputFile::create(path)), {}}, end == ".csv", name, {}};
        table.image = image != nullptr ? std::optional(*image) : std::nullopt;
        table.islands = islands;
        table.out.append(table.csv ? names_line(section_row({}, {}, {}, {}, image)) : "");
        return table;
    }

    void add(const std::string& mesh, const LayerView& layer) {
        const Measures found = require(measure(layer, {.islands = islands, .feret = true}));
        const auto write = [&](const SectionMeasures& row, std::span<const Contour> contours) {
            out.append(line_of(section_row(mesh, layer, row, contours, image ? &*image : nullptr), csv,
                               islands ? "island" : "layer"));
        };
        if (!islands) {
            write(found.layers[0], layer.contours);
        }
        for (const SectionMeasures& island : found.islands) {
            const auto first = static_cast<std::size_t>(island.contour) - layer.first_contour;
            write(island, layer.contours.subspan(first, 1 + static_cast<std::size_t>(island.holes)));
        }
    }
};

Result<MeshFacts> measure_facts(const MeshView& mesh, const SliceResult& result, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MeshFacts> {
        const MeshCheck found = require(check(mesh, {.counts_only = true}, context));
        const Audit answers = require(audit(result, mesh, {.open = false, .ledger = false, .crossings = false}, context));
        MeshFacts facts;
        facts.triangles = found.triangles;
        facts.volume_mm3 = found.closed ? found.volume_mm3 : unknown;
        facts.surface_mm2 = found.area_mm2;
        facts.certificate = words_for(*answers.volume);
        return facts;
    });
}

Status write_layer_table(std::span<const TablePart> parts, const std::filesystem::path& path, const ImageGeometry* image,
                         bool islands, const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        const PacedStop stop(context.stop);
        TableFile table = TableFile::begin({}, path, image, islands);
        std::string meshes;  // beside NAME.csv as NAME.meshes.csv, where something is known of a mesh
        for (const TablePart& part : parts) {
            if (part.facts != nullptr) {
                const Row row = mesh_row(part);
                const std::string line = line_of(row, table.csv, "mesh");
                table.out.append(table.csv ? "" : line);
                meshes += table.csv ? (meshes.empty() ? names_line(row) : "") + line : "";
            }
        }
        for (const TablePart& part : parts) {
            for (const LayerView layer : *part.result) {
                stop.stop_if_asked();
                table.add(part.name, layer);
            }
        }
        require(table.out.commit());
        return meshes.empty() ? Status()
                              : write_text_file(std::filesystem::path(path).replace_extension(".meshes.csv"), meshes);
    });
}

struct LayerTableStream::State : TableFile {};

LayerTableStream::LayerTableStream(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}
LayerTableStream::LayerTableStream(LayerTableStream&&) noexcept = default;
LayerTableStream& LayerTableStream::operator=(LayerTableStream&&) noexcept = default;
LayerTableStream::~LayerTableStream() = default;

Result<LayerTableStream> LayerTableStream::begin(const std::string& name, const std::filesystem::path& path,
                                                 const ImageGeometry* image, bool islands) noexcept {
    return guarded([&]() -> Result<LayerTableStream> {
        return LayerTableStream(std::make_unique<State>(State{TableFile::begin(name, path, image, islands)}));
    });
}

void LayerTableStream::add(const LayerView& layer) noexcept {
    state_->attempt([&] { state_->add(state_->name, layer); });
}

bool LayerTableStream::failed() const noexcept {
    return state_->failed();
}

Status LayerTableStream::finish() noexcept {
    return state_->finish();
}

}  // namespace lamella
