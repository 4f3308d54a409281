// Where the voxels of a medical image lie in the patient, and the frame in which a mesh is sliced for them.
//
//     const lamella::Result<lamella::ImageGeometry> image = lamella::read_image_geometry("ct.nii.gz");
//     if (image) {
//         lamella::SliceOptions for_image;
//         for_image.plan.spacing = lamella::ExplicitPlanes{image->slice_heights_mm()};
//         for_image.transform = image->slicing_frame(lamella::PatientFrame::lps);
//         const lamella::Result<lamella::SliceResult> organ = lamella::slice(mesh, for_image);
//     }
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

/// What a DICOM series says of itself, as far as a structure set must repeat it. Values as in the files, without padding.
struct DicomSeries {
    std::string frame_of_reference_uid;
    std::string study_uid;
    std::string series_uid;
    std::string sop_class_uid;
    std::vector<std::string> instance_uids;  ///< of slice k
    std::string character_set;
    std::string patient_name;
    std::string patient_id;
    std::string patient_birth_date;
    std::string patient_sex;
    std::string study_date;
    std::string study_time;
    std::string study_id;
    std::string accession_number;
    std::string referring_physician;
    std::string position_reference;
};

/// An upright grid of voxels. Directions and places are in the patient's frame LPS, in mm.
struct ImageGeometry {
    std::array<std::uint64_t, 3> size{};        ///< voxels along i, j, k
    std::array<double, 3> spacing_mm{1, 1, 1};  ///< of uneven slices along k: their mean
    std::array<double, 3> origin_mm{};          ///< centre of voxel (0, 0, 0)
    /// Unit directions of i, j, k: perpendicular, of either hand.
    std::array<std::array<double, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    std::vector<double> uneven_slices_mm;  ///< of slice k along axes[2] from slice 0, ascending; empty where slices are even
    std::optional<DicomSeries> dicom;      ///< of an image that is a DICOM series
    std::vector<std::string> warnings;     ///< one line each, naming the file

    /// From a mesh in `frame`, in mm, to the frame of slicing: x along i, y along j, z along i x j, zero at the centre of
    /// voxel (0, 0, 0). It is right-handed whatever the image is, so that facets keep their orientation. Precondition:
    /// `frame` is stated.
    Transform slicing_frame(PatientFrame frame) const noexcept;

    /// The heights of slices 0, 1, ... in that frame; descending where i, j, k are left-handed. Of `subslices` planes a
    /// slice, plane n lies at (n + 0.5) / subslices - 0.5 of the spacing from the slice's centre. SliceResult::layer_of
    /// tells the layer of each height.
    std::vector<double> slice_heights_mm(int subslices = 1) const;

    bool even_slices() const noexcept { return uneven_slices_mm.empty(); }
};

/// Reads where the voxels of `path` lie: NIfTI-1 (.nii, .nii.gz), NRRD (.nrrd, .nhdr), or a folder with one DICOM series.
/// The content decides the format. Voxels are not read. Errors: unreadable_file, malformed_mesh (not an image, or one that
/// is refused, such as a sheared one), out_of_memory.
Result<ImageGeometry> read_image_geometry(const std::filesystem::path& path) noexcept;

/// Voxels of `spacing_mm` along L, P and S that cover a box in LPS; their centres lie on multiples of the spacing. Errors:
/// invalid_argument.
Result<ImageGeometry> geometry_around(const std::array<double, 3>& min_mm, const std::array<double, 3>& max_mm,
                                      const std::array<double, 3>& spacing_mm) noexcept;

}  // namespace lamella
