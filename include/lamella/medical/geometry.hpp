// Where the voxels of a medical image lie in the patient, and the frame in which a mesh is sliced for them.
//
//     const lamella::Result<lamella::ImageGeometry> image = lamella::read_image_geometry("ct.nii.gz");
//     if (image) {
//         lamella::SliceOptions for_image;
//         for_image.heights_mm = image->slice_heights_mm();
//         for_image.frame.transform = image->slicing_frame(lamella::PatientFrame::lps);
//         const lamella::Result<lamella::SliceResult> organ = lamella::slice(mesh, for_image);
//     }
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

/// What a structure set must state of the images that it was drawn on. Texts are as in the files, unchecked.
struct DicomSeries {
    struct Instance {
        std::string file;
        std::string sop_class_uid;
        std::string sop_instance_uid;
        std::uint64_t frame = 0;  ///< from 1 on, of a file of several; 0: the file is the slice
    };
    std::vector<Instance> slices;  ///< in the order of k
    std::string study_uid;
    std::string series_uid;
    std::string series_number;
    std::string frame_of_reference_uid;
    std::string position_reference_indicator;
    std::string specific_character_set;
    std::string patient_name;
    std::string patient_id;
    std::string patient_birth_date;
    std::string patient_sex;
    std::string study_date;
    std::string study_time;
    std::string study_id;
    std::string study_description;
    std::string accession_number;
    std::string referring_physician_name;
};

/// A grid of voxels, upright or sheared along its slices. Directions and places are in the patient's frame LPS, in mm.
struct ImageGeometry {
    std::array<std::uint64_t, 3> size{};  ///< voxels along i, j, k
    std::array<double, 3> spacing_mm{1, 1, 1};
    std::array<double, 3> origin_mm{};  ///< centre of voxel (0, 0, 0)
    /// Unit directions of i, j and of the normal of the slices towards k: perpendicular, of either hand.
    std::array<std::array<double, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    /// Of slices that are not evenly spaced, DICOM's: how far each lies from slice 0 along k, ascending. Else empty; where
    /// there are some, spacing_mm[2] is their mean. Masks refuse them.
    std::vector<double> uneven_slices_mm;
    /// Of a sheared image, as by a tilted gantry: how far each slice lies along i and j from the one before it. Planes,
    /// contours, structure sets and tables do not depend on it. Each slice of a mask is drawn on the slice's own voxels, and
    /// stands for a slab square to the slices; headers of masks state the sheared step.
    std::array<double, 2> shear_mm{};
    std::optional<DicomSeries> series;  ///< where a folder with DICOM files was read
    std::vector<std::string> warnings;  ///< one line each, naming the file

    bool is_sheared() const noexcept { return shear_mm[0] != 0 || shear_mm[1] != 0; }
    /// From each voxel to the next along i, j and k.
    std::array<std::array<double, 3>, 3> steps_mm() const noexcept;
    /// Which slices lie farthest from even places, for messages: "6 mm from a/6.dcm to a/8.dcm, else 3 mm". Empty where
    /// there are no uneven_slices_mm.
    std::string uneven_words() const;

    /// From a mesh in `frame`, in mm, to the frame of slicing: x along i, y along j, z along i x j, zero at the centre of
    /// voxel (0, 0, 0). It is right-handed whatever the image is, so that facets keep their orientation. Precondition:
    /// `frame` is stated.
    Transform slicing_frame(PatientFrame frame) const noexcept;

    /// The heights of slices 0, 1, ... in that frame; descending where i, j, k are left-handed. Of `subslices` planes a
    /// slice, plane n lies at (n + 0.5) / subslices - 0.5 of the (mean) spacing from the slice's centre.
    /// SliceResult::layer_of tells the layer of each height.
    std::vector<double> slice_heights_mm(int subslices = 1) const;

    /// Where a point of that frame lies in the patient.
    std::array<double, 3> to_lps(const std::array<double, 3>& sliced_mm) const noexcept;

    /// Along which axis of the patient the slices follow one another, nearest: 0 left, 1 posterior, 2 superior.
    std::size_t slice_axis() const noexcept;
    /// How far the plane at a height of that frame lies from the patient's zero, along the normal of the slices towards
    /// that axis: of axial slices their coordinate towards superior.
    double height_lps_mm(double height_mm) const noexcept;
};

struct ImageOptions {
    std::string series_uid{};  ///< of a folder with several DICOM series: SeriesInstanceUID of the one that is read
};

/// Reads where the voxels of `path` lie: NIfTI-1 and NIfTI-2 (.nii, .nii.gz, .hdr), NRRD (.nrrd, .nhdr), MetaImage (.mha,
/// .mhd), a folder with a series of DICOM files, or such a file that holds all slices as its frames. The content decides the
/// format. Voxels are not read. Units that a header states become mm. Of NIfTI the sform holds before the qform; RAS+
/// becomes LPS. Slices of a series are sorted along their normal, row direction x column direction, and so are the frames of
/// enhanced CT and MR; files of the folder that are no DICOM images are passed over. Errors: unreadable_file, malformed_mesh
/// (not an image, or one that is refused: sheared in its slices, with slices that lie on no line, in an unknown unit,
/// several series of which none was named, frames without functional groups, two slices or frames at one place),
/// invalid_argument (a series_uid for what is no folder), cancelled, out_of_memory.
Result<ImageGeometry> read_image_geometry(const std::filesystem::path& path, const ImageOptions& options = {},
                                          const Context& context = {}) noexcept;

/// A series of DICOM images in a folder. Texts are as in its first file.
struct DicomSeriesInfo {
    std::string uid;  ///< for ImageOptions::series_uid
    std::string modality;
    std::string description;
    std::uint64_t files = 0;
    std::string refusal;  ///< why read_image_geometry() refuses it, in one line; empty where it serves
};

/// All series of images in a folder, by their UIDs in ascending order, those that no image can be read of too. Errors:
/// unreadable_file, malformed_mesh (no DICOM image in it, a damaged file), cancelled, out_of_memory.
Result<std::vector<DicomSeriesInfo>> list_series(const std::filesystem::path& folder, const Context& context = {}) noexcept;

/// Voxels of `spacing_mm` along L, P and S around a box in LPS: along each axis as many as the extent over the spacing,
/// rounded up, and at least one. The image is centred on the box, so that 44 mm at 1 mm are 44 voxels whose outer sides are
/// the box's. A thousandth of a voxel is taken for rounding; so far the origin may move to a float, which NIfTI holds.
/// Errors: invalid_argument.
Result<ImageGeometry> geometry_around(const Box& box, const std::array<double, 3>& spacing_mm) noexcept;

}  // namespace lamella
