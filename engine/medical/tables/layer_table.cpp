#include "lamella/medical/table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string_view>

#include "base/guard.hpp"
#include "io/write/output_file.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/mesh/inspect.hpp"
#include "medical/tables/csv_text.hpp"

namespace lamella {

namespace {

std::string number(double value) {
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value + 0.0).ptr};
}

std::string number(std::uint64_t value) {
    return std::to_string(value);
}

/// What a layer's closed contours measure; empty where there are none.
struct Measures {
    std::uint64_t holes = 0;
    std::uint64_t open = 0;
    std::uint64_t flat = 0;
    double perimeter_mm = 0;
    std::optional<PointMm> centroid;
    std::optional<std::array<double, 4>> box_mm;  ///< least x, least y, largest x, largest y
};

/// The sum of moments of a contour about one of its points, so that nothing cancels: six times the area times the centroid.
void add_moments(const SliceResult& result, const Contour& contour, Point about, std::array<double, 3>& sums) {
    const std::span<const Point> points = result.points_of(contour);
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

double perimeter_mm(const SliceResult& result, const Contour& contour) {
    const std::span<const Point> points = result.points_of(contour);
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        const Point& q = points[i + 1 < points.size() ? i + 1 : 0];
        sum += std::sqrt(std::pow(static_cast<double>(std::int64_t{q.x} - p.x), 2) +
                         std::pow(static_cast<double>(std::int64_t{q.y} - p.y), 2));
    }
    return sum * result.unit_mm;
}

void widen(std::optional<std::array<double, 4>>& box, PointMm at) {
    if (!box) {
        box = {at.x, at.y, at.x, at.y};
    }
    *box = {std::min((*box)[0], at.x), std::min((*box)[1], at.y), std::max((*box)[2], at.x), std::max((*box)[3], at.y)};
}

Measures measure(const SliceResult& result, const Layer& layer) {
    Measures found;
    std::optional<Point> about;
    std::array<double, 3> sums{};
    for (const Contour& contour : result.contours_of(layer)) {
        found.holes += contour.role == Role::hole ? 1 : 0;
        found.open += contour.role == Role::open ? 1 : 0;
        found.flat += contour.role == Role::flat ? 1 : 0;
        for (const Point& point : result.points_of(contour)) {
            widen(found.box_mm, result.to_mm(point));
        }
        if (contour.role == Role::outer || contour.role == Role::hole) {
            about = about.value_or(result.points_of(contour).front());
            add_moments(result, contour, *about, sums);
            found.perimeter_mm += perimeter_mm(result, contour);
        }
    }
    if (about && sums[0] != 0) {
        found.centroid = PointMm{(about->x + sums[1] / (3 * sums[0])) * result.unit_mm,
                                 (about->y + sums[2] / (3 * sums[0])) * result.unit_mm};
    }
    return found;
}

/// A cell: its name, and its text or nothing.
struct Cell {
    std::string_view name;
    std::optional<std::string> text;
};

std::vector<Cell> cells_of(const TablePart& part, std::uint64_t index) {
    const SliceResult& result = *part.result;
    const Layer& layer = result.layers[index];
    const Measures found = measure(result, layer);
    const auto from_box = [&](std::size_t i) {
        return found.box_mm ? std::optional<std::string>(number((*found.box_mm)[i])) : std::nullopt;
    };
    const auto centroid = [&](double PointMm::*axis) {
        return found.centroid ? std::optional<std::string>(number((*found.centroid).*axis)) : std::nullopt;
    };
    return {{"layer", number(index)},
            {"height_mm", number(layer.plane_mm)},
            {"cut_mm", number(result.to_mm(layer.plane))},
            {"bottom_mm", number(layer.bottom_mm)},
            {"top_mm", number(layer.top_mm)},
            {"area_mm2", number(result.area_mm2(layer))},
            {"perimeter_mm", number(found.perimeter_mm)},
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

/// A JSON string; bytes that are not ASCII stay as they are.
std::string json_text(const std::string& text) {
    std::string all = "\"";
    for (const char c : text) {
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

Status write_csv(std::span<const TablePart> parts, const std::filesystem::path& path, const Control& control) {
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    file->append(
        "mesh,layer,height_mm,cut_mm,bottom_mm,top_mm,area_mm2,perimeter_mm,contours,holes,open,flat,centroid_x_mm,"
        "centroid_y_mm,min_x_mm,min_y_mm,max_x_mm,max_y_mm\n");
    for (const TablePart& part : parts) {
        for (std::uint64_t i = 0; i < part.result->layers.size(); ++i) {
            stop_if_asked(control);
            std::string line = csv_text(part.name);
            for (const Cell& cell : cells_of(part, i)) {
                line += "," + cell.text.value_or("");
            }
            file->append(line + "\n");
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
            file->append(csv_text(part.name) + "," + number(facts.triangles) + "," + number(facts.volume_mm3) + "," +
                         number(facts.surface_mm2) + "," + csv_text(facts.certificate) + "," +
                         csv_text(joined(facts.warnings)) + "\n");
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
            file->append("{\"kind\":\"mesh\",\"mesh\":" + json_text(part.name) +
                         ",\"triangles\":" + number(facts.triangles) + ",\"volume_mm3\":" + number(facts.volume_mm3) +
                         ",\"surface_mm2\":" + number(facts.surface_mm2) +
                         ",\"certificate\":" + json_text(facts.certificate) + ",\"warnings\":[" + warnings + "]}\n");
        }
    }
    for (const TablePart& part : parts) {
        for (std::uint64_t i = 0; i < part.result->layers.size(); ++i) {
            stop_if_asked(control);
            std::string line = "{\"kind\":\"layer\",\"mesh\":" + json_text(part.name);
            for (const Cell& cell : cells_of(part, i)) {
                line += ",\"" + std::string(cell.name) + "\":" + cell.text.value_or("null");
            }
            file->append(line + "}\n");
        }
    }
    return file->commit();
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
        facts.volume_mm3 = info->volume_mm3;
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
        return Error{ErrorCode::invalid_argument, "'" + path.string() + "': a table's name ends in .csv or .jsonl"};
    });
}

}  // namespace lamella
