// The report: what was asked, what was found, what it cost, as JSON.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <new>
#include <string>

#include <nlohmann/json.hpp>

#include "9_write/describe.hpp"
#include "9_write/output_file.hpp"
#include "lamella/write.hpp"

namespace lamella {

namespace {

using Json = nlohmann::ordered_json;

/// So many places of a kind are listed; the counts are of all.
constexpr std::size_t most_places = 100;

Json spacing_json(const UniformLayers& layers) {
    return {{"kind", "uniform"},
            {"layer_height_mm", layers.layer_height_mm},
            {"first_height_mm", layers.first_height_mm ? Json(*layers.first_height_mm) : Json(nullptr)},
            {"datum", name_of(layers.datum)}};
}

Json spacing_json(const ExplicitPlanes& planes) {
    return {{"kind", "explicit"}, {"heights", planes.heights_mm.size()}};
}

Json spacing_json(const RandomLayers& layers) {
    return {{"kind", "random"},
            {"min_height_mm", layers.min_height_mm},
            {"max_height_mm", layers.max_height_mm},
            {"seed", layers.seed},
            {"datum", name_of(Datum::mesh_min)}};
}

Json plan_json(const LayerPlan& plan) {
    Json json = std::visit([](const auto& spacing) { return spacing_json(spacing); }, plan.spacing);
    json["side"] = name_of(plan.side);
    json["rule"] = describe(plan);
    return json;
}

double solid_volume_mm3(const SliceResult& result) {
    double volume = 0;
    for (const Layer& layer : result.layers) {
        volume += result.area_mm2(layer) * (layer.top_mm - layer.bottom_mm);
    }
    return volume;
}

/// As text: readers of JSON keep 53 bits of a number.
std::string hex(std::uint64_t value) {
    std::array<char, 16> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value, 16);
    const std::string text(digits.data(), error == std::errc() ? end : digits.data());
    return std::string(digits.size() - text.size(), '0') + text;
}

Json counts_json(const SliceResult& result) {
    const SliceSummary& summary = result.summary;
    return {{"triangles", summary.triangles},
            {"degenerate", summary.degenerate},
            {"crossed", summary.crossed},
            {"planes", result.layers.size()},
            {"segments", summary.segments},
            {"points", result.points.size()},
            {"contours", result.contours.size()},
            {"open_contours", summary.open_contours},
            {"holes", summary.holes},
            {"flat_contours", summary.flat_contours},
            {"overruled_contours", summary.overruled_contours}};
}

Json times_json(const StageTimes& stages, const ReportContext& context) {
    return {{"read", context.read_ms},   {"parse", context.parse_ms},   {"bucket", stages.bucket},
            {"sweep", stages.sweep},     {"contours", stages.contours}, {"nesting", stages.nesting},
            {"write", context.write_ms}, {"total", context.total_ms}};
}

Json file_json(const MeshFile& file) {
    return {
        {"format", name_of(file.format)},
        {"text", file.text},
        {"compressed", file.compressed},
        {"bytes", file.file_bytes},
        {"mm_per_unit", file.mm_per_unit},
        {"states_unit", file.states_unit},
        {"patient_frame", file.patient_frame == PatientFrame::unstated ? Json(nullptr) : Json(name_of(file.patient_frame))}};
}

/// A place in a layer, mm.
Json place_json(const SliceResult& result, const Point& point) {
    return {point.x * result.unit_mm, point.y * result.unit_mm};
}

Json gaps_json(const SliceResult& result) {
    double longest = 0;
    Json first = Json::array();
    for (const ClosedGap& gap : result.closed_gaps) {
        const double length = result.length_mm(gap);
        longest = std::max(longest, length);
        if (first.size() < most_places) {
            first.push_back({{"layer", gap.layer},
                             {"plane_mm", result.layers[gap.layer].plane_mm},
                             {"from_mm", place_json(result, gap.from)},
                             {"to_mm", place_json(result, gap.to)},
                             {"length_mm", length}});
        }
    }
    return {{"reach_mm", result.close_gaps_mm},
            {"closed", result.closed_gaps.size()},
            {"longest_mm", longest},
            {"first", first}};
}

/// The first open polylines: where each ends and where it starts, between which the mesh lacks faces.
Json open_json(const SliceResult& result) {
    Json first = Json::array();
    for (std::size_t l = 0; l < result.layers.size() && first.size() < most_places; ++l) {
        for (const Contour& contour : result.contours_of(result.layers[l])) {
            if (contour.role != Role::open || first.size() >= most_places) {
                continue;
            }
            const std::span<const Point> points = result.points_of(contour);
            first.push_back({{"layer", l},
                             {"plane_mm", result.layers[l].plane_mm},
                             {"from_mm", place_json(result, points.back())},
                             {"to_mm", place_json(result, points.front())},
                             {"gap_mm", result.length_mm({l, points.back(), points.front()})}});
        }
    }
    return first;
}

Json ledger_json(const Ledger& ledger) {
    Json slabs = Json::array();
    for (std::size_t i = 0; i < std::min(ledger.slabs.size(), most_places); ++i) {
        const Slab& slab = ledger.slabs[i];
        slabs.push_back({{"below_layer", slab.layer},
                         {"triangles", slab.triangles},
                         {"flat_up_mm2", slab.flat_up_mm2},
                         {"flat_down_mm2", slab.flat_down_mm2}});
    }
    Json gaps = Json::array();
    for (std::size_t i = 0; i < std::min(ledger.gaps.size(), most_places); ++i) {
        gaps.push_back(ledger.gaps[i]);
    }
    return {{"triangles", ledger.triangles},
            {"cut", ledger.cut},
            {"between_planes", ledger.between},
            {"degenerate", ledger.degenerate},
            {"horizontal", ledger.horizontal},
            {"flat_up_mm2", ledger.flat_up_mm2},
            {"flat_down_mm2", ledger.flat_down_mm2},
            {"slabs", ledger.slabs.size()},
            {"first_slabs", slabs},
            {"empty_layers_inside", ledger.gaps.size()},
            {"first_empty_layers", gaps}};
}

Json weld_json(const ReportContext& context) {
    return {{"tolerance_mm", context.weld_mm},
            {"vertices", context.welded->vertices},
            {"joined", context.welded->joined},
            {"largest_move_mm", context.welded->largest_move}};
}

Json report(const SliceResult& result, const ReportContext& context) {
    const SliceSummary& summary = result.summary;
    Json json = {{"mesh", context.mesh_file},
                 {"output", context.output_file.empty() ? Json(nullptr) : Json(context.output_file)}};
    if (context.file != nullptr) {
        json["file"] = file_json(*context.file);
    }
    json.update(counts_json(result));
    json["first_open"] = open_json(result);
    json["fill_rule"] = name_of(result.fill_rule);
    json["gaps"] = gaps_json(result);
    if (context.ledger != nullptr) {
        json["ledger"] = ledger_json(*context.ledger);
    }
    if (context.welded != nullptr) {
        json["weld"] = weld_json(context);
    }
    json["grid_mm"] = result.unit_mm;
    json["plan"] = plan_json(result.plan);
    json["frame"] = result.frame.m;
    json["box_mm"] = {{"min", summary.min_mm}, {"max", summary.max_mm}};
    json["solid_volume_mm3"] = solid_volume_mm3(result);
    json["threads"] = summary.threads;
    json["bands"] = summary.bands;
    json["ms"] = times_json(summary.ms, context);
    json["peak_rss_bytes"] = context.peak_rss_bytes;
    json["output_hash"] = hex(output_hash(result));
    json["warnings"] = context.warnings;
    return json;
}

}  // namespace

Result<std::string> report_json(const SliceResult& result, const ReportContext& context) noexcept {
    try {
        // File names need not be UTF-8 and JSON must be: bytes that are not become U+FFFD.
        return report(result, context).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    } catch (const std::bad_alloc&) {
        return Error{.code = Code::out_of_memory, .message = "out of memory"};
    }
}

Status write_text_file(const std::filesystem::path& path, const std::string& text) noexcept {
    try {
        Result<OutputFile> file = OutputFile::create(path);
        if (!file) {
            return file.error();
        }
        file->append(text);
        return file->commit();
    } catch (const std::bad_alloc&) {
        return Error{.code = Code::out_of_memory, .message = "out of memory"};
    }
}

}  // namespace lamella
