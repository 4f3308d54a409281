// Results become files: masks, tables, SVG, and a record beside each but SVG.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lamella/control.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/medical.hpp"
#include "lamella/mesh/weld.hpp"
#include "outputs/image_arguments.hpp"
#include "outputs/output_formats.hpp"
#include "outputs/recorded_options.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

/// A mesh that was sliced.
struct SlicedPart {
    std::string name;  ///< of its label, ROI or row
    SliceResult result;
    OpenLayers open;  ///< of the result
    std::optional<MeshFacts> facts;
    PatientFrame frame = PatientFrame::unstated;
    std::optional<WeldedMesh> welded;
    std::string mesh_sha256;            ///< of the mesh's file, where it is known
    std::optional<std::uint64_t> hash;  ///< hash_result(), where it is known
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

/// Writes all outputs that can be written; `note` takes warnings. Parts whose names repeat are told apart by a number.
/// Throws Failure where none can be written, and of a stop.
WrittenOutputs write_outputs(OutputJob& job, const Control& control, const std::function<void(const std::string&)>& note);

/// True if the output, now written, is a file of a format with a record.
bool takes_record(const PlannedOutput& output);

/// Writes it with this version, and what is known of the output. Throws Failure.
void write_record_beside(const PlannedOutput& output, Record record, const Control& control);

/// The name of a mesh's file without folder and ends: "liver" of "a/liver.stl.gz".
std::string mesh_name_of(const std::string& path);

}  // namespace lamella::cli
