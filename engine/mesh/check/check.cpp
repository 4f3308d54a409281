// The stages of check() and orient_shells(); box, area and volume of a mesh, and the scale of its grid.
#include "lamella/check.hpp"
#include "lamella/weld.hpp"

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
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

/// Sums are made per chunk and then over the chunks in order, so that they do not depend on threads.
constexpr std::size_t chunk_triangles = 8192;

/// Fills in volume, as the sum of tetrahedra to the middle of the box, so near that little cancels, and area.
void add_faces(const MeshView& mesh, const Placing& placing, const Parallel& parallel, MeshCheck& check) {
    struct Sums {
        double six_volumes = 0;
        double two_areas = 0;
    };
    const std::size_t chunks = (mesh.triangle_count + chunk_triangles - 1) / chunk_triangles;
    const PlacedReader read(mesh, placing);
    std::vector<Sums> parts(chunks);
    parallel.run(chunks, [&](std::size_t chunk, int) {
        Sums part;
        const std::size_t end = std::min(mesh.triangle_count, (chunk + 1) * chunk_triangles);
        for (std::size_t t = chunk * chunk_triangles; t != end; ++t) {
            const auto& [v] = read(t);
            double six_volumes = 0;
            double square = 0;
            for (std::size_t x = 0; x < 3; ++x) {
                const std::size_t y = (x + 1) % 3;
                const std::size_t z = (x + 2) % 3;
                const double normal = (v[3 + y] - v[y]) * (v[6 + z] - v[z]) - (v[3 + z] - v[z]) * (v[6 + y] - v[y]);
                six_volumes += (v[x] - (check.box.min_mm[x] + check.box.max_mm[x]) / 2) * normal;
                square += normal * normal;
            }
            part.six_volumes += six_volumes;
            part.two_areas += std::sqrt(square);
        }
        parts[chunk] = part;
    });
    Sums sum;
    for (const Sums& part : parts) {
        sum.six_volumes += part.six_volumes;
        sum.two_areas += part.two_areas;
    }
    check.volume_mm3 = sum.six_volumes / 6;
    check.area_mm2 = sum.two_areas / 2;
}

constexpr double fewest_units = 1 << 20;  ///< along the diagonal
constexpr double coarsest_step = 0.1;     ///< as a share of a detail

/// From the power of two below `value` to the next number of that type.
double number_step(double value, Number number) noexcept {
    return value == 0 ? 0 : std::ldexp(1.0, std::ilogb(value) - (number == Number::f32 ? 23 : 52));
}

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

/// The stages. How far the progress is when one ends was measured on scans of bones.
class Diagnosis {
public:
    Diagnosis(const MeshView& view, const CheckOptions& options, const Parallel& parallel)
        : view_(view), options_(options), parallel_(parallel) {
        check_.tolerance_mm = options.tolerance_mm;
        check_.sliver_ratio = options.sliver_ratio;
    }

    Result<MeshCheck> run() {
        measure_mesh(view_, options_.frame, parallel_, 0.04, check_);
        check_.ms.measure = lap();
        parallel_.begin_stage(options_.counts_only ? 0.5 : 0.24, 14);
        const GridMesh mesh = make_grid_mesh(view_, options_.frame, check_, parallel_);
        if (mesh.faces.empty()) {
            return all_collapsed(view_.triangle_count, check_.grid_mm);
        }
        check_.ms.faces = lap();
        parallel_.begin_stage(options_.counts_only ? 0.99 : 0.36, options_.counts_only ? 13 : 8);
        const EdgeTable edges(mesh, parallel_);
        check_.ms.edges = lap();
        options_.counts_only ? count(mesh, edges) : find_faults(mesh, edges);
        parallel_.finish();
        return std::move(check_);
    }

private:
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
        parallel_.begin_stage(0.48, 8);
        const EmbeddedStars stars(mesh, edges, parallel_);
        const std::uint64_t unbalanced = find_edge_faults(mesh, edges, faults, parallel_);
        find_loops(mesh, edges, faults, parallel_);
        find_face_faults(mesh, options_.sliver_ratio, faults, parallel_);
        find_split_vertices(mesh, stars, faults, parallel_);
        find_flipped_faces(mesh, edges, faults, parallel_);
        check_.ms.joints = lap();
        parallel_.begin_stage(0.54, 8);
        const FaceTree tree = make_face_tree(mesh, stars, parallel_);
        check_.ms.meeting = lap();
        parallel_.begin_stage(0.60, 9);
        const Array<std::uint32_t> shell_of = find_shells(mesh, edges, tree, faults, check_, parallel_);
        check_.ms.shells = lap();
        const std::vector<std::uint8_t> meets_other =
            find_meeting_faces(mesh, tree, stars, shell_of, check_.shells, faults, 0.97, parallel_);
        const bool all_known = check_.nesting_complete && !check_.of(Fault::crossing_faces).at_least;
        find_misoriented_shells(check_.shells, meets_other, all_known, faults);
        check_.ms.meeting += lap();
        parallel_.begin_stage(0.99, 40);
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

/// Turns shells by their nesting in space: the first stages, and rays that tell what lies wholly within what.
Result<OrientedMesh> orient_or_throw(const MeshView& view, const Frame& frame, const Context& context) {
    Context own = context;
    own.memory = nullptr;  // the host's is for the mesh
    const Parallel parallel(own);
    OrientedMesh oriented{.mesh = require(weld(view, 0, parallel.within(context)))};
    MeshCheck found;
    measure_mesh(oriented.view(), frame, parallel, 0.3, found);
    parallel.begin_stage(0.5, 14);
    const GridMesh grid = make_grid_mesh(oriented.view(), frame, found, parallel);
    if (!grid.faces.empty()) {
        parallel.begin_stage(0.6, 8);
        const EdgeTable edges(grid, parallel);
        parallel.begin_stage(0.7, 7);
        const EmbeddedStars stars(grid, edges, parallel);
        parallel.begin_stage(0.8, 9);
        const FaceTree tree = make_face_tree(grid, stars, parallel);
        parallel.begin_stage(0.99, 16);
        const FaultCollector faults(grid, 0, found.findings);
        const Array<std::uint32_t> shell_of = find_shells(grid, edges, tree, faults, found, parallel, true);
        for (std::size_t face = 0; face < grid.faces.size(); ++face) {
            if (is_misoriented(found.shells[shell_of[face]])) {
                const std::size_t first = 3 * std::size_t{grid.faces[face].source};
                std::swap(oriented.mesh.indices[first + 1], oriented.mesh.indices[first + 2]);
            }
        }
    }
    oriented.shells = found.shells.size();
    oriented.turned_shells =
        static_cast<std::uint64_t>(std::count_if(found.shells.begin(), found.shells.end(), is_misoriented));
    const bool all_closed =
        std::all_of(found.shells.begin(), found.shells.end(), [](const MeshShell& shell) { return shell.closed; });
    oriented.complete = found.nesting_complete && (oriented.turned_shells == 0 || all_closed);
    parallel.finish();
    return oriented;
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

void measure_mesh(const MeshView& mesh, const Frame& frame, const Parallel& parallel, double progress, MeshCheck& check) {
    parallel.begin_stage(progress / 2);
    const SharedFrame chosen = choose_frame(mesh, frame, false, {}, parallel);
    check.box = box_of(chosen.bounds);
    check.triangles = mesh.triangle_count;
    check.grid_mm = chosen.unit.mm;
    parallel.begin_stage(progress);
    add_faces(mesh, placing_of(mesh, frame), parallel, check);
}

MeshScale judge_scale(const Box& box, Number number, double grid_mm, double detail_mm) noexcept {
    const auto& [low, high] = box;
    MeshScale scale;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        scale.farthest_mm = std::max({scale.farthest_mm, std::abs(low[axis]), std::abs(high[axis])});
    }
    scale.diagonal_mm = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    scale.number_step_mm = number_step(scale.farthest_mm, number);
    scale.finest_grid_mm = finest_unit(scale.farthest_mm);
    scale.coarse_grid = scale.diagonal_mm < fewest_units * grid_mm;
    scale.coarse_numbers = scale.number_step_mm > coarsest_step * detail_mm;
    return scale;
}

Result<OrientedMesh> orient_shells(const MeshView& mesh, double grid_mm, const Context& context) noexcept {
    return guarded(context, [&] { return orient_or_throw(mesh, {.grid_mm = grid_mm}, context); });
}

}  // namespace lamella
