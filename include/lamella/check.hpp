// What is wrong with a mesh, and where.
//
//     const lamella::Result<lamella::MeshCheck> check = lamella::check(mesh);
//     if (check && !check->clean()) {
//         const lamella::FaultFinding& edges = check->of(lamella::Fault::boundary_edge);
//         std::printf("%zu boundary edges\n", static_cast<std::size_t>(edges.count));
//         for (const lamella::FaultPlace& place : edges.places) {
//             std::printf("  at %g %g %g mm\n", place.points_mm[0][0], place.points_mm[0][1], place.points_mm[0][2]);
//         }
//     }
//
// Slicing needs no check. Before a slice that has to be right, `counts_only` soon says whether a mesh is closed; the
// whole check says what is wrong and where, down to faces that cross. Whether the result is right, audit() says.
//
// It finds every departure from a closed, oriented surface without self-intersections (section 1.3 of the paper), on the
// grid that slicing would use.
//
// Exact, by integer arithmetic on the grid: all edges, vertices, duplicates, orientations, volumes' signs, faces without
// area, and whether two triangles cross, overlap or touch. Approximate, in double (relative error below 1e-12): the ratio of
// slivers, the distance of T-junctions and cracks, lengths, volumes, and the point at which crossing triangles are said to
// meet.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"

namespace lamella {

/// What can be wrong. An edge is ordinary when it has two faces that run opposite ways.
enum class Fault : std::uint8_t {
    boundary_edge,        ///< an edge with one face
    boundary_loop,        ///< boundary edges joined end to end; closed unless an edge with three or more faces breaks in
    overfull_balanced,    ///< an edge with more than two faces, as many one way as the other: solids that touch
    overfull_unbalanced,  ///< with more one way than the other
    mismatched_edge,      ///< with two faces that run the same way
    split_vertex,         ///< its triangles, joined over edges with two faces, form several fans: not one cone
    flipped_face,       ///< against most faces of its patch (joined over edges with two faces; at a tie the first is right)
    one_sided_patch,    ///< no orientation of its faces agrees, as on a Moebius strip; none of them counts as flipped
    duplicate_face,     ///< a further face with the same vertices and orientation
    opposite_face,      ///< two faces with the same vertices and opposite orientations
    collapsed_face,     ///< two vertices are one on the grid; slicing drops it, and no other count includes it
    zero_area_face,     ///< three distinct vertices on a line; not tested against other faces
    needle_face,        ///< a sliver whose shortest side is under a tenth of the longest
    cap_face,           ///< any other sliver: one angle is nearly half a turn
    misoriented_shell,  ///< a closed shell that is a cavity by its orientation and a solid by its depth, or the reverse;
                        ///< deeper than 0 only where neither it nor a shell around it meets another
    crossing_faces,     ///< two faces whose insides cross
    overlapping_faces,  ///< two faces of one plane whose insides overlap (duplicates are counted as such)
    touching_faces,     ///< two faces that meet elsewhere than in a common edge or vertex, and neither cross nor overlap
    t_junction,         ///< a vertex of the boundary, within the tolerance of the inside of another face's boundary edge
    crack,              ///< two vertices of the boundary within the tolerance of one another, not joined by an edge
};
inline constexpr std::size_t fault_count = 20;

/// "boundary_edges", ...: the key in reports.
std::string_view key_of(Fault fault) noexcept;
/// "boundary edges", ...; for a count of one, "boundary edge".
std::string_view words_for(Fault fault, std::uint64_t count) noexcept;

/// Where a fault is. Points are in mm, after the transform.
struct FaultPlace {
    std::array<std::array<double, 3>, 3> points_mm{};  ///< a point, the ends of an edge or gap, or a face's corners
    int point_count = 1;
    std::array<std::int64_t, 2> triangles{-1, -1};  ///< faces that are part of it, as numbered in the input, or -1
    std::uint64_t parts = 0;                        ///< faces at an edge, edges of a loop, fans at a vertex; else 0
    double measure = 0;   ///< a loop's length and a gap's width in mm, a sliver's ratio, a shell's volume in mm³; else 0
    bool closed = false;  ///< of a loop
};

/// All faults of one kind.
struct FaultFinding {
    std::uint64_t count = 0;
    bool at_least = false;  ///< the search was cut short: the true count may be larger
    /// The first along a curve that fills the mesh's box (Morton order): no order of triangles or vertices and no number of
    /// threads changes them. At most CheckOptions::most_places.
    std::vector<FaultPlace> places;
};

/// A set of triangles connected over edges.
struct MeshShell {
    std::array<double, 3> first_mm{};  ///< its vertex with the smallest x, then y, then z
    std::int64_t triangle = -1;        ///< one of its triangles at that vertex
    std::uint64_t triangles = 0;
    bool closed = false;       ///< every edge has as many faces one way as the other
    double volume_mm3 = 0;     ///< signed; 0 unless closed
    int orientation = 0;       ///< sign of the volume: 1 a solid, -1 a cavity, 0 neither or not closed
    int depth = 0;             ///< number of closed shells around it
    std::int64_t parent = -1;  ///< the innermost of them, as an index into MeshCheck::shells, or -1
};

struct CheckTimes {      ///< wall time of the stages, ms
    double measure = 0;  ///< box, volume and area
    double faces = 0;    ///< vertices numbered, faces put in order
    double edges = 0;    ///< faces brought together at their edges
    double joints = 0;   ///< faults of edges, vertices, orientations and single faces
    double shells = 0;
    double meeting = 0;  ///< faces that cross, overlap or touch
    double gaps = 0;     ///< T-junctions and cracks
};

/// Whether a mesh is too small for its grid, or too far from the origin for its numbers.
struct MeshScale {
    double diagonal_mm = 0;     ///< of the box
    double farthest_mm = 0;     ///< the largest magnitude of a coordinate
    double number_step_mm = 0;  ///< between neighbouring numbers there
    double finest_grid_mm = 0;  ///< what lamella::finest_grid chooses
    /// The diagonal is under 2^20 grid units: details may have been lost. finest_grid_mm tells whether a finer grid would
    /// do.
    bool coarse_grid = false;
    /// The step exceeds a tenth of the detail that matters: what was lost when the coordinates were stored shows. No grid
    /// brings it back.
    bool coarse_numbers = false;
};

/// Box and grid as check() or a SliceInfo state them; `number` holds the input's coordinates; `detail_mm`: the layer height,
/// or the side of a voxel. O(1), never fails.
MeshScale judge_scale(const Box& box, Number number, double grid_mm, double detail_mm = 0.2) noexcept;

struct MeshCheck {
    std::uint64_t triangles = 0;
    std::uint64_t degenerate = 0;  ///< two equal vertices on the grid
    Box box;
    double volume_mm3 = 0;  ///< signed; meaningful for closed meshes
    double area_mm2 = 0;
    std::uint64_t edges = 0;           ///< distinct, degenerate triangles left out
    std::uint64_t boundary_edges = 0;  ///< with one face
    /// boundary_edges of the coordinates as they are. More than those of the grid: it joins vertices that nearly meet.
    std::uint64_t exact_boundary_edges = 0;
    std::uint64_t overfull_edges = 0;    ///< with more than two
    std::uint64_t mismatched_edges = 0;  ///< with two faces that run the same way (a flipped neighbour)
    std::uint64_t shell_count = 0;       ///< sets of triangles connected over edges
    double grid_mm = 0;                  ///< the grid on which vertices were compared
    /// Every edge has as many faces one way as the other.
    bool closed = false;
    // What follows is found unless CheckOptions::counts_only.
    std::array<FaultFinding, fault_count> findings{};
    std::vector<MeshShell> shells;  ///< all, by first_mm
    bool nesting_complete = true;   ///< false: rays through too many triangles; depths are then too small for some
    double tolerance_mm = 0;
    double sliver_ratio = 0;
    CheckTimes ms;

    const FaultFinding& of(Fault fault) const noexcept { return findings[static_cast<std::size_t>(fault)]; }
    /// No search was cut short.
    bool complete() const noexcept;
    /// No fault was found but slivers, which slicing does not mind.
    bool clean() const noexcept;
};

struct CheckOptions {
    Frame frame{};                 ///< as in SliceOptions
    bool counts_only = false;      ///< closed or not, box, volume, area and edges, without faults, places and shells
    double tolerance_mm = 0.01;    ///< for T-junctions and cracks
    double sliver_ratio = 100;     ///< longest side over the height on it, from which on a face is a sliver
    std::size_t most_places = 10;  ///< kept of each kind; all are counted
};

/// O(n log n) for meshes whose triangles are spread out; about 150 bytes a triangle beside the mesh. Where triangles pile up
/// the search for pairs stops after some eight million exact tests and sixteen for each triangle, which take a second or
/// two, and says so: FaultFinding::at_least. Of several faces on the same vertices one is tested. Shells are nested exactly
/// where they do not cross; one that touches another wherever it was probed counts as outside. The answer does not depend on
/// threads. Errors: empty_mesh, invalid_argument (an index beyond the vertices, an unusable grid, a tolerance or
/// ratio out of range, negative threads), bad_coordinate (also: too large for the grid asked for), result_too_large from
/// 2^32 / 3 triangles on, out_of_memory, cancelled. With `counts_only` about 100 bytes a triangle.
Result<MeshCheck> check(const MeshView& mesh, const CheckOptions& options = {}, const Context& context = {}) noexcept;

}  // namespace lamella
