// Faces that cross, overlap or touch: every pair whose boxes meet is tested exactly. Of faces on the same vertices only
// one is tested, as they meet the same others: a body exported a thousand times costs no more than once.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

#include "mesh/check/box_tree.hpp"
#include "mesh/check/finders.hpp"
#include "mesh/check/meeting.hpp"
#include "mesh/check/pair_search.hpp"

namespace lamella {

namespace {

/// Faces by number, the smaller first.
using FacePair = std::array<std::uint32_t, 2>;

constexpr std::array kinds = {std::pair{Meeting::cross, Fault::crossing_faces},
                              std::pair{Meeting::overlap, Fault::overlapping_faces},
                              std::pair{Meeting::touch, Fault::touching_faces}};

ExactFace exact(const GridMesh& mesh, std::uint32_t face) {
    return {mesh.faces[face].corners, mesh.corners(mesh.faces[face])};
}

RealFace real(const GridMesh& mesh, std::uint32_t face) {
    return {mesh.faces[face].corners, mesh.corners(mesh.faces[face])};
}

/// Two faces that meet.
struct Met {
    Meeting meeting;
    FacePair faces;
};

class MeetingSearch {
public:
    MeetingSearch(const GridMesh& mesh, const std::vector<std::uint32_t>& shell_of, const std::vector<MeshShell>& shells,
                  std::size_t most, const Parallel& parallel)
        : mesh_(mesh),
          shell_of_(shell_of),
          shells_(shells),
          parallel_(parallel),
          tallies_(static_cast<std::size_t>(parallel.threads()),
                   {Tally<FacePair>(most), Tally<FacePair>(most), Tally<FacePair>(most)}),
          meets_other_(shells.size()) {
        choose_faces();
    }

    /// Whether nothing was left out.
    bool run(double progress) {
        const BoxTree tree(
            faces_.size(), [&](std::size_t i) { return Box::around(mesh_.corners(mesh_.faces[faces_[i]])); }, parallel_);
        parallel_.begin_stage(progress, BudgetedSearch<Met>::runs_for(tree.groups()));
        BudgetedSearch<Met> search(tree.groups(), search_budget(tree.size()), parallel_);
        return search.run([&](std::size_t group, std::size_t limit,
                              std::vector<Met>& found) { return meet_group(tree, group, limit, found); },
                          [&](std::size_t, const std::vector<Met>& found, int worker) {
                              for (const Met& met : found) {
                                  note(met, worker);
                              }
                          });
    }

    Tally<FacePair>& total(std::size_t kind) {
        for (std::size_t worker = 1; worker < tallies_.size(); ++worker) {
            tallies_[0][kind].add(tallies_[worker][kind]);
        }
        return tallies_[0][kind];
    }

    std::vector<std::uint8_t> meets_other() const { return {meets_other_.begin(), meets_other_.end()}; }

private:
    static constexpr std::size_t grain = 8192;

    /// Those with area, of several on the same vertices the first.
    void choose_faces() {
        const std::size_t ranges = mesh_.faces.size() / grain + 1;
        std::vector<std::vector<std::uint32_t>> found(ranges);
        parallel_.run(ranges, [&](std::size_t range, int) {
            const std::size_t end = mesh_.faces.size() * (range + 1) / ranges;
            for (std::size_t face = mesh_.faces.size() * range / ranges; face != end; ++face) {
                const bool again = face > 0 && vertex_set(mesh_.faces[face]) == vertex_set(mesh_.faces[face - 1]);
                if (!again && exact(mesh_, static_cast<std::uint32_t>(face)).has_area()) {
                    found[range].push_back(static_cast<std::uint32_t>(face));
                }
            }
        });
        for (const std::vector<std::uint32_t>& own : found) {
            faces_.insert(faces_.end(), own.begin(), own.end());
        }
    }

    /// Compares the faces of a group with all after them in the tree. Returns what it cost.
    std::size_t meet_group(const BoxTree& tree, std::size_t group, std::size_t limit, std::vector<Met>& found) const {
        std::array<RealFace, BoxTree::fan> own;
        const std::size_t begin = tree.group_begin(group);
        for (std::size_t position = begin; position != tree.group_end(group); ++position) {
            own[position - begin] = real(mesh_, faces_[tree.item_at(position)]);
        }
        std::size_t last = tree.size();
        RealFace other = own[0];  // of `last`, as pairs with one face follow one another
        return tree.search_pairs(group, limit, [&](std::size_t position, std::size_t other_position) {
            if (other_position != std::exchange(last, other_position)) {
                other = real(mesh_, faces_[tree.item_at(other_position)]);
            }
            if (!are_apart(own[position - begin], other)) {
                meet_exactly(faces_[tree.item_at(position)], faces_[tree.item_at(other_position)], found);
            }
        });
    }

    void meet_exactly(std::uint32_t face, std::uint32_t other, std::vector<Met>& found) const {
        const Meeting meeting = meet(exact(mesh_, face), exact(mesh_, other));
        if (meeting != Meeting::none) {
            found.push_back({meeting, {std::min(face, other), std::max(face, other)}});
        }
    }

    void note(const Met& met, int worker) {
        for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
            if (kinds[kind].first == met.meeting) {
                tallies_[static_cast<std::size_t>(worker)][kind].add(met.faces);
            }
        }
        const auto [face, other] = met.faces;
        const std::uint32_t shell = shell_of_[face];
        const std::uint32_t other_shell = shell_of_[other];
        if (shell != other_shell && shells_[shell].closed && shells_[other_shell].closed) {
            meets_other_[shell].store(1, std::memory_order_relaxed);
            meets_other_[other_shell].store(1, std::memory_order_relaxed);
        }
    }

    const GridMesh& mesh_;
    const std::vector<std::uint32_t>& shell_of_;
    const std::vector<MeshShell>& shells_;
    const Parallel& parallel_;
    std::vector<std::uint32_t> faces_;  ///< those with area, of several on the same vertices the first
    std::vector<std::array<Tally<FacePair>, kinds.size()>> tallies_;
    std::vector<std::atomic<std::uint8_t>> meets_other_;  ///< by shell
};

/// For a crossing, the segment in which the faces meet; else the middle of their boxes' intersection.
FaultPlace place_of(const GridMesh& mesh, const FacePair& pair, Meeting meeting) {
    FaultPlace place;
    place.triangles = {mesh.faces[pair[0]].source, mesh.faces[pair[1]].source};
    if (meeting == Meeting::cross) {
        const auto segment = crossing_segment(exact(mesh, pair[0]), exact(mesh, pair[1]));
        place.point_count = 2;
        for (std::size_t end = 0; end < 2; ++end) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                place.points_mm[end][axis] = segment[end][axis] * (2 * mesh.unit_mm);
            }
        }
        return place;
    }
    const Box a = Box::around(mesh.corners(mesh.faces[pair[0]]));
    const Box b = Box::around(mesh.corners(mesh.faces[pair[1]]));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t low = std::max(a.low[axis], b.low[axis]);
        const std::int64_t high = std::min(a.high[axis], b.high[axis]);
        place.points_mm[0][axis] = static_cast<double>(low + high) / 2 * mesh.unit_mm;
    }
    return place;
}

}  // namespace

std::vector<std::uint8_t> find_meeting_faces(const GridMesh& mesh, const std::vector<std::uint32_t>& shell_of,
                                             const std::vector<MeshShell>& shells, Notes& notes, double progress,
                                             const Parallel& parallel) {
    MeetingSearch search(mesh, shell_of, shells, notes.most(), parallel);
    const bool complete = search.run(progress);
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
        const auto& [meeting, fault] = kinds[kind];
        Tally<FacePair>& total = search.total(kind);
        FaultFinding& finding = notes.of(fault);
        finding.count = total.count();
        finding.at_least = !complete;
        for (const FacePair& pair : total.smallest()) {
            finding.places.push_back(place_of(mesh, pair, meeting));
        }
    }
    return search.meets_other();
}

}  // namespace lamella
