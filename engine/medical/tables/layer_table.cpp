#include "lamella/medical/table.hpp"

#include <memory>

#include <nlohmann/json.hpp>

#include "base/words.hpp"
#include "io/text/text.hpp"
#include "io/write/output_file.hpp"
#include "lamella/audit.hpp"
#include "lamella/check.hpp"
#include "lamella/io/text_file.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/raster/coverage.hpp"
#include "medical/tables/csv_text.hpp"

namespace lamella {

namespace {

/// A named value, as CSV and JSON write it.
struct Cell {
    std::string name;
    std::string csv;
    std::string json;
};

Cell count(std::string name, std::uint64_t value) {
    return {std::move(name), std::to_string(value), std::to_string(value)};
}

/// NaN is not known: empty, or null.
Cell number(std::string name, double value) {
    const std::string text = std::isnan(value) ? "" : exact_text(value + 0.0);  // never -0
    return {std::move(name), text, text.empty() ? "null" : text};
}

std::string json_text(const std::string& text) {
    return nlohmann::json(utf8_text(text)).dump();
}

Cell text(std::string name, const std::string& value) {
    return {std::move(name), csv_text(value), json_text(value)};
}

std::string csv_line(const std::vector<Cell>& cells, std::string Cell::*member) {
    std::string line;
    for (const Cell& cell : cells) {
        line.append(&cell == cells.data() ? "" : ",").append(cell.*member);
    }
    return line + "\n";
}

std::string json_line(const char* kind, const std::vector<Cell>& cells) {
    std::string line = std::string("{\"kind\":\"") + kind + "\"";
    for (const Cell& cell : cells) {
        line.append(",\"").append(cell.name).append("\":").append(cell.json);
    }
    return line + "}\n";
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

void add_heights(std::vector<Cell>& cells, const LayerView& layer, const ImageGeometry* image) {
    std::array<std::pair<const char*, double>, 4> heights = {
        {{"height", layer.plane_mm}, {"cut", layer.cut_mm()}, {"bottom", layer.bottom_mm}, {"top", layer.top_mm}}};
    if (image != nullptr) {
        for (auto& [what, mm] : heights) {
            mm = image->height_lps_mm(mm);
        }
        if (heights[2].second > heights[3].second) {  // the slices follow one another downwards
            std::swap(heights[2].second, heights[3].second);
        }
    }
    for (const auto& [what, mm] : heights) {
        cells.push_back(number(std::string(what) + (image != nullptr ? "_lps_mm" : "_mm"), mm));
    }
}

/// With `image`, heights and places are the patient's, and the names say so.
std::vector<Cell> cells_of(const std::string& mesh, const LayerView& layer, const ImageGeometry* image) {
    const Measures found = measure(layer, image);
    const auto role = [&](Role role) { return found.by_role[static_cast<std::size_t>(role)]; };
    std::vector<Cell> cells = {text("mesh", text_of_name(mesh)), count("layer", layer.index)};
    add_heights(cells, layer, image);
    cells.insert(cells.end(), {number("area_mm2", layer.area_mm2()), number("perimeter_mm", found.perimeter_mm),
                               count("contours", layer.contour_count), count("holes", role(Role::hole)),
                               count("open", role(Role::open)), count("flat", role(Role::flat))});
    // Three coordinates in the patient, else two in the layer.
    for (const auto& [what, place] : {std::pair{"centroid", found.centroid}, {"min", found.low}, {"max", found.high}}) {
        for (std::size_t axis = 0; axis < (image != nullptr ? 3 : 2); ++axis) {
            const std::string name = std::string(what) + "_" + "xyz"[axis];
            cells.push_back(number(name + (image != nullptr ? "_lps_mm" : "_mm"), place[axis]));
        }
    }
    return cells;
}

/// Of the whole mesh.
std::vector<Cell> cells_of(const TablePart& part) {
    const MeshFacts& facts = *part.facts;
    std::string line;
    std::string list;
    for (const std::string& warning : facts.warnings) {
        line.append(line.empty() ? "" : "; ").append(warning);
        list.append(list.empty() ? "" : ",").append(json_text(warning));
    }
    return {text("mesh", text_of_name(part.name)),  count("triangles", facts.triangles),
            number("volume_mm3", facts.volume_mm3), number("surface_mm2", facts.surface_mm2),
            text("certificate", facts.certificate), {"warnings", csv_text(line), "[" + list + "]"}};
}

}  // namespace

/// The head of a table, and its rows.
class TableText {
public:
    /// By the end of the name. Throws Refused where it is not that of a table.
    TableText(const std::filesystem::path& path, const ImageGeometry* image) {
        const std::string end = lower_case(path.extension().string());
        csv_ = end == ".csv";
        if (!csv_ && end != ".jsonl") {
            refuse_output(path, "a table's name ends in .csv or .jsonl");
        }
        if (image != nullptr) {
            image_ = *image;
        }
    }

    bool csv() const noexcept { return csv_; }
    std::string head() const { return csv_ ? csv_line(cells_of({}, {}, image()), &Cell::name) : ""; }
    std::string row(const std::string& mesh, const LayerView& layer) const {
        const std::vector<Cell> cells = cells_of(mesh, layer, image());
        return csv_ ? csv_line(cells, &Cell::csv) : json_line("layer", cells);
    }

private:
    const ImageGeometry* image() const noexcept { return image_ ? &*image_ : nullptr; }

    bool csv_;
    std::optional<ImageGeometry> image_;
};

namespace {

/// NAME.meshes.csv beside NAME.csv, where something is known of a mesh.
Status write_mesh_csv(std::span<const TablePart> parts, const std::filesystem::path& path) {
    std::string rows;
    for (const TablePart& part : parts) {
        if (part.facts != nullptr) {
            const std::vector<Cell> cells = cells_of(part);
            rows += (rows.empty() ? csv_line(cells, &Cell::name) : "") + csv_line(cells, &Cell::csv);
        }
    }
    return rows.empty() ? Status() : write_text_file(std::filesystem::path(path).replace_extension(".meshes.csv"), rows);
}

}  // namespace

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
        const TableText table(path, image);
        const PacedStop stop(context.stop);
        OutputFile file = require(OutputFile::create(path));
        file.append(table.head());
        for (const TablePart& part : parts) {
            file.append(!table.csv() && part.facts != nullptr ? json_line("mesh", cells_of(part)) : "");
        }
        for (const TablePart& part : parts) {
            for (const LayerView layer : *part.result) {
                stop.stop_if_asked();
                file.append(table.row(part.name, layer));
            }
        }
        require(file.commit());
        return table.csv() ? write_mesh_csv(parts, path) : Status();
    });
}

struct LayerTableStream::State {
    std::string name;
    TableText table;
    OutputFile out;
    Status done;
};

LayerTableStream::LayerTableStream(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}
LayerTableStream::LayerTableStream(LayerTableStream&&) noexcept = default;
LayerTableStream& LayerTableStream::operator=(LayerTableStream&&) noexcept = default;
LayerTableStream::~LayerTableStream() = default;

Result<LayerTableStream> LayerTableStream::begin(const std::string& name, const std::filesystem::path& path,
                                                 const ImageGeometry* image) noexcept {
    return guarded([&]() -> Result<LayerTableStream> {
        const TableText table(path, image);
        auto state = std::make_unique<State>(State{name, table, require(OutputFile::create(path)), {}});
        state->out.append(table.head());
        return LayerTableStream(std::move(state));
    });
}

void LayerTableStream::add(const LayerView& layer) noexcept {
    State& own = *state_;
    if (own.done) {
        own.done = guarded([&]() -> Status {
            own.out.append(own.table.row(own.name, layer));
            return {};
        });
    }
}

bool LayerTableStream::failed() const noexcept {
    return !state_->done || state_->out.failed();
}

Status LayerTableStream::finish() noexcept {
    return state_->done ? guarded([&] { return state_->out.commit(); }) : state_->done;
}

}  // namespace lamella
