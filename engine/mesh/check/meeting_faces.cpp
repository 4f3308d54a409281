// Faces that cross, overlap or touch. Of the pairs whose boxes meet most share a vertex with an embedded star; most others
// are told apart in double; the rest is tested exactly.
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "mesh/check/finders.hpp"
#include "mesh/check/meeting.hpp"
#include "mesh/check/pair_search.hpp"

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

RealFace real(const GridMesh& mesh, std::size_t face) {
    return {mesh.faces[face].corners, mesh.corners(mesh.faces[face])};
}

/// Two faces that meet.
struct Met {
    Meeting meeting;
    FacePair faces;
};

/// The vertices of eight faces that have embedded stars.
class StarBlock {
public:
    void set(std::size_t lane, const Face& face, const EmbeddedStars& stars) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t vertex = face.corners[corner];
            vertices_[corner][lane] = static_cast<std::int32_t>(stars.contains(vertex) ? vertex : none);
        }
    }

    /// Which of the faces have one in common with the other.
    LaneBits share(const StarBlock& other, std::size_t lane) const {
        Int32x8 same(0);
        for (const Int32x8::Stored& theirs : other.vertices_) {
            if (const std::int32_t vertex = theirs[lane]; vertex != static_cast<std::int32_t>(none)) {
                const Int32x8 all(vertex);
                same =
                    same | (all == Int32x8(vertices_[0])) | (all == Int32x8(vertices_[1])) | (all == Int32x8(vertices_[2]));
            }
        }
        return same.bits();
    }

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    std::array<Int32x8::Stored, 3> vertices_;  ///< by corner
};

class MeetingSearch {
public:
    MeetingSearch(const GridMesh& mesh, const FaceTree& tree, const EmbeddedStars& stars,
                  const Array<std::uint32_t>& shell_of, const std::vector<MeshShell>& shells, std::size_t most,
                  const Parallel& parallel)
        : mesh_(mesh),
          tree_(tree),
          shell_of_(shell_of),
          shells_(shells),
          parallel_(parallel),
          blocks_(parallel.memory()),
          tallies_(kinds.size(), Tally<FacePair>(most)),
          meets_other_(shells.size()) {
        blocks_.resize_discarding(tree.groups());
        parallel.run_ranges(blocks_.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t item = tree.group_begin(begin); item != tree.group_end(end - 1); ++item) {
                blocks_[item / fan].set(item % fan, mesh.faces[item], stars);
            }
        });
    }

    /// True if nothing was left out.
    bool run(double progress) {
        const std::size_t groups = tree_.groups();
        parallel_.begin_stage(progress, BudgetedSearch<Met>::runs_for(groups));
        BudgetedSearch<Met> search(groups, search_budget(tree_.size()), parallel_);
        return search.run(
            [&](std::size_t group, std::size_t limit, std::vector<Met>& found) { return meet_group(group, limit, found); },
            [&](const Met& met) { note(met); });
    }

    Tally<FacePair>& tally(std::size_t kind) { return tallies_[kind]; }
    std::vector<std::uint8_t> meets_other() { return std::move(meets_other_); }

private:
    static constexpr std::size_t fan = BoxTree<GridVertex>::fan;
    static constexpr std::size_t grain = 1024;  ///< groups

    /// Compares the faces of a group with all after them in the tree. Returns what it cost.
    std::size_t meet_group(std::size_t group, std::size_t limit, std::vector<Met>& found) const {
        std::array<RealFace, fan> own;
        const std::size_t begin = tree_.group_begin(group);
        for (std::size_t item = begin; item != tree_.group_end(group); ++item) {
            own[item - begin] = real(mesh_, item);
        }
        return tree_.search_pairs(group, limit, [&](std::size_t item, LaneBits bits) {
            bits &= ~blocks_[group].share(blocks_[item / fan], item % fan);
            if (bits == 0) {
                return;
            }
            const RealFace other = real(mesh_, item);
            each_lane(bits, [&](std::size_t lane) {
                if (!are_apart(own[lane], other)) {
                    meet_exactly(begin + lane, item, found);
                }
            });
        });
    }

    void meet_exactly(std::size_t face, std::size_t other, std::vector<Met>& found) const {
        const Meeting meeting = meet(exact(mesh_, face), exact(mesh_, other));
        if (meeting != Meeting::none) {
            const auto [first, second] = std::minmax(face, other);
            found.push_back({meeting, {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(second)}});
        }
    }

    void note(const Met& met) {
        tallies_[place_among_kinds(met.meeting)].add(met.faces);
        const auto [face, other] = met.faces;
        const std::uint32_t shell = shell_of_[face];
        const std::uint32_t other_shell = shell_of_[other];
        if (shell != other_shell && shells_[shell].closed && shells_[other_shell].closed) {
            meets_other_[shell] = meets_other_[other_shell] = 1;
        }
    }

    const GridMesh& mesh_;
    const FaceTree& tree_;
    const Array<std::uint32_t>& shell_of_;
    const std::vector<MeshShell>& shells_;
    const Parallel& parallel_;
    Array<StarBlock> blocks_;                ///< by group
    std::vector<Tally<FacePair>> tallies_;   ///< as in `kinds`
    std::vector<std::uint8_t> meets_other_;  ///< by shell
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
    MeetingSearch search(mesh, tree, stars, shell_of, shells, faults.most(), parallel);
    const bool complete = search.run(progress);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        FaultFinding& finding = faults.of(kinds[i]);
        finding.at_least = !complete;
        const bool cross = kinds[i] == Fault::crossing_faces;
        search.tally(i).fill_in(finding, [&](const FacePair& pair) { return place_of(mesh, pair, cross); });
    }
    return search.meets_other();
}

}  // namespace lamella
