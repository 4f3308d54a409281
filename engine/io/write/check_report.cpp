// The diagnosis of a mesh: as JSON, and as places in PLY.
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/write/json.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/check_report.hpp"

namespace lamella {

namespace {

/// How a kind of fault is shown.
struct FaultForm {
    const char* colour;   ///< in PLY
    const char* parts;    ///< name of FaultPlace::parts, or null where the kind has none
    const char* measure;  ///< the same of FaultPlace::measure
};

/// Reds for boundaries, blues for edges and vertices, greens for faces and shells, yellows for meetings, violets for gaps.
constexpr std::array<FaultForm, fault_count> forms = {{
    {"255 0 0", "faces", nullptr},       // boundary_edge
    {"160 0 0", "edges", "length_mm"},   // boundary_loop
    {"0 160 255", "faces", nullptr},     // overfull_balanced
    {"0 0 255", "faces", nullptr},       // overfull_unbalanced
    {"0 0 140", "faces", nullptr},       // mismatched_edge
    {"0 255 255", "fans", nullptr},      // split_vertex
    {"0 128 0", nullptr, nullptr},       // flipped_face
    {"128 255 128", nullptr, nullptr},   // one_sided_patch
    {"0 255 0", nullptr, nullptr},       // duplicate_face
    {"0 200 80", nullptr, nullptr},      // opposite_face
    {"120 120 0", nullptr, nullptr},     // collapsed_face
    {"150 150 60", nullptr, nullptr},    // zero_area_face
    {"160 160 160", nullptr, "ratio"},   // needle_face
    {"110 110 110", nullptr, "ratio"},   // cap_face
    {"0 90 60", nullptr, "volume_mm3"},  // misoriented_shell
    {"255 160 0", nullptr, nullptr},     // crossing_faces
    {"255 220 0", nullptr, nullptr},     // overlapping_faces
    {"200 170 90", nullptr, nullptr},    // touching_faces
    {"255 0 255", nullptr, "width_mm"},  // t_junction
    {"150 0 200", nullptr, "width_mm"},  // crack
}};

void write_place(JsonText& json, Fault fault, const FaultPlace& place) {
    json.list("points_mm", place.points_mm, static_cast<std::size_t>(place.point_count),
              [&](const auto& point) { json.value(point); });
    const auto triangles = std::count_if(place.triangles.begin(), place.triangles.end(), [](auto t) { return t >= 0; });
    json.list("triangles", place.triangles, static_cast<std::size_t>(triangles),
              [&](std::int64_t triangle) { json.value(triangle); });
    const FaultForm& form = forms[static_cast<std::size_t>(fault)];
    if (form.parts != nullptr) {
        json.member(form.parts, place.parts);
    }
    if (form.measure != nullptr) {
        json.member(form.measure, place.measure);
    }
    if (fault == Fault::boundary_loop) {
        json.member("closed", place.closed);
    }
}

void write_finding(JsonText& json, Fault fault, const FaultFinding& finding, std::size_t most_places) {
    json.object(key_of(fault), [&] {
        json.member("count", finding.count);
        json.member("at_least", finding.at_least);
        json.objects("places", finding.places, most_places,
                     [&](const FaultPlace& place) { write_place(json, fault, place); });
    });
}

bool is_sliver(Fault fault) {
    return fault == Fault::needle_face || fault == Fault::cap_face;
}

std::string verdict_of(const MeshCheck& check) {
    const bool clean = check.clean();
    std::string text = clean ? "closed and clean" : "not clean";
    const char* before = clean ? ", with " : ": ";
    for (std::size_t i = 0; i < fault_count; ++i) {
        const FaultFinding& finding = check.findings[i];
        const Fault fault = static_cast<Fault>(i);
        if (finding.count > 0 && (clean || !is_sliver(fault))) {
            text += before + std::string(finding.at_least ? "at least " : "") + std::to_string(finding.count) + " " +
                    std::string(words_for(fault, finding.count));
            before = ", ";
        }
    }
    return text + (check.complete() ? "" : ", as far as was searched");
}

void write_report(JsonText& json, const MeshCheck& check, const ReportParts& parts, std::size_t most_places) {
    const auto start = Clock::now();
    write_mesh(json, parts);
    json.member("triangles", check.triangles);
    json.member("edges", check.edges);
    json.member("boundary_edges_on_grid", check.boundary_edges);
    json.member("boundary_edges_exact", check.exact_boundary_edges);
    json.member("grid_mm", check.grid_mm);
    json.member("tolerance_mm", check.tolerance_mm);
    json.member("sliver_ratio", check.sliver_ratio);
    write_box(json, check.box);
    json.member("closed", check.closed);
    json.member("clean", check.clean());
    json.member("verdict", verdict_of(check));
    json.object("findings", [&] {
        for (std::size_t i = 0; i < fault_count; ++i) {
            write_finding(json, static_cast<Fault>(i), check.findings[i], most_places);
        }
    });
    json.object("shells", [&] {
        json.member("count", check.shells.size());
        json.member("nesting_complete", check.nesting_complete);
        json.objects("first", check.shells, most_places, [&](const MeshShell& shell) {
            json.member("first_mm", shell.first_mm);
            json.member("triangle", shell.triangle);
            json.member("triangles", shell.triangles);
            json.member("closed", shell.closed);
            json.member_if(shell.closed, "volume_mm3", shell.volume_mm3);
            json.member("sense", shell.orientation);
            json.member("depth", shell.depth);
            json.member_if(shell.parent >= 0, "parent", shell.parent);
        });
    });
    if (std::any_of(parts.members.begin(), parts.members.end(),
                    [](const ReportMember& member) { return member.place == ReportPlace::in_times; })) {
        json.object("ms", [&] {
            write_members(json, parts, ReportPlace::in_times);
            json.member("report", milliseconds_since(start));
        });
    }
    write_members(json, parts, ReportPlace::at_end);
}

}  // namespace

Result<std::string> make_verdict(const MeshCheck& check) noexcept {
    return guarded([&]() -> Result<std::string> { return verdict_of(check); });
}

Result<std::string> make_check_json(const MeshCheck& check, const ReportParts& parts, std::size_t most_places) noexcept {
    return guarded([&]() -> Result<std::string> {
        JsonText json;
        json.object([&] { write_report(json, check, parts, most_places); });
        return std::move(json).take();
    });
}

// --- The places of faults as a PLY file, to be shown over the mesh

namespace {

/// Edges between the points of a place: none, one, or a triangle's three.
int edge_count(const FaultPlace& place) {
    return place.point_count == 3 ? 3 : place.point_count - 1;
}

template <class Visit>
void each_place(const MeshCheck& check, Visit visit) {
    for (std::size_t fault = 0; fault < fault_count; ++fault) {
        for (const FaultPlace& place : check.findings[fault].places) {
            visit(place, std::string(forms[fault].colour) + "\n");
        }
    }
}

std::string header(const MeshCheck& check) {
    constexpr const char* colour = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    std::int64_t points = 0;
    std::int64_t edges = 0;
    each_place(check, [&](const FaultPlace& place, const std::string& /*colour*/) {
        points += place.point_count;
        edges += edge_count(place);
    });
    std::string head = "ply\nformat ascii 1.0\ncomment unit mm\n";
    for (std::size_t fault = 0; fault < fault_count; ++fault) {
        head += "comment " + std::string(key_of(static_cast<Fault>(fault))) + " " + forms[fault].colour + "\n";
    }
    return head + "element vertex " + std::to_string(points) +
           "\nproperty double x\nproperty double y\nproperty double z\n" + colour + "element edge " + std::to_string(edges) +
           "\nproperty int vertex1\nproperty int vertex2\n" + colour + "end_header\n";
}

void write_points(const MeshCheck& check, OutputFile& file) {
    each_place(check, [&](const FaultPlace& place, const std::string& colour) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(place.point_count); ++i) {
            for (const double mm : place.points_mm[i]) {
                file.append(exact_text(mm) + " ");
            }
            file.append(colour);
        }
    });
}

void write_edges(const MeshCheck& check, OutputFile& file) {
    std::int64_t first = 0;
    each_place(check, [&](const FaultPlace& place, const std::string& colour) {
        for (int i = 0; i < edge_count(place); ++i) {
            file.append(std::to_string(first + i) + " " + std::to_string(first + (i + 1) % place.point_count) + " " +
                        colour);
        }
        first += place.point_count;
    });
}

}  // namespace

Status write_marks(const MeshCheck& check, const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Status {
        OutputFile file = require(OutputFile::create(path));
        file.append(header(check));
        write_points(check, file);
        write_edges(check, file);
        return file.commit();
    });
}

}  // namespace lamella
