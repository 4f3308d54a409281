#include "lamella/check.hpp"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "mesh/check/finders.hpp"
#include "slicing/grid/bounds.hpp"

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

/// How far the progress is when a stage ends, and how many calls of run() it takes: measured on scans of bones.
struct Share {
    double fraction;
    std::size_t runs;
};
constexpr double measure_share = 0.04;
constexpr Share faces_share = {0.24, 14};
constexpr Share edges_share = {0.36, 8};
constexpr Share joints_share = {0.48, 8};
constexpr Share tree_share = {0.54, 8};
constexpr Share shells_share = {0.60, 9};
constexpr double meeting_share = 0.97;
constexpr Share gaps_share = {0.99, 40};
constexpr Share counted_faces_share = {0.5, 14};
constexpr Share counted_edges_share = {0.99, 13};

/// The stages.
class Diagnosis {
public:
    Diagnosis(const MeshView& view, const CheckOptions& options, const Parallel& parallel)
        : view_(view), options_(options), parallel_(parallel) {
        check_.tolerance_mm = options.tolerance_mm;
        check_.sliver_ratio = options.sliver_ratio;
    }

    Result<MeshCheck> run() {
        measure_mesh(view_, options_.frame, parallel_, measure_share, check_);
        check_.ms.measure = lap();
        begin(options_.counts_only ? counted_faces_share : faces_share);
        const GridMesh mesh = make_grid_mesh(view_, options_.frame, check_, parallel_);
        if (mesh.faces.empty()) {
            return all_collapsed(view_.triangle_count, check_.grid_mm);
        }
        check_.ms.faces = lap();
        begin(options_.counts_only ? counted_edges_share : edges_share);
        const EdgeTable edges(mesh, parallel_);
        check_.ms.edges = lap();
        options_.counts_only ? count(mesh, edges) : find_faults(mesh, edges);
        parallel_.finish();
        return std::move(check_);
    }

private:
    void begin(const Share& share) const { parallel_.begin_stage(share.fraction, share.runs); }

    /// Since the last call.
    double lap() {
        const Clock::time_point now = Clock::now();
        return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
    }

    void count(const GridMesh& mesh, const EdgeTable& edges) {
        FaultCollector faults(mesh, 0, check_.findings);
        const std::uint64_t unbalanced = find_edge_faults(mesh, edges, faults, parallel_);
        std::uint32_t shells = 0;
        join_shells(mesh, edges, shells, parallel_);
        fill_in_counts(mesh, edges, unbalanced);
        check_.shell_count = shells;
        check_.findings = {};
    }

    void find_faults(const GridMesh& mesh, const EdgeTable& edges) {
        FaultCollector faults(mesh, options_.most_places, check_.findings);
        begin(joints_share);
        const EmbeddedStars stars(mesh, edges, parallel_);
        const std::uint64_t unbalanced = find_edge_faults(mesh, edges, faults, parallel_);
        find_loops(mesh, edges, faults, parallel_);
        find_face_faults(mesh, options_.sliver_ratio, faults, parallel_);
        find_split_vertices(mesh, stars, faults, parallel_);
        find_flipped_faces(mesh, edges, faults, parallel_);
        check_.ms.joints = lap();
        begin(tree_share);
        const FaceTree tree = make_face_tree(mesh, stars, parallel_);
        check_.ms.meeting = lap();
        begin(shells_share);
        const Array<std::uint32_t> shell_of = find_shells(mesh, edges, tree, faults, check_, parallel_);
        check_.ms.shells = lap();
        const std::vector<std::uint8_t> meets_other =
            find_meeting_faces(mesh, tree, stars, shell_of, check_.shells, faults, meeting_share, parallel_);
        const bool all_known = check_.nesting_complete && !check_.of(Fault::crossing_faces).at_least;
        find_misoriented_shells(check_.shells, meets_other, all_known, faults);
        check_.ms.meeting += lap();
        begin(gaps_share);
        find_gaps(mesh, edges, options_.tolerance_mm, faults, parallel_);
        check_.ms.gaps = lap();
        fill_in_counts(mesh, edges, unbalanced);
    }

    void fill_in_counts(const GridMesh& mesh, const EdgeTable& edges, std::uint64_t unbalanced) {
        check_.degenerate = mesh.collapsed.size();
        check_.edges = edges.size();
        check_.boundary_edges = check_.of(Fault::boundary_edge).count;
        check_.overfull_edges = check_.of(Fault::overfull_balanced).count + check_.of(Fault::overfull_unbalanced).count;
        check_.mismatched_edges = check_.of(Fault::mismatched_edge).count;
        check_.shell_count = check_.shells.size();
        check_.closed = unbalanced == 0;
        check_.exact_boundary_edges = check_.boundary_edges;
        if (mesh.joined) {
            const GridMesh exact = make_exact_mesh(weld_equal(view_, parallel_), parallel_);
            check_.exact_boundary_edges = EdgeTable(exact, parallel_).boundary().size();
        }
        check_.ms.edges += lap();
    }

    const MeshView& view_;
    const CheckOptions& options_;
    const Parallel& parallel_;
    Clock::time_point last_ = Clock::now();
    MeshCheck check_;
};

Result<MeshCheck> check_or_throw(const MeshView& view, const CheckOptions& options, Context context) {
    if (const Status usable = examine(options); !usable) {
        return usable.error();
    }
    if (view.triangle_count >= std::numeric_limits<std::uint32_t>::max() / 3) {
        return Error{ErrorCode::result_too_large, "check takes at most 1,431,655,764 triangles"};
    }
    context.memory = nullptr;  // the host's is for what calls return
    const Parallel parallel(context);
    return Diagnosis(view, options, parallel).run();
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
    return closed && faults == of(Fault::needle_face).count + of(Fault::cap_face).count;
}

Result<MeshCheck> check(const MeshView& mesh, const CheckOptions& options, const Context& context) noexcept {
    return guarded(context, [&] { return check_or_throw(mesh, options, context); });
}

}  // namespace lamella
