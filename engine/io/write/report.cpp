// The report of a slicing: what was asked, what was found, and how long each stage took, as JSON.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/write/json.hpp"
#include "lamella/io/report.hpp"
#include "options/asked.hpp"

namespace lamella {

namespace {

/// So many places of a kind are listed; the counts are of all.
constexpr std::size_t most_places = 100;
constexpr std::size_t most_open_in_layer = 10;

void write_values(JsonText& json, const std::vector<AskedValue>& values) {
    for (const auto& [name, value] : values) {
        std::visit([&json, key = name](const auto& own) { json.member(key, own); }, value);
    }
}

/// NaN where the area of a layer is not known.
double solid_volume_mm3(const SliceResult& result) {
    double volume = 0;
    for (const LayerView layer : result) {
        volume += layer.area_mm2() * (layer.top_mm - layer.bottom_mm);
    }
    return volume;
}

void write_counts(JsonText& json, const SliceResult& result) {
    const SliceInfo& info = result.info;
    json.member("triangles", info.triangles);
    json.member("degenerate", info.degenerate);
    json.member("crossed", info.crossed);
    json.member("planes", result.layers.size());
    json.member("segments", info.segments);
    json.member("points", result.points.size());
    json.member("contours", result.contours.size());
    json.member("open_contours", info.open_contours);
    json.member("holes", info.holes);
    json.member("flat_contours", info.flat_contours);
    json.member("overruled_contours", info.overruled_contours);
}

void write_times(JsonText& json, const StageTimes& stages, const ReportParts& parts, Clock::time_point start) {
    json.object("ms", [&] {
        json.member("bucket", stages.bucket);
        json.member("sweep", stages.sweep);
        json.member("contours", stages.contours);
        json.member("nesting", stages.nesting);
        json.member("fill", stages.fill);
        write_members(json, parts, ReportPlace::in_times);
        json.member("report", milliseconds_since(start));
    });
}

/// A place in a layer, mm.
std::array<double, 2> place_mm(const SliceResult& result, const Point& point) {
    const PointMm place = result.to_mm(point);
    return {place.x, place.y};
}

double length_mm(const SliceResult& result, const Stitch& gap) {
    const double dx = static_cast<double>(gap.to.x) - gap.from.x;
    const double dy = static_cast<double>(gap.to.y) - gap.from.y;
    return std::sqrt(dx * dx + dy * dy) * result.info.grid_mm;
}

/// Which layer, the height asked for, and the one cut.
void write_layer(JsonText& json, const SliceResult& result, std::size_t layer) {
    json.member("layer", layer);
    json.member("plane_mm", result[layer].plane_mm);
    json.member("cut_mm", result[layer].cut_mm());
}

/// Its ends, and how far apart they are by that name.
void write_gap(JsonText& json, const SliceResult& result, const Stitch& gap, std::string_view length) {
    json.member("from_mm", place_mm(result, gap.from));
    json.member("to_mm", place_mm(result, gap.to));
    json.member(length, length_mm(result, gap));
}

/// Every gap that was closed.
void write_gaps(JsonText& json, const SliceResult& result) {
    double longest = 0;
    double total = 0;
    for (const Stitch& gap : result.stitches) {
        longest = std::max(longest, length_mm(result, gap));
        total += length_mm(result, gap);
    }
    json.object("gaps", [&] {
        write_values(json, values_of_stitching(result.info.options));
        json.member("closed", result.stitches.size());
        json.member("longest_mm", longest);
        json.member("total_mm", total);
        json.objects("closings", result.stitches, result.stitches.size(), [&](const Stitch& gap) {
            write_layer(json, result, gap.layer);
            write_gap(json, result, gap, "length_mm");
        });
    });
}

/// A layer's open polylines: where each ends and where it starts, between which the mesh lacks faces.
void write_open_layer(JsonText& json, const SliceResult& result, const std::vector<Stitch>& gaps) {
    json.object([&] {
        write_layer(json, result, gaps.front().layer);
        json.member("count", gaps.size());
        json.objects("first", gaps, most_open_in_layer, [&](const Stitch& gap) { write_gap(json, result, gap, "gap_mm"); });
        json.member("not_listed", gaps.size() - std::min(gaps.size(), most_open_in_layer));
    });
}

/// Every layer that has open polylines, and all of them in short.
void write_open(JsonText& json, const SliceResult& result, const Audit* found) {
    const bool known = found != nullptr && found->open;
    const std::optional<OpenLayers> open =
        known ? found->open
              : require(audit(result, MeshView{}, {.volume = false, .ledger = false, .crossings = false})).open;
    if (open->layers > 0) {
        json.object("open", [&] {
            json.member("layers", open->layers);
            json.member("of_layers", open->crossed);
            json.member("height_share", open->share());
            json.member("stay_open", open->stuck);
            json.member_if(open->layers > open->stuck, "closed_by_mm", open->reach_mm);
        });
    }
    std::vector<Stitch> gaps;  // of one layer
    json.list("open_layers", result, result.size(), [&](const LayerView& layer) {
        gaps.clear();
        for (const Contour& contour : layer.contours) {
            if (contour.role == Role::open) {
                const std::span<const Point> points = layer.points_of(contour);
                gaps.push_back({layer.index, points.back(), points.front()});
            }
        }
        if (!gaps.empty()) {
            write_open_layer(json, result, gaps);
        }
    });
}

void write_ledger(JsonText& json, const Ledger& ledger) {
    const auto pieces = [&](const char* name, const SurfacePieceCount& of_kind) {
        json.object(name, [&] {
            json.member("count", of_kind.count);
            json.member("triangles", of_kind.triangles);
        });
    };
    json.object("ledger", [&] {
        json.member("triangles", ledger.triangles);
        json.member("cut", ledger.cut);
        json.member("between_planes", ledger.between);
        json.member("degenerate", ledger.degenerate);
        json.member("horizontal", ledger.horizontal);
        json.member("flat_up_mm2", ledger.flat_up_mm2);
        json.member("flat_down_mm2", ledger.flat_down_mm2);
        pieces("shells", ledger.shells);
        pieces("peaks", ledger.peaks);
        pieces("pits", ledger.pits);
        json.objects("first_pieces", ledger.pieces, most_places, [&](const SurfacePiece& piece) {
            json.member("kind", name_of(piece.kind));
            json.member("below_layer", piece.layer);
            json.member("at_mm", piece.at_mm);
            json.member("height_mm", piece.height_mm);
            json.member("triangles", piece.triangles);
        });
        json.member("slabs", ledger.slabs.size());
        json.objects("first_slabs", ledger.slabs, most_places, [&](const LedgerSlab& slab) {
            json.member("below_layer", slab.layer);
            json.member("triangles", slab.triangles);
            json.member("flat_up_mm2", slab.flat_up_mm2);
            json.member("flat_down_mm2", slab.flat_down_mm2);
            json.member("shells", slab.shells);
            json.member("peaks", slab.peaks);
            json.member("pits", slab.pits);
        });
        json.member("empty_layers_inside", ledger.gaps.size());
        json.list("first_empty_layers", ledger.gaps, most_places, [&](std::uint64_t layer) { json.value(layer); });
    });
}

void write_volume(JsonText& json, const VolumeCertificate& volume) {
    const bool closed = volume.verdict != VolumeVerdict::open_mesh;
    const bool compared = volume.applies() && !volume.slab_mm3.empty();
    json.object("volume", [&] {
        json.member("verdict", name_of(volume.verdict));
        json.member_if(closed, "mesh_mm3", volume.mesh_mm3);
        json.member_if(closed, "slabs_mm3", volume.slabs_mm3);
        json.member_if(compared, "worst_layer", volume.worst_layer);
        json.member_if(compared, "worst_difference_mm2", volume.worst_difference_mm2);
        json.member_if(compared, "worst_allowed_mm2", volume.worst_allowed_mm2);
        if (volume.verdict == VolumeVerdict::solid_differs) {
            json.member("differing_layers", volume.differing_layers);
            json.member("differing_signed_mm2", volume.differing_signed_mm2);
            json.member("differing_solid_mm2", volume.differing_solid_mm2);
        }
    });
}

void write_crossings(JsonText& json, const SliceResult& result, const Crossings& crossings) {
    json.object("crossings", [&] {
        json.member("count", crossings.count);
        json.member("at_least", crossings.at_least);
        json.objects("layers", crossings.layers, crossings.layers.size(), [&](const LayerCrossings& layer) {
            const std::uint64_t first = result.layers[layer.layer].first_contour;
            write_layer(json, result, layer.layer);
            json.member("count", layer.count);
            json.member("at_least", layer.at_least);
            json.member_if(layer.count > 0, "first_mm", place_mm(result, layer.first));
            json.member_if(layer.count > 0, "contours", std::array{layer.contours[0] - first, layer.contours[1] - first});
        });
    });
}

void write_weld(JsonText& json, const WeldedMesh& welded) {
    json.object("weld", [&] {
        json.member("tolerance_mm", welded.tolerance_mm);
        json.member("vertices", welded.vertex_count);
        json.member("joined", welded.joined);
        json.member("largest_move_mm", welded.largest_move_mm);
    });
}

void write_region(JsonText& json, const SliceResult& result) {
    const RegionRules& rules = result.info.options.region;
    json.object("region", [&] {
        json.objects("fill_from", rules.fill_from, rules.fill_from.size(), [&](const FillFrom& from) {
            json.member("first_layer", from.first_layer);
            json.member("fill_rule", name_of(from.rule));
        });
        write_values(json, values_of_rules(rules));
        json.member("would_close_contours", result.info.would_close_contours);
        json.member("emptied_layers", result.info.emptied_layers);
    });
}

/// The answers about the result that the program has asked for.
void write_findings(JsonText& json, const SliceResult& result, const ReportParts& parts) {
    const RegionRules& rules = result.info.options.region;
    write_open(json, result, parts.audit);
    json.member("fill_rule", name_of(rules.fill_rule));
    if (result.info.cancelled_layers > 0) {
        json.member("cancelled_layers", result.info.cancelled_layers);
    }
    if (goes_beyond_one_rule(rules)) {
        write_region(json, result);
    }
    write_gaps(json, result);
    if (parts.audit != nullptr && parts.audit->ledger) {
        write_ledger(json, *parts.audit->ledger);
    }
    if (parts.audit != nullptr && parts.audit->volume) {
        write_volume(json, *parts.audit->volume);
    }
    if (parts.audit != nullptr && parts.audit->crossings) {
        write_crossings(json, result, *parts.audit->crossings);
    }
    if (parts.welded != nullptr) {
        write_weld(json, *parts.welded);
    }
}

void write_report(JsonText& json, const SliceResult& result, const ReportParts& parts) {
    const auto start = Clock::now();
    const SliceInfo& info = result.info;
    const std::uint64_t hash = result.hash();  // takes longest, and its time is to be among the times
    write_mesh(json, parts);
    write_counts(json, result);
    write_findings(json, result, parts);
    if (info.part_count > 1) {
        json.member("parts", info.part_count);
        json.member("part_regions", info.options.unite_parts ? "united" : "separate");
    }
    json.member("grid_mm", info.grid_mm);
    if (info.grid_doublings > 0 && info.grid_mm == std::ldexp(default_grid_mm, info.grid_doublings)) {
        json.member("grid_rule", "the unit doubles beyond 1,024 mm, and parts there change with the plate");
    }
    json.object("plan", [&] { write_values(json, values_of_plan(info.options)); });
    json.member("frame", info.options.frame.transform.m);
    write_box(json, info.box);
    json.member("solid_volume_mm3", solid_volume_mm3(result));
    json.member("threads", info.threads);
    json.member("bands", info.bands);
    write_times(json, info.ms, parts, start);
    write_members(json, parts, ReportPlace::after_times);
    json.member("output_hash", hex_text(hash));  // as text: readers of JSON keep 53 bits of a number
    write_members(json, parts, ReportPlace::at_end);
}

}  // namespace

Result<std::string> make_report_json(const SliceResult& result, const ReportParts& parts) noexcept {
    return guarded([&]() -> Result<std::string> {
        JsonText json;
        json.object([&] { write_report(json, result, parts); });
        return std::move(json).take();
    });
}

Result<std::string> make_mesh_json(const ReportParts& parts) noexcept {
    return guarded([&]() -> Result<std::string> {
        JsonText json;
        json.object([&] {
            write_mesh(json, parts);
            write_members(json, parts, ReportPlace::at_end);
        });
        return std::move(json).take();
    });
}

}  // namespace lamella
