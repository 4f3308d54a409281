// Faults in how faces are joined: edges, vertices and orientations.
#include <algorithm>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "mesh/check/finders.hpp"

namespace lamella {

namespace {

/// With its first faces.
FaultPlace place_of_edge(const GridMesh& mesh, const EdgeTable& edges, std::size_t edge, const Notes& notes) {
    FaultPlace place = notes.at({edges[edge].lower, edges[edge].upper});
    const std::span<const std::uint32_t> sides = edges.sides(edge);
    for (std::size_t i = 0; i < std::min(sides.size(), place.triangles.size()); ++i) {
        place.triangles[i] = mesh.faces[EdgeTable::face_of(sides[i])].source;
    }
    place.parts = sides.size();
    return place;
}

/// Calls visit(edge, side, other side) for every edge with two faces.
template <class Visit>
void each_joint(const EdgeTable& edges, Visit visit) {
    for (std::size_t edge = 0; edge < edges.size(); ++edge) {
        if (const auto sides = edges.sides(edge); sides.size() == 2) {
            visit(edge, sides[0], sides[1]);
        }
    }
}

/// The corner (3 * face + index) of the side's face at that vertex, which is one of the side's ends.
std::uint32_t corner_at(const GridMesh& mesh, std::uint32_t side, std::uint32_t vertex) {
    const std::uint32_t next = side % 3 == 2 ? side - 2 : side + 1;
    return mesh.faces[side / 3].corners[side % 3] == vertex ? side : next;
}

/// Faces of a patch (joined over edges with two faces) by orientation relative to its first face.
struct Patch {
    std::uint32_t alike = 0;
    std::uint32_t opposite = 0;
};

/// The patches of a mesh. Each face takes part twice, as it is and reversed, so that faces which agree in orientation are in
/// one set. Where the reversed first face is in the set of the first face, the patch has one side.
class Patches {
public:
    Patches(const GridMesh& mesh, const EdgeTable& edges) : sets_(2 * mesh.faces.size()) {
        each_joint(edges, [&](std::size_t edge, std::uint32_t side, std::uint32_t other) {
            const std::uint32_t face = EdgeTable::face_of(side);
            const std::uint32_t next = EdgeTable::face_of(other);
            const bool agree = edges.is_balanced(edge);
            sets_.unite(as_is(face), agree ? as_is(next) : reversed(next));
            sets_.unite(reversed(face), agree ? reversed(next) : as_is(next));
        });
    }

    std::uint32_t first_face(std::uint32_t face) { return sets_.root(as_is(face)) / 2; }
    bool is_opposite(std::uint32_t face) { return sets_.root(as_is(face)) % 2 != 0; }
    bool is_one_sided(std::uint32_t face) { return sets_.root(as_is(face)) == sets_.root(reversed(face)); }

private:
    static std::uint32_t as_is(std::uint32_t face) { return 2 * face; }
    static std::uint32_t reversed(std::uint32_t face) { return 2 * face + 1; }

    DisjointSets sets_;
};

}  // namespace

void find_edge_faults(const GridMesh& mesh, const EdgeTable& edges, Notes& notes) {
    for (std::size_t edge = 0; edge < edges.size(); ++edge) {
        const auto add = [&](Fault fault) { notes.add(fault, [&] { return place_of_edge(mesh, edges, edge, notes); }); };
        const std::size_t faces = edges.sides(edge).size();
        if (faces == 1) {
            add(Fault::boundary_edge);
        } else if (faces > 2) {
            add(edges.is_balanced(edge) ? Fault::overfull_balanced : Fault::overfull_unbalanced);
        } else if (!edges.is_balanced(edge)) {
            add(Fault::mismatched_edge);
        }
    }
}

void find_split_vertices(const GridMesh& mesh, const EdgeTable& edges, Notes& notes) {
    DisjointSets fans(3 * mesh.faces.size());
    each_joint(edges, [&](std::size_t edge, std::uint32_t side, std::uint32_t other) {
        for (const std::uint32_t vertex : {edges[edge].lower, edges[edge].upper}) {
            fans.unite(corner_at(mesh, side, vertex), corner_at(mesh, other, vertex));
        }
    });
    std::vector<std::uint32_t> counts(mesh.vertices.size(), 0);
    std::vector<std::uint32_t> first_faces(mesh.vertices.size(), 0);
    for (std::uint32_t corner = 0; corner < 3 * mesh.faces.size(); ++corner) {
        if (fans.root(corner) == corner) {
            const std::uint32_t vertex = mesh.faces[corner / 3].corners[corner % 3];
            first_faces[vertex] = counts[vertex]++ == 0 ? corner / 3 : first_faces[vertex];
        }
    }
    for (std::uint32_t vertex = 0; vertex < counts.size(); ++vertex) {
        if (counts[vertex] > 1) {
            notes.add(Fault::split_vertex, [&] {
                FaultPlace place = notes.at({vertex});
                place.triangles[0] = mesh.faces[first_faces[vertex]].source;
                place.parts = counts[vertex];
                return place;
            });
        }
    }
}

void find_flipped_faces(const GridMesh& mesh, const EdgeTable& edges, Notes& notes) {
    Patches patches(mesh, edges);
    std::vector<Patch> sizes(mesh.faces.size());  // by first face
    for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
        Patch& patch = sizes[patches.first_face(face)];
        ++(patches.is_opposite(face) ? patch.opposite : patch.alike);
    }
    for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
        const std::uint32_t first = patches.first_face(face);
        const bool flipped = patches.is_opposite(face) == (sizes[first].opposite <= sizes[first].alike);
        if (patches.is_one_sided(face)) {
            if (face == first) {
                notes.add(Fault::one_sided_patch, [&] { return notes.at(mesh.faces[face]); });
            }
        } else if (flipped) {
            notes.add(Fault::flipped_face, [&] { return notes.at(mesh.faces[face]); });
        }
    }
}

}  // namespace lamella
