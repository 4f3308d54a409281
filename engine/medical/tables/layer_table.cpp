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

std::string json_text(const std::string& text) {
    return nlohmann::json(utf8_text(text)).dump();
}

/// A line of a table: the names of its cells, or the cells as CSV or JSON write them.
class Row {
public:
    enum class Form : std::uint8_t { names, csv, json };

    Row(Form form, const char* kind)
        : form_(form), line_(form == Form::json ? std::string("{\"kind\":\"") + kind + "\"" : std::string()) {}

    void add(const std::string& name, const std::string& csv, const std::string& json) {
        if (form_ == Form::json) {
            line_.append(",\"").append(name).append("\":").append(json);
        } else {
            line_.append(any_ ? "," : "").append(form_ == Form::names ? name : csv);
        }
        any_ = true;
    }
    void count(const std::string& name, std::uint64_t value) { add(name, std::to_string(value), std::to_string(value)); }
    /// NaN is not known: empty, or null.
    void number(const std::string& name, double value) {
        const std::string text = std::isnan(value) ? "" : exact_text(value + 0.0);  // never -0
        add(name, text, text.empty() ? "null" : text);
    }
    void text(const std::string& name, const std::string& value) { add(name, csv_text(value), json_text(value)); }

    std::string line() const { return line_ + (form_ == Form::json ? "}\n" : "\n"); }

private:
    Form form_;
    std::string line_;
    bool any_ = false;
};

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
std::string layer_line(Row::Form form, const std::string& mesh, const LayerView& layer, const ImageGeometry* image) {
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
    Row row(form, "layer");
    row.text("mesh", text_of_name(mesh));
    row.count("layer", layer.index);
    for (const auto& [what, height] : heights) {
        row.number(what + mm, height);
    }
    row.number("area_mm2", layer.area_mm2());
    row.number("perimeter_mm", found.perimeter_mm);
    row.count("contours", layer.contour_count);
    row.count("holes", role(Role::hole));
    row.count("open", role(Role::open));
    row.count("flat", role(Role::flat));
    // Three coordinates in the patient, else two in the layer.
    for (const auto& [what, place] : {std::pair{"centroid_", found.centroid}, {"min_", found.low}, {"max_", found.high}}) {
        for (std::size_t axis = 0; axis < (image != nullptr ? 3 : 2); ++axis) {
            row.number(std::string(what) + "xyz"[axis] + mm, place[axis]);
        }
    }
    return row.line();
}

/// Of the whole mesh.
std::string mesh_line(Row::Form form, const TablePart& part) {
    const MeshFacts& facts = *part.facts;
    std::string line;
    std::string list;
    for (const std::string& warning : facts.warnings) {
        line.append(line.empty() ? "" : "; ").append(warning);
        list.append(list.empty() ? "" : ",").append(json_text(warning));
    }
    Row row(form, "mesh");
    row.text("mesh", text_of_name(part.name));
    row.count("triangles", facts.triangles);
    row.number("volume_mm3", facts.volume_mm3);
    row.number("surface_mm2", facts.surface_mm2);
    row.text("certificate", facts.certificate);
    row.add("warnings", csv_text(line), "[" + list + "]");
    return row.line();
}

}  // namespace

/// A table that is being written.
struct TableFile {
    bool csv;
    std::string name;  ///< of the mesh
    std::optional<ImageGeometry> image;
    OutputFile out;
    Status done{};

    /// The format is that of the end of the name. Throws Refused, also where it is not that of a table.
    static TableFile begin(const std::string& name, const std::filesystem::path& path, const ImageGeometry* image) {
        const std::string end = lower_case(path.extension().string());
        if (end != ".csv" && end != ".jsonl") {
            refuse_output(path, "a table's name ends in .csv or .jsonl");
        }
        TableFile table{end == ".csv", name, image != nullptr ? std::optional(*image) : std::nullopt,
                        require(OutputFile::create(path))};
        table.out.append(table.csv ? layer_line(Row::Form::names, {}, {}, image) : "");
        return table;
    }

    void add(const std::string& mesh, const LayerView& layer) {
        out.append(layer_line(csv ? Row::Form::csv : Row::Form::json, mesh, layer, image ? &*image : nullptr));
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
            if (part.facts != nullptr && table.csv) {
                meshes += (meshes.empty() ? mesh_line(Row::Form::names, part) : "") + mesh_line(Row::Form::csv, part);
            } else if (part.facts != nullptr) {
                table.out.append(mesh_line(Row::Form::json, part));
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
    State& own = *state_;
    if (own.done) {
        own.done = guarded([&]() -> Status {
            own.add(own.name, layer);
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
