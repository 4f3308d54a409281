// Which shell lies within which.
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>

#include "base/numbers.hpp"
#include "mesh/check/finders.hpp"
#include "mesh/check/meeting.hpp"

namespace lamella {

namespace {

/// The faces of one shell that a ray meets.
struct Hits {
    int winding = 0;       ///< 1 for each that the ray leaves by, -1 where it enters
    bool touches = false;  ///< the ray begins on one of them
};

/// The orientation of a, b and the ray, seen from above. The ray stands at p moved by (e, e^2), e infinitely small: it
/// passes through no edge and no vertex, and the faces around one are counted as they are for a point nearby.
int turn_from_above(const GridVector& a, const GridVector& b, const GridVector& p) {
    const std::int64_t turn = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    if (turn != 0) {
        return sign_of(turn);
    }
    return a.y != b.y ? sign_of(a.y - b.y) : sign_of(b.x - a.x);
}

/// The winding that the face adds to p: the face's orientation from above where the ray upwards from p passes through it.
int winding_of(const ExactFace& face, const GridVector& p) {
    const int orientation = sign_of(face.normal.z);
    if (orientation == 0 || sign_of(face.height(p)) * orientation >= 0) {
        return 0;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        if (turn_from_above(face.corners[i], face.corners[i == 2 ? 0 : i + 1], p) != orientation) {
            return 0;
        }
    }
    return orientation;
}

class Nesting {
public:
    Nesting(const GridMesh& mesh, const FaceTree& tree, const Array<std::uint32_t>& shell_of, std::vector<MeshShell>& shells,
            bool whole, const Parallel& parallel)
        : mesh_(mesh), tree_(tree), shell_of_(shell_of), shells_(shells), whole_(whole), parallel_(parallel) {
        choose_samples();
    }

    bool run() {
        std::vector<std::vector<std::uint32_t>> around(shells_.size());
        const bool complete = search_within<ShellPair>(
            search_budget(mesh_.faces.size()), shells_.size(), parallel_,
            [&](std::size_t shell, std::size_t limit, std::vector<ShellPair>& found) {
                return find_around(static_cast<std::uint32_t>(shell), limit, found);
            },
            [&](const ShellPair& pair) { around[pair[0]].push_back(pair[1]); });
        const bool all_tested = !whole_ || drop_crossed(around);
        for (std::uint32_t shell = 0; shell < shells_.size(); ++shell) {
            shells_[shell].depth = static_cast<int>(around[shell].size());
        }
        for (std::uint32_t shell = 0; shell < shells_.size(); ++shell) {
            choose_parent(shell, around[shell]);
        }
        return complete && all_tested;
    }

private:
    static constexpr std::size_t most_samples = 8;
    /// A shell, and one that is around it.
    using ShellPair = std::array<std::uint32_t, 2>;

    /// For each shell vertices spread over it: of its faces, in order, the first, the last and some between them.
    void choose_samples() {
        samples_.resize(shells_.size());
        std::vector<std::uint64_t> seen(shells_.size(), 0);  // faces, by shell
        std::vector<std::size_t> chosen(shells_.size(), 0);  // samples, by shell
        for (std::uint32_t face = 0; face < shell_of_.size(); ++face) {
            const std::uint32_t shell = shell_of_[face];
            const std::uint64_t last = shells_[shell].triangles - 1;
            for (std::size_t& next = chosen[shell]; next < most_samples && seen[shell] == next * last / (most_samples - 1);
                 ++next) {
                samples_[shell][next] = mesh_.faces[face].corners[next % 3];
            }
            ++seen[shell];
        }
    }

    GridVector sample(std::uint32_t shell, std::size_t number) const {
        return half(mesh_.vertices[samples_[shell][number]]);
    }

    /// Appends the closed shells around this one to `around`; returns what it cost. Samples are tried for as long as some
    /// lie on a shell's surface, or all of them.
    std::size_t find_around(std::uint32_t shell, std::size_t limit, std::vector<ShellPair>& around) const {
        std::map<std::uint32_t, int> kept;  // shells on or within which all samples so far lie: the winding of one, or 0
        std::size_t cost = 0;
        for (std::size_t number = 0; number < most_samples && cost < limit && (number == 0 || !kept.empty()); ++number) {
            std::map<std::uint32_t, Hits> hits;
            cost += cast(shell, sample(shell, number), limit - cost, hits);
            std::map<std::uint32_t, int> still;
            for (const auto& [other, hit] : hits) {
                const auto before = kept.find(other);
                const bool known = before != kept.end();
                if ((number > 0 && !known) || (!hit.touches && hit.winding == 0)) {
                    continue;
                }
                if (hit.touches || whole_) {
                    still[other] = hit.touches ? (known ? before->second : 0) : hit.winding;
                } else {
                    around.push_back({shell, other});
                }
            }
            kept = std::move(still);
        }
        for (const auto& [other, winding] : kept) {
            if (winding != 0) {
                around.push_back({shell, other});
            }
        }
        return cost;
    }

    /// Takes from `around` each shell's the others that a face of it crosses. Returns whether all faces were tested.
    bool drop_crossed(std::vector<std::vector<std::uint32_t>>& around) const {
        std::vector<ShellPair> crossed;
        const bool complete = search_within<ShellPair>(
            search_budget(mesh_.faces.size()), mesh_.faces.size(), parallel_,
            [&](std::size_t face, std::size_t limit, std::vector<ShellPair>& found) {
                const std::vector<std::uint32_t>& others = around[shell_of_[face]];
                return others.empty() ? 0 : find_crossed(face, limit, others, found);
            },
            [&](const ShellPair& pair) { crossed.push_back(pair); });
        for (const auto& [shell, other] : crossed) {
            std::erase(around[shell], other);
        }
        return complete;
    }

    std::size_t find_crossed(std::size_t face, std::size_t limit, const std::vector<std::uint32_t>& others,
                             std::vector<ShellPair>& found) const {
        const ExactFace own = exact(face);
        return tree_.search(SpaceBox::around(mesh_.corners(mesh_.faces[face])), limit, [&](std::size_t item) {
            const std::uint32_t shell = shell_of_[item];
            if (own.has_area() && std::binary_search(others.begin(), others.end(), shell) &&
                meet(own, exact(item)) == Meeting::cross) {
                found.push_back({shell_of_[face], shell});
            }
        });
    }

    /// Adds to `hits`, by shell, what the ray upwards from p meets; returns what it cost.
    std::size_t cast(std::uint32_t shell, const GridVector& p, std::size_t limit,
                     std::map<std::uint32_t, Hits>& hits) const {
        const auto on_grid = [](std::int64_t value) { return static_cast<std::int32_t>(2 * value); };
        const SpaceBox ray{{on_grid(p.x), on_grid(p.y), on_grid(p.z)}, {on_grid(p.x), on_grid(p.y), grid_limit}};
        return tree_.search(ray, limit, [&](std::size_t item) {
            if (shell_of_[item] == shell || !shells_[shell_of_[item]].closed) {
                return;
            }
            Hits found{0, contains(exact(item), p)};
            for (std::size_t face = item; face < mesh_.faces.size() && are_alike(face, item); ++face) {
                found.winding += winding_of(exact(face), p);
            }
            if (found.touches || found.winding != 0) {
                Hits& own = hits[shell_of_[item]];
                own.winding += found.winding;
                own.touches = own.touches || found.touches;
            }
        });
    }

    ExactFace exact(std::size_t face) const { return {mesh_.faces[face].corners, mesh_.corners(mesh_.faces[face])}; }
    bool are_alike(std::size_t face, std::size_t other) const {
        return vertex_set(mesh_.faces[face]) == vertex_set(mesh_.faces[other]);
    }

    /// The deepest of the shells around; of several equally deep ones, which then cross, the first.
    void choose_parent(std::uint32_t shell, const std::vector<std::uint32_t>& around) {
        for (const std::uint32_t other : around) {
            std::int64_t& parent = shells_[shell].parent;
            const int deepest = parent < 0 ? -1 : shells_[static_cast<std::size_t>(parent)].depth;
            if (shells_[other].depth > deepest || (shells_[other].depth == deepest && other < parent)) {
                parent = other;
            }
        }
    }

    const GridMesh& mesh_;
    const FaceTree& tree_;
    const Array<std::uint32_t>& shell_of_;
    std::vector<MeshShell>& shells_;
    const bool whole_;
    const Parallel& parallel_;
    std::vector<std::array<std::uint32_t, most_samples>> samples_;  ///< by shell: vertices
};

}  // namespace

bool nest_shells(const GridMesh& mesh, const FaceTree& tree, const Array<std::uint32_t>& shell_of,
                 std::vector<MeshShell>& shells, bool whole, const Parallel& parallel) {
    const bool any_closed = std::any_of(shells.begin(), shells.end(), [](const MeshShell& shell) { return shell.closed; });
    return shells.size() < 2 || !any_closed || Nesting(mesh, tree, shell_of, shells, whole, parallel).run();
}

}  // namespace lamella
