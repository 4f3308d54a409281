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
#include "medical/geometry/common.hpp"
#include "medical/raster/coverage.hpp"

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
constexpr Place nowhere = {unknown, unknown, unknown};

/// Measures of a layer's contours. Where one is open, the solid is not known.
struct Measures {
    std::array<std::uint64_t, 4> by_role{};
    double perimeter_mm = 0;
    Place centroid = nowhere;
    Place low = nowhere;  ///< least and largest coordinates
    Place high = nowhere;
};

/// The sum of moments of a contour about one of its points, so that nothing cancels: six times the area times the centroid.
void add_moments(std::span<const Point> points, Point about, std::array<double, 3>& sums) {
    const auto from_there = [&](const Point& point) {
        return PointMm{static_cast<double>(std::int64_t{point.x} - about.x),
                       static_cast<double>(std::int64_t{point.y} - about.y)};
    };
    PointMm a = from_there(points.front());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const PointMm b = from_there(points[i + 1 < points.size() ? i + 1 : 0]);
        const double area = a.x * b.y - a.y * b.x;
        sums[0] += area;
        sums[1] += area * (a.x + b.x);
        sums[2] += area * (a.y + b.y);
        a = b;
    }
}

/// Places are in LPS where the layer is one of an image.
Measures measure(const LayerView& view, const ImageGeometry* image) {
    const auto placed = [&](PointMm at) {
        const Place place = {at.x, at.y, view.cut_mm()};
        return image != nullptr ? image->to_lps(place) : place;
    };
    Measures found;
    std::optional<Point> about;
    std::array<double, 3> sums{};
    for (const Contour& contour : view.contours) {
        const std::span<const Point> points = view.points_of(contour);
        ++found.by_role[static_cast<std::size_t>(contour.role)];
        for (const Point& point : points) {
            const Place at = placed(view.to_mm(point));
            for (std::size_t axis = 0; axis < 3; ++axis) {  // of a number and NaN, these give the number
                found.low[axis] = std::fmin(found.low[axis], at[axis]);
                found.high[axis] = std::fmax(found.high[axis], at[axis]);
            }
        }
        if (contour.role == Role::outer || contour.role == Role::hole) {
            about = about.value_or(points.front());
            add_moments(points, *about, sums);
            found.perimeter_mm += perimeter_of(points) * view.grid_mm;
        }
    }
    if (found.by_role[static_cast<std::size_t>(Role::open)] > 0) {
        found.perimeter_mm = unknown;
    } else if (about && sums[0] != 0) {
        found.centroid = placed(
            {(about->x + sums[1] / (3 * sums[0])) * view.grid_mm, (about->y + sums[2] / (3 * sums[0])) * view.grid_mm});
    }
    return found;
}

/// With `image`, heights and places are the patient's, and the names say so.
Row layer_row(const std::string& mesh, const LayerView& layer, const ImageGeometry* image) {
    const Measures found = measure(layer, image);
    const auto role = [&](Role role) { return found.by_role[static_cast<std::size_t>(role)]; };
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
    row.insert(row.end(), {{"area_mm2", layer.area_mm2()},
                           {"perimeter_mm", found.perimeter_mm},
                           {"contours", layer.contour_count},
                           {"holes", role(Role::hole)},
                           {"open", role(Role::open)},
                           {"flat", role(Role::flat)}});
    // Three coordinates in the patient, else two in the layer.
    for (const auto& [what, place] : {std::pair{"centroid_", found.centroid}, {"min_", found.low}, {"max_", found.high}}) {
        for (std::size_t axis = 0; axis < (image != nullptr ? 3 : 2); ++axis) {
            row.emplace_back(std::string(what) + "xyz"[axis] + mm, place[axis]);
        }
    }
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

    /// The format is that of the end of the file's name. Throws Refused, also where it is not that of a table.
    static TableFile begin(const std::string& name, const std::filesystem::path& path, const ImageGeometry* image) {
        const std::string end = lower_case(path.extension().string());
        if (end != ".csv" && end != ".jsonl") {
            refuse_output(path, "a table's name ends in .csv or .jsonl");
        }
        TableFile table{{require(OutputFile::create(path)), {}}, end == ".csv", name, {}};
        table.image = image != nullptr ? std::optional(*image) : std::nullopt;
        table.out.append(table.csv ? names_line(layer_row({}, {}, image)) : "");
        return table;
    }

    void add(const std::string& mesh, const LayerView& layer) {
        out.append(line_of(layer_row(mesh, layer, image ? &*image : nullptr), csv, "layer"));
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
                         const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        const PacedStop stop(context.stop);
        TableFile table = TableFile::begin({}, path, image);
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
                                                 const ImageGeometry* image) noexcept {
    return guarded([&]() -> Result<LayerTableStream> {
        return LayerTableStream(std::make_unique<State>(State{TableFile::begin(name, path, image)}));
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
