// Which files a command writes, and as what.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lamella::cli {

enum class OutputFormat : std::uint8_t {
    svg,
    nifti,
    nifti_gz,
    nrrd,
    segmentation,
    structure_set,
    csv,
    json_lines,
    png,
    hdf5
};

struct PlannedOutput {
    std::string path;  ///< or - for standard output
    OutputFormat format = OutputFormat::svg;

    /// Voxels in the patient: it needs the geometry of an image, and the patient frame of the mesh.
    bool is_mask() const noexcept;
    /// True if it takes one mesh only.
    bool one_mesh() const noexcept { return format == OutputFormat::svg || format == OutputFormat::hdf5; }
    /// True if a record is written beside it: beside all but SVG.
    bool has_record() const noexcept { return format != OutputFormat::svg; }
    std::string record_path() const { return path + ".lamella.json"; }
    /// All files that come to lie on disk.
    std::vector<std::string> files(bool several_meshes) const;
};

/// "svg, nii.gz, nii, ...": what --to takes.
std::string output_format_names();
/// ".svg, .nii.gz, .nii, ...": what names may end in.
std::string output_format_ends();

/// The outputs of -o and --to. Without --to the end of each name decides. With it there is one -o, and each format takes its
/// name with the end exchanged: -o liver.nii.gz --to nii.gz,csv writes liver.nii.gz and liver.csv. Throws Failure
/// (bad_usage).
std::vector<PlannedOutput> planned_outputs(const std::vector<std::string>& outputs, const std::string& to);

/// The name without the end that tells its format.
std::string without_format_end(const std::string& path);

}  // namespace lamella::cli
