#include "lamella/mesh/check.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "base/guard.hpp"
#include "mesh/check/finders.hpp"

namespace lamella {

namespace {

struct Names {
    std::string_view key;
    std::string_view one;
    std::string_view many;
};

constexpr std::array<Names, fault_count> names = {{
    {"boundary_edges", "boundary edge", "boundary edges"},
    {"boundary_loops", "boundary loop", "boundary loops"},
    {"overfull_edges_balanced", "balanced over-full edge", "balanced over-full edges"},
    {"overfull_edges_unbalanced", "unbalanced over-full edge", "unbalanced over-full edges"},
    {"mismatched_edges", "mismatched edge", "mismatched edges"},
    {"split_vertices", "split vertex", "split vertices"},
    {"flipped_faces", "flipped face", "flipped faces"},
    {"one_sided_patches", "one-sided patch", "one-sided patches"},
    {"duplicate_faces", "duplicate face", "duplicate faces"},
    {"opposite_faces", "pair of opposite faces", "pairs of opposite faces"},
    {"collapsed_faces", "collapsed face", "collapsed faces"},
    {"zero_area_faces", "face without area", "faces without area"},
    {"needle_faces", "needle", "needles"},
    {"cap_faces", "cap", "caps"},
    {"wrong_sense_shells", "shell of wrong sense", "shells of wrong sense"},
    {"crossing_faces", "crossing of faces", "crossings of faces"},
    {"overlapping_faces", "overlap of faces", "overlaps of faces"},
    {"touching_faces", "touch of faces", "touches of faces"},
    {"t_junctions", "T-junction", "T-junctions"},
    {"cracks", "crack", "cracks"},
}};

const Names& names_of(Fault fault) {
    assert(static_cast<std::size_t>(fault) < fault_count);
    return names[static_cast<std::size_t>(fault)];
}

/// No sliver is thinner than an equilateral triangle: 2 over the root of 3.
constexpr double least_ratio = 1.2;

Status examine(const CheckOptions& options) {
    if (!(std::isfinite(options.tolerance_mm) && options.tolerance_mm >= 0)) {
        return Error{ErrorCode::invalid_argument, "the tolerance must be a number of mm, zero or more"};
    }
    if (!(std::isfinite(options.sliver_ratio) && options.sliver_ratio >= least_ratio)) {
        return Error{ErrorCode::invalid_argument, "the ratio of slivers must be a number from 1.2 up"};
    }
    return {};
}

/// inspect() counts the same faults by another method.
void assert_census([[maybe_unused]] const MeshCheck& check) {
    assert(check.of(Fault::boundary_edge).count == check.info.boundary_edges);
    assert(check.of(Fault::overfull_balanced).count + check.of(Fault::overfull_unbalanced).count ==
           check.info.overfull_edges);
    assert(check.of(Fault::mismatched_edge).count == check.info.mismatched_edges);
    assert(check.of(Fault::collapsed_face).count == check.info.degenerate);
    assert(check.shells.size() == check.info.shells);
}

/// Faults that need nothing but faces and edges. Each finder notes faults of its own kinds, so they run at once.
void find_joint_faults(const GridMesh& mesh, const EdgeTable& edges, Notes& notes, const Parallel& parallel) {
    constexpr std::array finders = {find_edge_faults, find_loops, find_split_vertices, find_flipped_faces};
    parallel.run(finders.size(), [&](std::size_t i, int) { finders[i](mesh, edges, notes); });
}

/// The stages.
MeshCheck diagnose(const MeshView& view, const MeshInfo& info, const CheckOptions& options) {
    MeshCheck check;
    check.info = info;
    check.tolerance_mm = options.tolerance_mm;
    check.sliver_ratio = options.sliver_ratio;
    const Parallel parallel(options.control);
    const GridMesh mesh = make_grid_mesh(view, options.transform, info.unit_mm, parallel);
    const EdgeTable edges(mesh, parallel);
    Notes notes(mesh, options.most_places, check);

    find_joint_faults(mesh, edges, notes, parallel);
    find_face_faults(mesh, options.sliver_ratio, notes);
    const std::vector<std::uint32_t> shell_of = find_shells(mesh, edges, notes, check, parallel);
    const std::vector<std::uint8_t> meets_other = find_meeting_faces(mesh, shell_of, check.shells, notes, parallel);
    const bool all_known = check.nesting_complete && !check.of(Fault::crossing_faces).at_least;
    find_misoriented_shells(check.shells, meets_other, all_known, notes);
    find_gaps(mesh, edges, options.tolerance_mm, notes, parallel);
    assert_census(check);
    return check;
}

Result<MeshCheck> check_or_throw(const MeshView& view, const CheckOptions& options) {
    if (const Status usable = examine(options); !usable) {
        return usable.error();
    }
    const Result<MeshInfo> info = inspect(view, {options.unit_mm, options.transform, options.control});
    if (!info) {
        return info.error();
    }
    if (view.triangle_count >= std::numeric_limits<std::uint32_t>::max() / 3) {
        return Error{ErrorCode::result_too_large, "check takes at most 1,431,655,764 triangles"};
    }
    return diagnose(view, info.value(), options);
}

}  // namespace

std::string_view key_of(Fault fault) noexcept {
    return names_of(fault).key;
}

std::string_view words_for(Fault fault, std::uint64_t count) noexcept {
    return count == 1 ? names_of(fault).one : names_of(fault).many;
}

bool MeshCheck::complete() const noexcept {
    return nesting_complete &&
           std::none_of(findings.begin(), findings.end(), [](const FaultFinding& finding) { return finding.at_least; });
}

bool MeshCheck::clean() const noexcept {
    std::uint64_t faults = 0;
    for (const FaultFinding& finding : findings) {
        faults += finding.count;
    }
    return info.closed && faults == of(Fault::needle_face).count + of(Fault::cap_face).count;
}

Result<MeshCheck> check(const MeshView& mesh, const CheckOptions& options) noexcept {
    return guarded(options.control, [&] { return check_or_throw(mesh, options); });
}

}  // namespace lamella
