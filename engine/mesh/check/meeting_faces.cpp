// Faces that cross, overlap or touch. Of the pairs whose boxes meet most share a vertex with an embedded star; the rest is
// tested exactly.
#include <array>
#include <cstddef>
#include <vector>

#include "mesh/check/finders.hpp"
#include "mesh/check/meeting.hpp"

namespace lamella {

namespace {

/// Faces by number, the smaller first.
using FacePair = std::array<std::uint32_t, 2>;

/// By Meeting, from the first at which faces meet.
constexpr std::array kinds = {Fault::touching_faces, Fault::crossing_faces, Fault::overlapping_faces};
constexpr std::size_t place_among_kinds(Meeting meeting) {
    return static_cast<std::size_t>(meeting) - static_cast<std::size_t>(Meeting::touch);
}

ExactFace exact(const GridMesh& mesh, std::size_t face) {
    return {mesh.faces[face].corners, mesh.corners(mesh.faces[face])};
}

/// Two faces that meet.
struct Met {
    Meeting meeting;
    FacePair faces;
};

/// The vertices of a group's faces that have embedded stars.
class GroupStars {
public:
    GroupStars(const GridMesh& mesh, const EmbeddedStars& stars, std::size_t begin, std::size_t end) {
        constexpr std::int32_t none = -1;
        for (std::size_t face = begin; face != end; ++face) {
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::uint32_t vertex = mesh.faces[face].corners[corner];
                vertices_[corner][face - begin] = stars.contains(vertex) ? static_cast<std::int32_t>(vertex) : none;
            }
        }
    }

    /// Which faces share one with the other.
    LaneBits shared_by(const Face& other) const {
        Int32x8 same(0);
        for (const std::uint32_t vertex : other.corners) {
            const Int32x8 all(static_cast<std::int32_t>(vertex));
            same = same | (all == Int32x8(vertices_[0])) | (all == Int32x8(vertices_[1])) | (all == Int32x8(vertices_[2]));
        }
        return same.bits();
    }

private:
    std::array<Int32x8::Stored, 3> vertices_{};  ///< by corner
};

/// For a crossing, the segment in which the faces meet; else the middle of their boxes' intersection.
FaultPlace place_of(const GridMesh& mesh, const FacePair& pair, bool cross) {
    FaultPlace place;
    place.triangles = {mesh.faces[pair[0]].source, mesh.faces[pair[1]].source};
    if (cross) {
        const auto segment = crossing_segment(exact(mesh, pair[0]), exact(mesh, pair[1]));
        place.point_count = 2;
        for (std::size_t end = 0; end < 2; ++end) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                place.points_mm[end][axis] = segment[end][axis] * (2 * mesh.grid_mm);
            }
        }
        return place;
    }
    const SpaceBox a = SpaceBox::around(mesh.corners(mesh.faces[pair[0]]));
    const SpaceBox b = SpaceBox::around(mesh.corners(mesh.faces[pair[1]]));
    const auto [low, high] = SpaceBox{high_corner(a.low, b.low), low_corner(a.high, b.high)}.numbers();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        place.points_mm[0][axis] = static_cast<double>(std::int64_t{low[axis]} + high[axis]) / 2 * mesh.grid_mm;
    }
    return place;
}

}  // namespace

FaceTree make_face_tree(const GridMesh& mesh, const EmbeddedStars& stars, const Parallel& parallel) {
    FaceTree tree(parallel.memory());
    tree.assign(
        mesh.faces.size(),
        [&](std::size_t i) {
            const Face& face = mesh.faces[i];
            const bool again = i > 0 && vertex_set(face) == vertex_set(mesh.faces[i - 1]);
            return again || !stars.has_area(i) ? SpaceBox::nothing() : SpaceBox::around(mesh.corners(face));
        },
        parallel);
    return tree;
}

std::vector<std::uint8_t> find_meeting_faces(const GridMesh& mesh, const FaceTree& tree, const EmbeddedStars& stars,
                                             const Array<std::uint32_t>& shell_of, const std::vector<MeshShell>& shells,
                                             FaultCollector& faults, double progress, const Parallel& parallel) {
    const std::size_t groups = tree.groups();
    std::vector<Tally<FacePair>> tallies(kinds.size(), Tally<FacePair>(faults.most()));
    std::vector<std::uint8_t> meets_other(shells.size());
    // Compares the faces of a group with all after them in the tree.
    const auto meet_group = [&](std::size_t group, std::size_t limit, std::vector<Met>& found) {
        const std::size_t begin = tree.group_begin(group);
        const GroupStars own(mesh, stars, begin, tree.group_end(group));
        return tree.search_pairs(group, limit, [&](std::size_t other, LaneBits bits) {
            bits &= ~own.shared_by(mesh.faces[other]);
            if (bits == 0) {
                return;
            }
            const ExactFace theirs = exact(mesh, other);
            each_lane(bits, [&](std::size_t lane) {
                if (const Meeting meeting = meet(exact(mesh, begin + lane), theirs); meeting != Meeting::none) {
                    found.push_back(
                        {meeting, {static_cast<std::uint32_t>(begin + lane), static_cast<std::uint32_t>(other)}});
                }
            });
        });
    };
    const auto note = [&](const Met& met) {
        tallies[place_among_kinds(met.meeting)].add(met.faces);
        const std::uint32_t shell = shell_of[met.faces[0]];
        const std::uint32_t other = shell_of[met.faces[1]];
        if (shell != other && shells[shell].closed && shells[other].closed) {
            meets_other[shell] = meets_other[other] = 1;
        }
    };
    parallel.begin_stage(progress, groups / queries_a_run + 1);
    const bool complete = search_within<Met>(search_budget(tree.size()), groups, parallel, meet_group, note);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        FaultFinding& finding = faults.of(kinds[i]);
        finding.at_least = !complete;
        const bool cross = kinds[i] == Fault::crossing_faces;
        tallies[i].fill_in(finding, [&](const FacePair& pair) { return place_of(mesh, pair, cross); });
    }
    return meets_other;
}

}  // namespace lamella
