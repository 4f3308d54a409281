// Which files a command writes, as what, and whether that can be: before any mesh is read, and once the image is known at
// whose slices meshes are cut. Then results become files: masks, tables, files of layers, and a record beside each but
// these.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "files/mesh_input.hpp"
#include "lamella/context.hpp"
#include "lamella/io/layer_file.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/medical.hpp"
#include "lamella/weld.hpp"

namespace lamella::cli {

/// The screen of a printer.
struct ScreenArguments {
    std::optional<Screen> of_printer{};  ///< or its pixels alone
    std::optional<PointMm> pixel_mm{};
    std::optional<std::size_t> mirror{};  ///< bits: 1 x, 2 y
    int turn = 0;
    int levels = 256;
    bool centred = true;
    PrintTimes times{};

    /// All together, if it is given. Throws Failure (bad_usage).
    std::optional<Screen> screen() const;
};

struct OutputArguments {
    std::vector<std::string> outputs;  ///< paths, or -
    std::string to;                    ///< formats
    std::string besides{};             ///< what the command writes, too, for messages
    bool coverage = false;
    bool islands = false;  ///< tables have a row an island
    bool strict = false;
    std::optional<HoleForm> holes{};  ///< of structure sets
    bool without_ct = false;
    bool leave_out = false;                        ///< open contours, where a file of layers cannot hold them
    bool objects = false;                          ///< the meshes are the objects of a file, cut at the same planes
    std::string label_table{};                     ///< path
    std::optional<std::uint64_t> picture_layer{};  ///< instead of a contact sheet
    ScreenArguments screen{};
};

/// The image that sets the planes.
struct ImageArguments {
    std::string like{};
    ImageOptions of_like{};
    std::optional<std::array<double, 3>> spacing{};  ///< mm
    PatientFrame frame = PatientFrame::unstated;
    int subslices = 1;

    /// The archives of convert may have been cut for one.
    bool in_archives = false;

    bool given() const noexcept { return in_archives || !like.empty() || spacing; }
};

/// The flags of results that medicine reads, which slice and convert share.
void declare_outputs(CLI::App& command, OutputArguments& arguments);
void declare_image(CLI::App& command, ImageArguments& arguments);
/// --like, and --series of it.
void declare_like(CLI::App& command, ImageArguments& arguments, const std::string& help);

void declare_screen(CLI::App& command, ScreenArguments& arguments);

/// The end of a mask's or a table's name says which one it is.
enum class OutputFormat : std::uint8_t { layers, mask, segmentation, structure_set, table, png, hdf5 };

struct PlannedOutput {
    std::string path;  ///< or - for standard output
    OutputFormat format = OutputFormat::layers;
    std::string_view layer_format = "svg";  ///< LayerFormat::name

    /// Voxels in the patient: it needs the geometry of an image, and the patient frame of the mesh.
    bool is_mask() const noexcept { return format == OutputFormat::mask || format == OutputFormat::segmentation; }
    /// Of DICOM: it names the slices of a CT.
    bool is_dicom() const noexcept { return format == OutputFormat::structure_set || format == OutputFormat::segmentation; }
    /// Pictures of layers for printers.
    bool on_screen() const noexcept;
    /// True if it takes one mesh only.
    bool one_mesh() const noexcept { return format == OutputFormat::layers || format == OutputFormat::hdf5; }
    /// True if a record is written beside it: beside all but files of layers.
    bool has_record() const noexcept { return format != OutputFormat::layers; }
    std::string record_path() const { return path + ".lamella.json"; }
    /// All files that come to lie on disk.
    std::vector<std::string> files(bool several_meshes) const;
};

/// The outputs of -o and --to. Without --to the end of each name decides. With it there is one -o, and each format takes its
/// name with the end exchanged: -o liver.nii.gz --to nii.gz,csv writes liver.nii.gz and liver.csv. Throws Failure
/// (bad_usage).
std::vector<PlannedOutput> planned_outputs(const OutputArguments& arguments);

bool has_format(const std::vector<PlannedOutput>& outputs, OutputFormat format);

/// Throws Failure (bad_usage) where options and formats do not go together, wherever the files may lie.
void require_together(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments, std::size_t meshes,
                      const ImageArguments& image);

/// The outputs that are asked for, if any. Throws Failure (bad_usage, bad_output) where they do not go together, plainly
/// cannot be written, or would overwrite an input. Adds them to `files`.
std::vector<PlannedOutput> plan_outputs(const OutputArguments& arguments, std::size_t meshes, const ImageArguments& image,
                                        FilePlan& files);

/// All files that come of them.
std::vector<std::string> files_of(const std::vector<PlannedOutput>& outputs, bool several_meshes);

/// The environment's SOURCE_DATE_EPOCH, seconds since 1970, if it is there. Throws Failure (bad_usage).
std::optional<std::int64_t> source_date();

/// The rows of --label-table, if it is given. Throws Failure, also where a row is of no mesh.
std::vector<LabelRow> label_rows(const OutputArguments& arguments, std::size_t meshes);

/// The slices of the image's series are read. Throws Failure (bad_usage) where an output would replace one.
void add_series(const ImageGeometry& image, FilePlan& files);

/// Throws Failure (bad_input).
void require_image_serves(const ImageGeometry& image, const std::vector<PlannedOutput>& outputs,
                          const OutputArguments& arguments);

/// Throws Failure (bad_input) where the mesh lies outside of the image.
void require_overlap(const ImageGeometry& image, const std::string& name, const Box& mesh);

// --- what is written

/// An option that decides what comes out, as typed; flags have no value.
struct RecordedOption {
    std::string name;  ///< "--layer-height"
    std::optional<std::string> value;

    /// True if the value is a path of a file that decides the output, such as --like's.
    bool names_file() const;
};

/// Those that were given to slice, and those of changed_defaults, in the order of `lamella slice --help`. Left out is what
/// says only where results go or how they are made.
std::vector<RecordedOption> recorded_options(const CLI::App& slice_command);

/// True if records hold the option of this name.
bool is_recorded(const std::string& name);

/// An option that takes no value.
bool is_flag(const CLI::Option& option);

/// True if the output, now written, is a file of a format with a record.
bool takes_record(const PlannedOutput& output);

/// Writes it with this version, and what is known of the output. Throws Failure.
void write_record_beside(const PlannedOutput& output, Record record, const Context& context);

/// A mesh that was sliced.
struct SlicedPart {
    std::string name;        ///< of its row; of its label or ROI where that has none of its own
    std::string label_name;  ///< of --label-table
    SegmentTerms terms;
    SliceResult result;
    OpenLayers open;  ///< of the result
    std::optional<MeshFacts> facts;
    PatientFrame frame = PatientFrame::unstated;
    std::optional<WeldedMesh> welded;
    std::string mesh_sha256;            ///< of the mesh's file, where it is known
    std::optional<std::uint64_t> hash;  ///< SliceResult::hash(), where it is known

    const std::string& labelled() const noexcept { return label_name.empty() ? name : label_name; }
    /// Counts and places of open contours, and the flag that would join them: a line for people.
    std::string open_words() const { return describe(open, "--stitch "); }
    double reach_mm() const noexcept { return result.info.options.stitch_mm; }  ///< of stitches
};

/// Takes what was written to a file of layers.
using ToldLayers = std::function<void(const PlannedOutput& output, const LayerFileSummary& summary)>;

/// All that is written at the end of a command.
struct OutputJob {
    std::vector<PlannedOutput> outputs{};
    const OutputArguments& arguments;
    std::vector<SlicedPart> parts{};
    std::optional<ImageGeometry> image{};
    int subslices = 1;
    std::string command;  ///< for the records, as what follows
    std::vector<FileSeal> inputs{};
    std::vector<RecordedOption> options{};
    std::optional<SliceResult> whole{};     ///< of all objects of a file, which files of layers take as parts
    std::vector<std::string> part_names{};  ///< of these
    /// Puts in place what was written while the mesh was sliced, and tells of files of layers; else empty.
    std::function<void(const ToldLayers& told)> finish_streamed{};
    std::vector<std::string> written{};          ///< paths, in the end
    std::map<std::string, std::string> words{};  ///< of files of layers, by path: what wrote() adds
    std::optional<Failure> failure{};  ///< of the first that could not be written; those of others were complained of
};

/// How a file of layers is written. Refers to the job.
LayerFileOptions layer_options(const OutputJob& job, const PlannedOutput& output);
/// Throws Failure where the mesh has no room on the screen of an output.
void require_on_screen(const OutputJob& job, const Source& mesh, const SliceOptions& options);

/// Throws Failure.
OpenLayers open_layers_of(const SliceResult& result, const Context& context);

/// Writes all outputs that can be written; `note` takes warnings. Parts whose names repeat are told apart by a number.
/// Throws Failure where none can be written, and of a stop.
void write_outputs(OutputJob& job, const Context& context, const std::function<void(const std::string&)>& note);

/// The name of a mesh's file without folder and ends: "liver" of "a/liver.stl.gz".
std::string mesh_name_of(const std::string& path);

/// A line for people for each output that was written, and `words` of it by its path.
std::string wrote(const std::vector<std::string>& outputs, const std::map<std::string, std::string>& words = {});

}  // namespace lamella::cli
