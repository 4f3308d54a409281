#include "check/check_words.hpp"

#include <algorithm>

#include "files/mesh_input.hpp"
#include "files/scale_words.hpp"
#include "lamella/io/check_report.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// So that figures stand below one another.
std::string line(std::string name, const std::string& value) {
    constexpr std::size_t column = 27;
    name.resize(std::max(name.size() + 1, column), ' ');
    return name + value + "\n";
}

std::string point(const std::array<double, 3>& mm) {
    return "(" + exact_text(mm[0]) + ", " + exact_text(mm[1]) + ", " + exact_text(mm[2]) + ")";
}

/// What is particular to the kind.
std::string detail(Fault fault, const FaultPlace& place) {
    switch (fault) {
        case Fault::overfull_balanced:
        case Fault::overfull_unbalanced:
            return ", " + counted(place.parts, "face");
        case Fault::boundary_loop:
            return ", " + counted(place.parts, "edge") + ", " + measure_text(place.measure) + " mm" +
                   (place.closed ? "" : ", not closed");
        case Fault::split_vertex:
            return ", " + counted(place.parts, "fan");
        case Fault::needle_face:
        case Fault::cap_face:
            return ", " + rounded(place.measure, 0) + " : 1";
        case Fault::misoriented_shell:
            return ", " + measure_text(place.measure) + " mm3";
        case Fault::t_junction:
        case Fault::crack:
            return ", " + exact_text(place.measure) + " mm wide";
        default:
            return "";
    }
}

std::string words(Fault fault, const FaultPlace& place) {
    std::string text = "  ";
    for (std::size_t i = 0; i < static_cast<std::size_t>(place.point_count); ++i) {
        text += (i == 0 ? "" : " ") + point(place.points_mm[i]);
    }
    text += detail(fault, place);
    if (place.triangles[0] >= 0) {
        text += (place.triangles[1] >= 0 ? ", triangles " : ", triangle ") + std::to_string(place.triangles[0]);
    }
    return text + (place.triangles[1] >= 0 ? " and " + std::to_string(place.triangles[1]) : "") + "\n";
}

/// A line that says how many there are beyond the first.
std::string more(std::uint64_t count, std::size_t shown) {
    return count > shown ? "  ... and " + grouped(count - shown) + " more\n" : "";
}

std::string words(Fault fault, const FaultFinding& finding, std::size_t most) {
    const std::size_t shown = std::min(most, finding.places.size());
    std::string text =
        line(std::string(words_for(fault, 0)), (finding.at_least ? "at least " : "") + grouped(finding.count));
    for (std::size_t i = 0; i < shown; ++i) {
        text += words(fault, finding.places[i]);
    }
    return text + more(finding.count, shown);
}

std::string words(const MeshShell& shell) {
    const std::string kind = !shell.closed           ? "not closed"
                             : shell.orientation > 0 ? "solid"
                             : shell.orientation < 0 ? "cavity"
                                                     : "no volume";
    return "  " + point(shell.first_mm) + ", " + kind + ", depth " + std::to_string(shell.depth) + ", " +
           counted(shell.triangles, "triangle") + (shell.closed ? ", " + measure_text(shell.volume_mm3) + " mm3" : "") +
           ", triangle " + std::to_string(shell.triangle) + "\n";
}

std::string shell_words(const MeshCheck& check, std::size_t most) {
    const std::size_t shown = std::min(most, check.shells.size());
    std::string text =
        line("shells", grouped(check.shells.size()) + (check.nesting_complete ? "" : ", nested at least as deep as this"));
    for (std::size_t i = 0; i < shown; ++i) {
        text += words(check.shells[i]);
    }
    return text + more(check.shells.size(), shown);
}

}  // namespace

std::string check_words(const std::string& path, const MeshFile& mesh, const MeshCheck& check, const CheckWords& how) {
    std::string text = line("mesh", path + ", " + description(mesh));
    for (std::size_t i = 0; i < fault_count; ++i) {
        if (how.all_kinds || check.findings[i].count > 0 || check.findings[i].at_least) {
            text += words(static_cast<Fault>(i), check.findings[i], how.most_places);
        }
    }
    text += line("triangles", grouped(check.info.triangles)) + line("edges", grouped(check.info.edges)) +
            line("grid", exact_text(check.info.unit_mm) + " mm" + joined_by_grid(check.info)) +
            line("tolerance", exact_text(check.tolerance_mm) + " mm") +
            line("slivers", "from " + exact_text(check.sliver_ratio) + " : 1");
    return text + shell_words(check, how.most_places) + done_or_thrown(make_verdict(check)) + "\n";
}

}  // namespace lamella::cli
