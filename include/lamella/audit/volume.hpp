// A certificate for a result: whether its areas and the volume between its planes are those of the mesh.
//
//     const lamella::Result<lamella::VolumeCertificate> certificate = lamella::certify_volume(mesh, result);
//     if (certificate && certificate->verdict == lamella::VolumeVerdict::holds) {
//         std::printf("certified: %g mm3\n", certificate->mesh_mm3);
//     }
//
// The area in every layer and the volume between every two planes are computed from the mesh alone and compared with the
// contours and with the mesh's volume. Where shells overlap, what is solid is less than what they enclose each by itself:
// the certificate then states both and does not hold.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/audit/open_layers.hpp"
#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"

namespace lamella {

enum class VolumeVerdict : std::uint8_t {
    holds,
    areas_differ,    ///< some layer's contours enclose another area than the mesh has there
    volumes_differ,  ///< the slabs do not sum to the mesh's volume
    open_mesh,       ///< does not apply: some edge has more faces one way than the other, so there is no volume
    not_as_walked,   ///< does not apply: closed gaps, or rules other than FillRule::non_zero, changed the contours
    solid_differs,   ///< by FillRule::non_zero some layers' solid area is not what the mesh encloses there
};

/// "holds", "areas differ", ..., "solid is not what the mesh encloses".
std::string_view name_of(VolumeVerdict verdict) noexcept;

/// Areas and volumes count a region as often as shells wind around it, by the orientation of the facets: what an inverted
/// shell encloses is negative.
struct VolumeCertificate {
    VolumeVerdict verdict = VolumeVerdict::open_mesh;
    OpenLayers open;  ///< of the result: which layers have no area to be compared
    /// Sum of signed tetrahedra, exact but for one rounding; NaN for an open mesh, of which all below is not known.
    double mesh_mm3 = std::numeric_limits<double>::quiet_NaN();
    /// Sum of `slab_mm3`; differs from mesh_mm3 by at most 1e-12 of it (see certify_volume()).
    double slabs_mm3 = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> slab_mm3;   ///< [i]: between planes i - 1 and i; the first and last: below and above all planes
    std::uint64_t worst_layer = 0;  ///< where area and contours differ most, as a share of what rounding allows; the lowest
    double worst_difference_mm2 = 0;
    double worst_allowed_mm2 = 0;
    /// Of solid_differs: in how many layers, and in those what the mesh encloses by the orientation of its facets and what
    /// is solid. Of a mesh turned inside out as a whole the opposite of what it encloses counts.
    std::uint64_t differing_layers = 0;
    double differing_signed_mm2 = 0;
    double differing_solid_mm2 = 0;

    bool applies() const noexcept { return verdict <= VolumeVerdict::volumes_differ; }
};

/// "certified", or "not certified: " and why; where solid_differs, with both areas.
std::string words_for(const VolumeCertificate& certificate);

/// Computes the cross-section at every plane and the volume of every slab by Gauss's theorem, from what the faces and parts
/// of faces below each height cover seen from above; nothing is shared with the stages of slicing but the rounding to the
/// grid. A layer agrees if the area of its points is within what moving each point by half a unit along both axes can
/// change:
///
///     (|dx| + |dy|) / 2 summed over its edges, and a quarter for each crossed triangle
///
/// which is at most one unit x perimeter where edges are longer than a unit; three times that in a
/// layer whose contours FillRule::non_zero has cut. Volumes agree if they differ by at most 1e-12
/// of the mesh's, or by what rounding each face's share to 2^-49 of itself can change where that is more (shells that
/// cancel). A mesh is taken for closed if the sum of its directed edges' hashes vanishes, which an open one's does with a
/// chance of 2^-64.
///
/// `mesh` must be what was sliced. n triangles, k planes, m crossings: O(n + k + m), 96 bytes a plane and thread. All sums
/// are of integers: the answer does not depend on threads. Errors: invalid_argument (the mesh has not the
/// result's number of triangles, or does not fit its grid; layers, contours and points do not follow one another;
/// negative threads), out_of_memory, cancelled.
Result<VolumeCertificate> certify_volume(const MeshView& mesh, const SliceResult& result,
                                         const Control& control = {}) noexcept;

}  // namespace lamella
