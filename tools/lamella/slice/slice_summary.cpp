#include "slice/slice_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <variant>

#include "files/mesh_input.hpp"
#include "files/scale_words.hpp"
#include "files/streams.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

std::string words(const UniformLayers& layers) {
    const std::string first =
        layers.first_height_mm ? exact_text(*layers.first_height_mm) + " mm above it" : "half a layer above it";
    return exact_text(layers.layer_height_mm) + " mm apart, datum " +
           (layers.datum == Datum::mesh_min ? "the mesh's lowest vertex" : "zero") + ", the first " + first;
}

std::string words(const ExplicitPlanes& /*planes*/) {
    return "at given heights";
}

std::string words(const RandomLayers& layers) {
    return exact_text(layers.min_height_mm) + " to " + exact_text(layers.max_height_mm) + " mm apart by seed " +
           std::to_string(layers.seed) + ", from the mesh's lowest vertex up";
}

std::string mesh_line(const SliceSummary& counts, const ReportParts& parts) {
    std::string text = "mesh      " + input_name(std::string(parts.mesh_name)) + ", " +
                       counted(counts.triangles, "triangle") + ", " + description(*parts.file);
    if (counts.degenerate > 0) {
        text += "; " + grouped(counts.degenerate) + " degenerate, dropped";
    }
    return text + "\n";
}

std::string planes_line(const SliceResult& result) {
    const bool all = result.layers.size() == result.all_layers;
    return "planes    " + grouped(result.layers.size()) +
           (all ? "" : " from " + std::to_string(result.first_layer) + " on, of " + grouped(result.all_layers)) + ": " +
           std::visit([](const auto& spacing) { return words(spacing); }, result.plan.spacing) +
           "\nrounding  as a vertex, then " +
           (result.plan.side == PlaneSide::below ? "down (side below)" : "up (side above)") + ", grid " +
           exact_text(result.unit_mm) + " mm\n";
}

/// Layers in which nothing is left of what the mesh has there.
std::string emptied(const SliceResult& result) {
    const std::uint64_t emptied = result.summary.emptied_layers;
    if (emptied == 0) {
        return {};
    }
    const auto crossed = static_cast<std::uint64_t>(
        std::count_if(result.layers.begin(), result.layers.end(), [](const Layer& layer) { return layer.segments > 0; }));
    return "emptied   " +
           (emptied == crossed ? "all " + counted(crossed, "layer")
                               : grouped(emptied) + " of " + counted(crossed, "layer")) +
           " that the mesh crosses\n";
}

/// "by the rule non-zero, from layer 12 on contours"
std::string rules_by_layer(const RegionRules& rules) {
    std::string text = "by the rule " + std::string(name_of(rules.fill_rule));
    for (const FillFrom& from : rules.fill_from) {
        text += ", from layer " + std::to_string(from.first_layer) + " on " + std::string(name_of(from.rule));
    }
    return text;
}

std::string simplified(const RegionRules& rules) {
    return rules.simplify_mm == 0 ? ""
                                  : "dropped   points within " + exact_text(rules.simplify_mm) + " mm of the lines left\n";
}

/// How closed contours became regions, and what was left as it is.
std::string regions(const SliceResult& result) {
    const RegionRules& rules = result.region;
    std::string text;
    if (rules.mark_near_mm > 0) {
        text += "near      " + counted(result.summary.near_contours, "contour") + " would change if gaps under " +
                exact_text(2 * rules.mark_near_mm) + " mm were closed\n";
    }
    if (rules.keeps_contours()) {
        return simplified(rules) + text;
    }
    text += "filled    " + rules_by_layer(rules) + "\n";
    if (rules.close_mm > 0) {
        text += "closed    gaps under " + exact_text(2 * rules.close_mm) + " mm\n";
    }
    if (rules.offset_mm != 0) {
        text += "offset    " + std::string(rules.offset_mm > 0 ? "grown" : "shrunk") + " by " +
                exact_text(std::abs(rules.offset_mm)) + " mm, miter limit " + exact_text(rules.miter_limit) + "\n";
    }
    if (rules.largest_only) {
        text += "kept      the largest contour of each layer, with its holes\n";
    }
    if (rules.drop_collinear) {
        text += "dropped   points within straight lines\n";
    }
    text += simplified(rules);
    return text + emptied(result);
}

/// Lines on the work beyond cutting, if any.
std::string mending(const SliceResult& result, const ReportParts& parts, const ToolRun& run) {
    std::string text;
    if (parts.welded != nullptr) {
        text += "welded    " + counted(parts.welded->joined, "vertex", "vertices") + " onto others at most " +
                exact_text(parts.welded->tolerance_mm) + " mm away, the farthest " +
                measure_text(parts.welded->largest_move_mm) + " mm\n";
    }
    if (run.shells > 0) {
        text += "oriented  " + counted(run.turned_shells, "shell") + " turned, of " + grouped(run.shells) + "\n";
    }
    if (!result.closed_gaps.empty()) {
        double longest = 0;
        for (const ClosedGap& gap : result.closed_gaps) {
            longest = std::max(longest, result.length_mm(gap));
        }
        text += "gaps      " + grouped(result.closed_gaps.size()) + " closed of up to " +
                measure_text(result.close_gaps_mm) + " mm, the longest " + measure_text(longest) + " mm\n";
    }
    return text + regions(result);
}

std::string times(const SliceSummary& summary, const MeshFile& mesh, const ToolRun& run) {
    struct Time {
        const char* what;
        double ms;
        bool always = false;
    };
    std::string text = "time      " + rounded(run.total_ms, 1) + " ms: read " + rounded(mesh.read_ms, 1);
    for (const auto& [what, ms, always] : {Time{"parse", mesh.parse_ms},
                                           {"weld", run.weld_ms},
                                           {"bucket", summary.ms.bucket, true},
                                           {"sweep", summary.ms.sweep, true},
                                           {"contours", summary.ms.contours, true},
                                           {"nesting", summary.ms.nesting, true},
                                           {"fill", summary.ms.fill},
                                           {"write", run.write_ms},
                                           {"ledger", run.ledger_ms},
                                           {"certificate", run.certificate_ms},
                                           {"crossings", run.crossings_ms},
                                           {"report", run.report_ms}}) {
        if (always || ms > 0) {
            text += std::string(", ") + what + " " + rounded(ms, 1);
        }
    }
    return text + " (" + counted(static_cast<std::uint64_t>(summary.threads), "thread") + ", " +
           counted(summary.bands, "band") + ")\n";
}

std::string contour_counts(const SliceResult& result, const ToolRun& run) {
    const SliceSummary& summary = result.summary;
    std::string text = grouped(run.contours.value_or(result.contours.size())) + ", of them holes " + grouped(summary.holes) +
                       ", open " + grouped(summary.open_contours);
    if (summary.flat_contours > 0) {
        text += ", without area " + grouped(summary.flat_contours);
    }
    if (summary.overruled_contours > 0) {
        text += ", turned against their facets " + grouped(summary.overruled_contours);
    }
    return text;
}

std::string open_line(const OpenLayers& open) {
    return open.layers > 0 ? "open      " + describe(open, "--close-gaps ") + "\n" : std::string();
}

std::string volume_line(const VolumeCertificate& volume) {
    if (!volume.applies()) {
        return "volume    " + words_for(volume) + "\n";
    }
    std::string text = "volume    " + measure_text(volume.mesh_mm3) + " mm3, ";
    if (volume.verdict == VolumeVerdict::volumes_differ) {
        text += "but the slabs between planes sum to " + measure_text(volume.slabs_mm3) + " mm3";
    } else {
        text += volume.verdict == VolumeVerdict::holds ? "certified" : "but areas differ";
    }
    if (volume.worst_allowed_mm2 > 0) {
        text += "; areas differ most in layer " + std::to_string(volume.worst_layer) + ", by " +
                rounded(100 * volume.worst_difference_mm2 / volume.worst_allowed_mm2, 0) + " % of what rounding may do";
    }
    return text + "\n";
}

/// Lines on the report's findings, if there is a report.
std::string findings(const ReportParts& parts) {
    std::string text;
    if (parts.ledger != nullptr) {
        const Ledger& books = *parts.ledger;
        text += "unseen    between planes: shells " + grouped(books.shells.count) + ", peaks " + grouped(books.peaks.count) +
                ", pits " + grouped(books.pits.count) + ", triangles " + grouped(books.between) + "\n";
    }
    if (parts.volume != nullptr) {
        text += volume_line(*parts.volume);
    }
    if (parts.crossings != nullptr && parts.crossings->count > 0) {
        text += "crossings " + std::string(parts.crossings->at_least ? "at least " : "") + grouped(parts.crossings->count) +
                " of contours, in layers " + grouped(parts.crossings->layers.size()) + "\n";
    }
    return text;
}

/// ", 1.9 MB", or nothing of a pipe and of a device.
std::string size_after(const std::string& output) {
    std::error_code unknown;
    const std::uintmax_t bytes = is_standard(output) ? 0 : std::filesystem::file_size(output, unknown);
    return is_standard(output) || unknown ? "" : ", " + file_size_text(bytes);
}

}  // namespace

std::vector<ReportMember> members_of(const ToolRun& run, const MeshFile& mesh) {
    decltype(ReportMember::value) output = nullptr;
    if (run.outputs.size() == 1) {
        output = std::string_view(run.outputs.front());
    } else if (!run.outputs.empty()) {
        output = std::span<const std::string>(run.outputs);
    }
    return {{ReportPlace::after_mesh, "output", output},
            {ReportPlace::in_times, "read", mesh.read_ms},
            {ReportPlace::in_times, "parse", mesh.parse_ms},
            {ReportPlace::in_times, "weld", run.weld_ms},
            {ReportPlace::in_times, "write", run.write_ms},
            {ReportPlace::in_times, "ledger", run.ledger_ms},
            {ReportPlace::in_times, "certificate", run.certificate_ms},
            {ReportPlace::in_times, "crossings", run.crossings_ms},
            {ReportPlace::in_times, "total", run.total_ms},
            {ReportPlace::after_times, "peak_rss_bytes", run.peak_rss_bytes},
            {ReportPlace::at_end, "warnings", std::span<const std::string>(run.warnings)}};
}

std::string summary(const SliceResult& result, const ReportParts& parts, const ToolRun& run) {
    const std::string text = mesh_line(result.summary, parts) + planes_line(result) + mending(result, parts, run) +
                             "segments  " + grouped(result.summary.segments) + "\ncontours  " + contour_counts(result, run) +
                             "\n" + open_line(run.open) +
                             (run.hash ? "hash      " + hexadecimal(*run.hash) + "\n" : std::string()) + findings(parts) +
                             times(result.summary, *parts.file, run) + "memory    " + file_size_text(run.peak_rss_bytes) +
                             " at the peak\n" + run.ranges;
    return text + wrote(run.outputs);
}

std::string wrote(const std::vector<std::string>& outputs) {
    std::string text;
    for (const std::string& output : outputs) {
        text += "wrote     " + output_name(output) + size_after(output) + "\n";
    }
    return text;
}

}  // namespace lamella::cli
