// Results become files: masks, tables, SVG, and a record beside each but SVG.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "lamella/context.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/medical.hpp"
#include "lamella/weld.hpp"
#include "outputs/planned_outputs.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

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

/// A record's words: name, value, name, ... Those that the output does not depend on are left out.
std::vector<std::string> record_words(const std::vector<RecordedOption>& options, const PlannedOutput& output);

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
    std::string name;  ///< of its label, ROI or row
    SliceResult result;
    OpenLayers open;  ///< of the result
    std::optional<MeshFacts> facts;
    PatientFrame frame = PatientFrame::unstated;
    std::optional<WeldedMesh> welded;
    std::string mesh_sha256;            ///< of the mesh's file, where it is known
    std::optional<std::uint64_t> hash;  ///< SliceResult::hash(), where it is known

    double reach_mm() const noexcept { return result.info.options.stitch_mm; }  ///< of stitches
};

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
    std::function<void()> finish_streamed{};  ///< puts in place what was written while the mesh was sliced; else empty
};

struct WrittenOutputs {
    std::vector<std::string> paths;
    std::optional<Failure> failure;  ///< of the first that could not be written; those of others were complained of
};

/// Throws Failure.
OpenLayers open_layers_of(const SliceResult& result, const Context& context);

/// Counts and places of open contours, and the flag that would join them: a line for people.
std::string said_of(const OpenLayers& open);

/// Writes all outputs that can be written; `note` takes warnings. Parts whose names repeat are told apart by a number.
/// Throws Failure where none can be written, and of a stop.
WrittenOutputs write_outputs(OutputJob& job, const Context& context, const std::function<void(const std::string&)>& note);

/// The name of a mesh's file without folder and ends: "liver" of "a/liver.stl.gz".
std::string mesh_name_of(const std::string& path);

/// A line for people for each output that was written.
std::string wrote(const std::vector<std::string>& outputs);

}  // namespace lamella::cli
