#include "slice/slice.hpp"

#include <cmath>

#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "options/asked.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

std::string mesh_line(const SliceInfo& counts, const ReportParts& parts) {
    return "mesh      " + input_name(std::string(parts.mesh_name)) + ", " + counted(counts.triangles, "triangle") + ", " +
           description(*parts.file) +
           when(counts.degenerate > 0, "; " + grouped(counts.degenerate) + " degenerate, dropped") + "\n";
}

std::string planes_line(const SliceInfo& info, const ToolRun& run) {
    const bool all = info.layers == info.planned_layers;
    const std::optional<RandomHeights>& random = run.random_heights;
    return "planes    " + grouped(info.layers) +
           (all ? "" : " from " + std::to_string(info.first_layer) + " on, of " + grouped(info.planned_layers)) + ": " +
           (random ? exact_text(random->min_step_mm) + " to " + exact_text(random->max_step_mm) + " mm apart by seed " +
                         std::to_string(random->seed) + ", from the mesh's lowest vertex up"
                   : heights_in_short(info.options)) +
           "\nrounding  as a vertex, then " + side_in_short(info.options) + ", grid " + exact_text(info.grid_mm) + " mm\n";
}

/// How closed contours became regions, what was left as it is, and layers in which nothing is left of what the mesh has
/// there.
std::string regions(const SliceResult& result) {
    const RegionRules& rules = result.info.options.region;
    const std::string text = rules_in_short(rules, counted(result.info.would_close_contours, "contour"));
    const std::uint64_t emptied = result.info.emptied_layers;
    if (rules.keeps_contours() || emptied == 0) {
        return text;
    }
    const auto crossed = static_cast<std::uint64_t>(
        std::count_if(result.layers.begin(), result.layers.end(), [](const Layer& layer) { return layer.segments > 0; }));
    return text + "emptied   " + (emptied == crossed ? "all " : grouped(emptied) + " of ") + counted(crossed, "layer") +
           " that the mesh crosses\n";
}

/// Lines on the work beyond cutting, if any.
std::string mending(const SlicedPart& part, const ReportParts& parts, const ToolRun& run) {
    const SliceResult& result = part.result;
    std::string text;
    if (parts.welded != nullptr) {
        text += "welded    " + counted(parts.welded->joined, "vertex", "vertices") + " onto others at most " +
                exact_text(parts.welded->tolerance_mm) + " mm away, the farthest " +
                measure_text(parts.welded->largest_move_mm) + " mm\n";
    }
    text += when(run.shells > 0,
                 "oriented  " + counted(run.turned_shells, "shell") + " turned, of " + grouped(run.shells) + "\n");
    if (!result.stitches.empty()) {
        double longest = 0;
        for (const auto& [layer, from, to] : result.stitches) {
            longest = std::max(longest, std::hypot(static_cast<double>(to.x) - from.x, static_cast<double>(to.y) - from.y) *
                                            result.info.grid_mm);
        }
        text += "gaps      " + grouped(result.stitches.size()) + " closed of up to " + measure_text(part.reach_mm()) +
                " mm, the longest " + measure_text(longest) + " mm\n";
    }
    return text + regions(result);
}

std::string times(const SliceInfo& info, const ToolRun& run) {
    std::map<std::string_view, double> ms = run.ms;
    ms["fill"] = info.ms.fill;
    std::erase_if(ms, [](const auto& stage) { return stage.second == 0; });  // what was not asked for
    ms.insert({{"bucket", info.ms.bucket},
               {"sweep", info.ms.sweep},
               {"contours", info.ms.contours},
               {"nesting", info.ms.nesting}});
    std::string text = "time      " + rounded(ms["total"], 1) + " ms: read " + rounded(ms["read"], 1);
    for (const char* const what : {"parse", "weld", "bucket", "sweep", "contours", "nesting", "fill", "write", "ledger",
                                   "certificate", "crossings", "report"}) {
        if (const auto took = ms.find(what); took != ms.end()) {
            text.append(", ").append(what).append(" ").append(rounded(took->second, 1));
        }
    }
    return text + " (" + counted(static_cast<std::uint64_t>(info.threads), "thread") + ", " + counted(info.bands, "band") +
           ")\n";
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
    if (parts.audit == nullptr) {
        return {};
    }
    std::string text;
    if (const std::optional<Ledger>& books = parts.audit->ledger) {
        text += "unseen    between planes: shells " + grouped(books->shells.count) + ", peaks " +
                grouped(books->peaks.count) + ", pits " + grouped(books->pits.count) + ", triangles " +
                grouped(books->between) + "\n";
    }
    if (parts.audit->volume) {
        text += volume_line(*parts.audit->volume);
    }
    if (const std::optional<Crossings>& found = parts.audit->crossings; found && found->count > 0) {
        text += "crossings " + std::string(found->at_least ? "at least " : "") + grouped(found->count) +
                " of contours, in layers " + grouped(found->layers.size()) + "\n";
    }
    return text;
}

}  // namespace

std::vector<ReportMember> members_of(const ToolRun& run) {
    decltype(ReportMember::value) output = nullptr;
    if (run.outputs.size() == 1) {
        output = std::string_view(run.outputs.front());
    } else if (!run.outputs.empty()) {
        output = std::span<const std::string>(run.outputs);
    }
    std::vector<ReportMember> members = {{ReportPlace::after_mesh, "output", output}};
    for (const char* const what : {"read", "parse", "weld", "write", "ledger", "certificate", "crossings", "total"}) {
        const auto found = run.ms.find(what);
        members.push_back({ReportPlace::in_times, what, found == run.ms.end() ? 0 : found->second});
    }
    members.push_back({ReportPlace::after_times, "peak_rss_bytes", run.peak_rss_bytes});
    members.push_back({ReportPlace::at_end, "warnings", std::span<const std::string>(run.warnings)});
    return members;
}

std::string summary(const SlicedPart& part, const ReportParts& parts, const ToolRun& run) {
    const SliceInfo& info = part.result.info;
    std::string text = mesh_line(info, parts) + planes_line(info, run) + mending(part, parts, run);
    text += "segments  " + grouped(info.segments) + "\ncontours  " + grouped(info.contours) + ", of them holes " +
            grouped(info.holes) + ", open " + grouped(info.open_contours);
    text += when(info.flat_contours > 0, ", without area " + grouped(info.flat_contours));
    text += when(info.overruled_contours > 0, ", turned against their facets " + grouped(info.overruled_contours)) + "\n";
    text += when(part.open.layers > 0, "open      " + said_of(part.open) + "\n");
    text += when(run.print_hash && part.hash, "hash      " + hexadecimal(part.hash.value_or(0)) + "\n");
    return text + findings(parts) + times(info, run) + "memory    " + file_size_text(run.peak_rss_bytes) + " at the peak\n" +
           run.ranges + wrote(run.outputs);
}

}  // namespace lamella::cli
