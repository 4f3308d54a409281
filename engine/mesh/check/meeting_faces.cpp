// Faces that cross, overlap or touch: every pair whose boxes meet is tested exactly. Of faces on the same vertices only
// one is tested, as they meet the same others: a body exported a thousand times costs no more than once.
#include <array>
#include <atomic>
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
        for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
            const bool again = face > 0 && vertex_set(mesh.faces[face]) == vertex_set(mesh.faces[face - 1]);
            if (!again && exact(mesh, face).has_area()) {
                faces_.push_back(face);
            }
        }
    }

    /// Whether nothing was left out.
    bool run() {
        std::vector<Box> boxes(faces_.size());
        for (std::size_t i = 0; i < faces_.size(); ++i) {
            boxes[i] = Box::around(mesh_.corners(mesh_.faces[faces_[i]]));
        }
        const BoxTree tree(boxes, parallel_);
        return search_within_budget(tree.size(), parallel_, [&](std::size_t position, std::size_t limit, int worker) {
            const std::uint32_t face = faces_[tree.item_at(position)];
            const ExactFace own = exact(mesh_, face);
            return tree.search(tree.box_at(position), position + 1, limit, [&](std::uint32_t item) {
                const Meeting meeting = meet(own, exact(mesh_, faces_[item]));
                if (meeting != Meeting::none) {
                    note(meeting, face, faces_[item], worker);
                }
            });
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
    void note(Meeting meeting, std::uint32_t face, std::uint32_t other, int worker) {
        for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
            if (kinds[kind].first == meeting) {
                tallies_[static_cast<std::size_t>(worker)][kind].add({std::min(face, other), std::max(face, other)});
            }
        }
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
                                             const std::vector<MeshShell>& shells, Notes& notes, const Parallel& parallel) {
    MeetingSearch search(mesh, shell_of, shells, notes.most(), parallel);
    const bool complete = search.run();
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
