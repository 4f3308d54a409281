#include "lamella/medical/table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "base/guard.hpp"
#include "io/write/output_file.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/mesh/inspect.hpp"
#include "medical/tables/csv_text.hpp"
#include "slicing/result/layer_view.hpp"

namespace lamella {

namespace {

std::string number(double value) {
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value + 0.0).ptr};
}

std::string number(std::uint64_t value) {
    return std::to_string(value);
}

/// NaN is not known.
std::optional<std::string> known(double value) {
    return std::isnan(value) ? std::nullopt : std::optional<std::string>(number(value));
}

/// What a layer's closed contours measure; empty where there are none. Where one is open, what is solid is not known.
struct Measures {
    std::uint64_t holes = 0;
    std::uint64_t open = 0;
    std::uint64_t flat = 0;
    double perimeter_mm = 0;
    std::optional<PointMm> centroid;
    std::optional<std::array<double, 4>> box_mm;  ///< least x, least y, largest x, largest y
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

double perimeter(std::span<const Point> points) {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        const Point& q = points[i + 1 < points.size() ? i + 1 : 0];
        sum += std::sqrt(std::pow(static_cast<double>(std::int64_t{q.x} - p.x), 2) +
                         std::pow(static_cast<double>(std::int64_t{q.y} - p.y), 2));
    }
    return sum;
}

void widen(std::optional<std::array<double, 4>>& box, PointMm at) {
    if (!box) {
        box = {at.x, at.y, at.x, at.y};
    }
    *box = {std::min((*box)[0], at.x), std::min((*box)[1], at.y), std::max((*box)[2], at.x), std::max((*box)[3], at.y)};
}

Measures measure(const LayerView& view) {
    Measures found;
    std::optional<Point> about;
    std::array<double, 3> sums{};
    for (const Contour& contour : view.contours) {
        const std::span<const Point> points = view.points_of(contour);
        found.holes += contour.role == Role::hole ? 1 : 0;
        found.open += contour.role == Role::open ? 1 : 0;
        found.flat += contour.role == Role::flat ? 1 : 0;
        for (const Point& point : points) {
            widen(found.box_mm, view.to_mm(point));
        }
        if (contour.role == Role::outer || contour.role == Role::hole) {
            about = about.value_or(points.front());
            add_moments(points, *about, sums);
            found.perimeter_mm += perimeter(points) * view.unit_mm;
        }
    }
    if (found.open > 0) {
        found.perimeter_mm = std::numeric_limits<double>::quiet_NaN();
    } else if (about && sums[0] != 0) {
        found.centroid = PointMm{(about->x + sums[1] / (3 * sums[0])) * view.unit_mm,
                                 (about->y + sums[2] / (3 * sums[0])) * view.unit_mm};
    }
    return found;
}

/// A cell: its name, and its text or nothing.
struct Cell {
    std::string_view name;
    std::optional<std::string> text;
};

std::vector<Cell> cells_of(const LayerView& view) {
    const Layer& layer = view.layer;
    const Measures found = measure(view);
    const auto from_box = [&](std::size_t i) {
        return found.box_mm ? std::optional<std::string>(number((*found.box_mm)[i])) : std::nullopt;
    };
    const auto centroid = [&](double PointMm::*axis) {
        return found.centroid ? std::optional<std::string>(number((*found.centroid).*axis)) : std::nullopt;
    };
    return {{"layer", number(view.index)},
            {"height_mm", number(layer.plane_mm)},
            {"cut_mm", number(layer.plane.z() * view.unit_mm)},
            {"bottom_mm", number(layer.bottom_mm)},
            {"top_mm", number(layer.top_mm)},
            {"area_mm2", known(view.area_mm2())},
            {"perimeter_mm", known(found.perimeter_mm)},
            {"contours", number(layer.contour_count)},
            {"holes", number(found.holes)},
            {"open", number(found.open)},
            {"flat", number(found.flat)},
            {"centroid_x_mm", centroid(&PointMm::x)},
            {"centroid_y_mm", centroid(&PointMm::y)},
            {"min_x_mm", from_box(0)},
            {"min_y_mm", from_box(1)},
            {"max_x_mm", from_box(2)},
            {"max_y_mm", from_box(3)}};
}

/// A JSON string.
std::string json_text(const std::string& text) {
    std::string all = "\"";
    for (const char c : utf8_text(text)) {
        if (c == '"' || c == '\\') {
            all += std::string("\\") + c;
        } else if (static_cast<unsigned char>(c) < ' ') {
            std::array<char, 8> code{};
            (void)std::snprintf(code.data(), code.size(), "\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(c)));
            all += code.data();
        } else {
            all += c;
        }
    }
    return all + "\"";
}

std::string joined(const std::vector<std::string>& lines) {
    std::string all;
    for (const std::string& line : lines) {
        all += (all.empty() ? "" : "; ") + line;
    }
    return all;
}

constexpr std::string_view csv_head =
    "mesh,layer,height_mm,cut_mm,bottom_mm,top_mm,area_mm2,perimeter_mm,contours,holes,open,flat,centroid_x_mm,"
    "centroid_y_mm,min_x_mm,min_y_mm,max_x_mm,max_y_mm\n";

std::string csv_row(const std::string& mesh, const LayerView& view) {
    std::string line = csv_text(text_of_name(mesh));
    for (const Cell& cell : cells_of(view)) {
        line += "," + cell.text.value_or("");
    }
    return line + "\n";
}

std::string json_row(const std::string& mesh, const LayerView& view) {
    std::string line = "{\"kind\":\"layer\",\"mesh\":" + json_text(text_of_name(mesh));
    for (const Cell& cell : cells_of(view)) {
        line += ",\"" + std::string(cell.name) + "\":" + cell.text.value_or("null");
    }
    return line + "}\n";
}

Status write_csv(std::span<const TablePart> parts, const std::filesystem::path& path, const Control& control) {
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    file->append(csv_head);
    for (const TablePart& part : parts) {
        for (std::uint64_t i = 0; i < part.result->layers.size(); ++i) {
            stop_if_asked(control);
            file->append(csv_row(part.name, view_of_layer(*part.result, i)));
        }
    }
    return file->commit();
}

Status write_mesh_csv(std::span<const TablePart> parts, const std::filesystem::path& path) {
    if (std::none_of(parts.begin(), parts.end(), [](const TablePart& part) { return part.facts != nullptr; })) {
        return {};
    }
    Result<OutputFile> file = OutputFile::create(std::filesystem::path(path).replace_extension(".meshes.csv"));
    if (!file) {
        return file.error();
    }
    file->append("mesh,triangles,volume_mm3,surface_mm2,certificate,warnings\n");
    for (const TablePart& part : parts) {
        if (part.facts != nullptr) {
            const MeshFacts& facts = *part.facts;
            file->append(csv_text(text_of_name(part.name)) + "," + number(facts.triangles) + "," +
                         known(facts.volume_mm3).value_or("") + "," + number(facts.surface_mm2) + "," +
                         csv_text(facts.certificate) + "," + csv_text(joined(facts.warnings)) + "\n");
        }
    }
    return file->commit();
}

Status write_json_lines(std::span<const TablePart> parts, const std::filesystem::path& path, const Control& control) {
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    for (const TablePart& part : parts) {
        if (part.facts != nullptr) {
            const MeshFacts& facts = *part.facts;
            std::string warnings;
            for (const std::string& warning : facts.warnings) {
                warnings += (warnings.empty() ? "" : ",") + json_text(warning);
            }
            file->append("{\"kind\":\"mesh\",\"mesh\":" + json_text(text_of_name(part.name)) + ",\"triangles\":" +
                         number(facts.triangles) + ",\"volume_mm3\":" + known(facts.volume_mm3).value_or("null") +
                         ",\"surface_mm2\":" + number(facts.surface_mm2) +
                         ",\"certificate\":" + json_text(facts.certificate) + ",\"warnings\":[" + warnings + "]}\n");
        }
    }
    for (const TablePart& part : parts) {
        for (std::uint64_t i = 0; i < part.result->layers.size(); ++i) {
            stop_if_asked(control);
            file->append(json_row(part.name, view_of_layer(*part.result, i)));
        }
    }
    return file->commit();
}

Error not_a_table(const std::filesystem::path& path) {
    return {ErrorCode::invalid_argument, "'" + path.string() + "': a table's name ends in .csv or .jsonl"};
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
        facts.certificate = volume->verdict == VolumeVerdict::holds
                                ? "certified"
                                : "not certified: " + std::string(name_of(volume->verdict));
        return facts;
    });
}

Status write_layer_table(std::span<const TablePart> parts, const std::filesystem::path& path,
                         const Control& control) noexcept {
    return guarded(control, [&]() -> Status {
        if (path.extension() == ".csv") {
            const Status layers = write_csv(parts, path, control);
            return layers ? write_mesh_csv(parts, path) : layers;
        }
        if (path.extension() == ".jsonl") {
            return write_json_lines(parts, path, control);
        }
        return not_a_table(path);
    });
}

struct LayerTableStream::State {
    std::string name;
    bool csv;
    OutputFile out;
    Status done;
};

LayerTableStream::LayerTableStream(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}
LayerTableStream::LayerTableStream(LayerTableStream&&) noexcept = default;
LayerTableStream& LayerTableStream::operator=(LayerTableStream&&) noexcept = default;
LayerTableStream::~LayerTableStream() = default;

Result<LayerTableStream> LayerTableStream::begin(const std::string& name, const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Result<LayerTableStream> {
        const bool csv = path.extension() == ".csv";
        if (!csv && path.extension() != ".jsonl") {
            return not_a_table(path);
        }
        Result<OutputFile> file = OutputFile::create(path);
        if (!file) {
            return file.error();
        }
        auto state = std::make_unique<State>(State{name, csv, std::move(file).value(), {}});
        if (csv) {
            state->out.append(csv_head);
        }
        return LayerTableStream(std::move(state));
    });
}

void LayerTableStream::add(const LayerView& layer) noexcept {
    State& own = *state_;
    if (own.done) {
        own.done = guarded([&]() -> Status {
            own.out.append(own.csv ? csv_row(own.name, layer) : json_row(own.name, layer));
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
