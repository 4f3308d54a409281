#include "lamella/medical/table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/text/text.hpp"
#include "io/write/output_file.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/io/text_file.hpp"
#include "lamella/mesh/inspect.hpp"
#include "medical/raster/solid_contours.hpp"
#include "medical/tables/csv_text.hpp"
#include "slicing/result/layer_view.hpp"

namespace lamella {

namespace {

std::string number(double value) {
    return exact_text(value + 0.0);  // never -0
}

std::string number(std::uint64_t value) {
    return std::to_string(value);
}

/// NaN is not known.
std::optional<std::string> known(double value) {
    return std::isnan(value) ? std::nullopt : std::optional<std::string>(number(value));
}

using Place = std::array<double, 3>;

/// Measures of a layer's closed contours; empty where there are none. Where one is open, the solid is not known.
struct Measures {
    std::uint64_t holes = 0;
    std::uint64_t open = 0;
    std::uint64_t flat = 0;
    double perimeter_mm = 0;
    std::optional<Place> centroid;
    std::optional<std::array<Place, 2>> box_mm;  ///< least and largest coordinates
};

/// The sum of moments of a contour about one of its points, so that nothing cancels: six times the area times the centroid.
void add_moments(std::span<const Point> points, Point about, std::array<double, 3>& sums) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        const Point& q = points[i + 1 < points.size() ? i + 1 : 0];
        const double ax = static_cast<double>(std::int64_t{p.x} - about.x);
        const double ay = static_cast<double>(std::int64_t{p.y} - about.y);
        const double bx = static_cast<double>(std::int64_t{q.x} - about.x);
        const double by = static_cast<double>(std::int64_t{q.y} - about.y);
        const double area = ax * by - bx * ay;
        sums[0] += area;
        sums[1] += area * (ax + bx);
        sums[2] += area * (ay + by);
    }
}

void widen(std::optional<std::array<Place, 2>>& box, const Place& at) {
    if (!box) {
        box = {at, at};
    }
    for (std::size_t axis = 0; axis < at.size(); ++axis) {
        (*box)[0][axis] = std::min((*box)[0][axis], at[axis]);
        (*box)[1][axis] = std::max((*box)[1][axis], at[axis]);
    }
}

/// Places are in LPS where the layer is one of an image.
Measures measure(const LayerView& view, const ImageGeometry* image) {
    const auto placed = [&](PointMm at) {
        const Place place = {at.x, at.y, view.layer.plane.z() * view.unit_mm};
        return image != nullptr ? image->to_lps(place) : place;
    };
    Measures found;
    std::optional<Point> about;
    std::array<double, 3> sums{};
    for (const Contour& contour : view.contours) {
        const std::span<const Point> points = view.points_of(contour);
        found.holes += contour.role == Role::hole ? 1 : 0;
        found.open += contour.role == Role::open ? 1 : 0;
        found.flat += contour.role == Role::flat ? 1 : 0;
        for (const Point& point : points) {
            widen(found.box_mm, placed(view.to_mm(point)));
        }
        if (contour.role == Role::outer || contour.role == Role::hole) {
            about = about.value_or(points.front());
            add_moments(points, *about, sums);
            found.perimeter_mm += perimeter_of(points) * view.unit_mm;
        }
    }
    if (found.open > 0) {
        found.perimeter_mm = std::numeric_limits<double>::quiet_NaN();
    } else if (about && sums[0] != 0) {
        found.centroid = placed(
            {(about->x + sums[1] / (3 * sums[0])) * view.unit_mm, (about->y + sums[2] / (3 * sums[0])) * view.unit_mm});
    }
    return found;
}

/// A cell: its name, and its text or nothing.
struct Cell {
    std::string name;
    std::optional<std::string> text;
};

/// Three coordinates in the patient, else two in the layer.
void add_place(std::vector<Cell>& cells, const std::string& what, const std::optional<Place>& at,
               const ImageGeometry* image) {
    static constexpr std::array<char, 3> axes = {'x', 'y', 'z'};
    for (std::size_t axis = 0; axis < (image != nullptr ? 3 : 2); ++axis) {
        cells.push_back({what + "_" + axes[axis] + (image != nullptr ? "_lps_mm" : "_mm"),
                         at ? std::optional<std::string>(number((*at)[axis])) : std::nullopt});
    }
}

void add_heights(std::vector<Cell>& cells, const LayerView& view, const ImageGeometry* image) {
    const Layer& layer = view.layer;
    std::array<std::pair<const char*, double>, 4> heights = {{{"height", layer.plane_mm},
                                                              {"cut", layer.plane.z() * view.unit_mm},
                                                              {"bottom", layer.bottom_mm},
                                                              {"top", layer.top_mm}}};
    if (image != nullptr) {
        for (auto& [what, mm] : heights) {
            mm = image->height_lps_mm(mm);
        }
        if (heights[2].second > heights[3].second) {  // the slices follow one another downwards
            std::swap(heights[2].second, heights[3].second);
        }
    }
    for (const auto& [what, mm] : heights) {
        cells.push_back({std::string(what) + (image != nullptr ? "_lps_mm" : "_mm"), number(mm)});
    }
}

/// With `image`, heights and places are the patient's, and the names say so.
std::vector<Cell> cells_of(const LayerView& view, const ImageGeometry* image) {
    const Measures found = measure(view, image);
    std::vector<Cell> cells = {{"layer", number(view.index)}};
    add_heights(cells, view, image);
    cells.insert(cells.end(), {{"area_mm2", known(view.area_mm2())},
                               {"perimeter_mm", known(found.perimeter_mm)},
                               {"contours", number(view.layer.contour_count)},
                               {"holes", number(found.holes)},
                               {"open", number(found.open)},
                               {"flat", number(found.flat)}});
    add_place(cells, "centroid", found.centroid, image);
    add_place(cells, "min", found.box_mm ? std::optional(found.box_mm->front()) : std::nullopt, image);
    add_place(cells, "max", found.box_mm ? std::optional(found.box_mm->back()) : std::nullopt, image);
    return cells;
}

std::string json_text(const std::string& text) {
    return nlohmann::json(utf8_text(text)).dump();
}

std::string joined(const std::vector<std::string>& lines) {
    std::string all;
    for (const std::string& line : lines) {
        all += (all.empty() ? "" : "; ") + line;
    }
    return all;
}

}  // namespace

/// The head of a table, and its rows.
class TableText {
public:
    TableText(bool csv, const ImageGeometry* image) : csv_(csv) {
        if (image != nullptr) {
            image_ = *image;
        }
    }

    std::string head() const {
        std::string line;
        if (csv_) {
            line = "mesh";
            for (const Cell& cell : cells_of({}, image())) {
                line += "," + cell.name;
            }
            line += "\n";
        }
        return line;
    }

    std::string row(const std::string& mesh, const LayerView& view) const {
        std::string line =
            csv_ ? csv_text(text_of_name(mesh)) : "{\"kind\":\"layer\",\"mesh\":" + json_text(text_of_name(mesh));
        for (const Cell& cell : cells_of(view, image())) {
            line += csv_ ? "," + cell.text.value_or("") : ",\"" + cell.name + "\":" + cell.text.value_or("null");
        }
        return line + (csv_ ? "\n" : "}\n");
    }

private:
    const ImageGeometry* image() const noexcept { return image_ ? &*image_ : nullptr; }

    bool csv_;
    std::optional<ImageGeometry> image_;
};

namespace {

std::string mesh_csv_row(const TablePart& part) {
    const MeshFacts& facts = *part.facts;
    return csv_text(text_of_name(part.name)) + "," + number(facts.triangles) + "," + known(facts.volume_mm3).value_or("") +
           "," + number(facts.surface_mm2) + "," + csv_text(facts.certificate) + "," + csv_text(joined(facts.warnings)) +
           "\n";
}

std::string mesh_json_row(const TablePart& part) {
    const MeshFacts& facts = *part.facts;
    std::string warnings;
    for (const std::string& warning : facts.warnings) {
        warnings += (warnings.empty() ? "" : ",") + json_text(warning);
    }
    return "{\"kind\":\"mesh\",\"mesh\":" + json_text(text_of_name(part.name)) +
           ",\"triangles\":" + number(facts.triangles) + ",\"volume_mm3\":" + known(facts.volume_mm3).value_or("null") +
           ",\"surface_mm2\":" + number(facts.surface_mm2) + ",\"certificate\":" + json_text(facts.certificate) +
           ",\"warnings\":[" + warnings + "]}\n";
}

Status write_mesh_csv(std::span<const TablePart> parts, const std::filesystem::path& path) {
    std::string rows;
    for (const TablePart& part : parts) {
        rows += part.facts != nullptr ? mesh_csv_row(part) : "";
    }
    if (rows.empty()) {
        return {};
    }
    return write_text_file(std::filesystem::path(path).replace_extension(".meshes.csv"),
                           "mesh,triangles,volume_mm3,surface_mm2,certificate,warnings\n" + rows);
}

Status write_layers(std::span<const TablePart> parts, const std::filesystem::path& path, const Control& control, bool csv,
                    const ImageGeometry* image) {
    const PacedStop stop(control.stop);
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    const TableText text(csv, image);
    file->append(text.head());
    for (const TablePart& part : parts) {
        file->append(!csv && part.facts != nullptr ? mesh_json_row(part) : "");
    }
    for (const TablePart& part : parts) {
        for (std::uint64_t i = 0; i < part.result->layers.size(); ++i) {
            stop.stop_if_asked();
            file->append(text.row(part.name, view_of_layer(*part.result, i)));
        }
    }
    return file->commit();
}

/// Throws Refused where the name is not that of a table.
bool is_csv(const std::filesystem::path& path) {
    const std::string end = lower_case(path.extension().string());
    if (end != ".csv" && end != ".jsonl") {
        throw Refused{{ErrorCode::invalid_argument, "'" + path.string() + "': a table's name ends in .csv or .jsonl"}};
    }
    return end == ".csv";
}

}  // namespace

Result<MeshFacts> measure_facts(const MeshView& mesh, const Transform& to_mm, const SliceResult& result,
                                const Control& control) noexcept {
    return guarded(control, [&]() -> Result<MeshFacts> {
        const Result<MeshInfo> info = inspect(mesh, {.unit_mm = 0, .transform = to_mm, .control = control});
        if (!info) {
            return info.error();
        }
        const Result<VolumeCertificate> volume = certify_volume(mesh, result, control);
        if (!volume) {
            return volume.error();
        }
        MeshFacts facts;
        facts.triangles = info->triangles;
        facts.volume_mm3 = info->closed ? info->volume_mm3 : std::numeric_limits<double>::quiet_NaN();
        facts.surface_mm2 = info->area_mm2;
        facts.certificate = words_for(*volume);
        return facts;
    });
}

Status write_layer_table(std::span<const TablePart> parts, const std::filesystem::path& path, const Control& control,
                         const ImageGeometry* image) noexcept {
    return guarded(control, [&]() -> Status {
        const bool csv = is_csv(path);
        const Status layers = write_layers(parts, path, control, csv, image);
        return layers && csv ? write_mesh_csv(parts, path) : layers;
    });
}

struct LayerTableStream::State {
    std::string name;
    TableText text;
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
        const TableText text(is_csv(path), image);
        Result<OutputFile> file = OutputFile::create(path);
        if (!file) {
            return file.error();
        }
        file->append(text.head());
        auto state = std::make_unique<State>(State{name, text, std::move(file).value(), {}});
        return LayerTableStream(std::move(state));
    });
}

void LayerTableStream::add(const LayerView& layer) noexcept {
    State& own = *state_;
    if (own.done) {
        own.done = guarded([&]() -> Status {
            own.out.append(own.text.row(own.name, layer));
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
