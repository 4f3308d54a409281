// Edges, vertices and senses: what can be wrong with how faces are joined.
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
    place.number = sides.size();
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

/// Faces of a patch (joined over edges with two faces) by their sense towards its first face.
struct Patch {
    std::uint32_t alike = 0;
    std::uint32_t opposite = 0;
    bool one_sided = false;
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
                place.number = counts[vertex];
                return place;
            });
        }
    }
}

void find_flipped_faces(const GridMesh& mesh, const EdgeTable& edges, Notes& notes) {
    DisjointSets senses(mesh.faces.size());
    each_joint(edges, [&](std::size_t edge, std::uint32_t side, std::uint32_t other) {
        senses.unite(EdgeTable::face_of(side), EdgeTable::face_of(other), !edges.is_balanced(edge));
    });
    std::vector<Patch> patches(mesh.faces.size());
    each_joint(edges, [&](std::size_t edge, std::uint32_t side, std::uint32_t other) {
        const DisjointSets::Member member = senses.find(EdgeTable::face_of(side));
        const bool agree = member.opposite == senses.find(EdgeTable::face_of(other)).opposite;
        patches[member.root].one_sided |= agree != edges.is_balanced(edge);
    });
    for (std::uint32_t face = 0; face < patches.size(); ++face) {
        const DisjointSets::Member member = senses.find(face);
        Patch& patch = patches[member.root];
        ++(member.opposite ? patch.opposite : patch.alike);
    }
    for (std::uint32_t face = 0; face < patches.size(); ++face) {
        const DisjointSets::Member member = senses.find(face);
        const Patch& patch = patches[member.root];
        if (patch.one_sided && member.root == face) {
            notes.add(Fault::one_sided_patch, [&] { return notes.at(mesh.faces[face]); });
        } else if (!patch.one_sided && member.opposite == (patch.opposite <= patch.alike)) {
            notes.add(Fault::flipped_face, [&] { return notes.at(mesh.faces[face]); });
        }
    }
}

}  // namespace lamella
