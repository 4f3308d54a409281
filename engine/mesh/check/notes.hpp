// Where the finders of faults record what they find.
#pragma once

#include <initializer_list>

#include "lamella/mesh/check.hpp"
#include "mesh/check/grid_mesh.hpp"

namespace lamella {

class Notes {
public:
    Notes(const GridMesh& mesh, std::size_t most, MeshCheck& check) noexcept : mesh_(mesh), most_(most), check_(check) {}

    std::size_t most() const noexcept { return most_; }

    /// Counts a fault; make() returns its FaultPlace, and is called for the first few only. Faults of a kind come in order.
    template <class Make>
    void add(Fault fault, Make make) {
        FaultFinding& finding = of(fault);
        ++finding.count;
        if (finding.places.size() < most_) {
            finding.places.push_back(make());
        }
    }

    FaultFinding& of(Fault fault) noexcept { return check_.findings[static_cast<std::size_t>(fault)]; }

    std::array<double, 3> mm(const GridVertex& vertex) const noexcept {
        return {vertex.x * mesh_.unit_mm, vertex.y * mesh_.unit_mm, vertex.z * mesh_.unit_mm};
    }

    /// At up to three vertices.
    FaultPlace at(std::initializer_list<std::uint32_t> vertices) const noexcept {
        FaultPlace place;
        place.point_count = 0;
        for (const std::uint32_t vertex : vertices) {
            place.points_mm[static_cast<std::size_t>(place.point_count++)] = mm(mesh_.vertices[vertex]);
        }
        return place;
    }

    FaultPlace at(const Face& face) const noexcept {
        FaultPlace place = at({face.corners[0], face.corners[1], face.corners[2]});
        place.triangles[0] = face.source;
        return place;
    }

private:
    const GridMesh& mesh_;
    std::size_t most_;
    MeshCheck& check_;
};

}  // namespace lamella
