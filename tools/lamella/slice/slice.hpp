// The flags of `lamella slice`, and what they ask of the engine. Its stages: the mesh that is read and mended, its image,
// what is warned of, and outputs that are written while it is sliced; and the summary for people, with the members that the
// tool adds to the report.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "files/mesh_input.hpp"
#include "lamella/heights.hpp"
#include "lamella/io/report.hpp"
#include "outputs/outputs.hpp"
#include "slicing/tuning.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

struct SliceArguments : MeshArguments {
    std::vector<std::string> meshes;  ///< `mesh` is the one that is worked on
    OutputArguments outputs;
    ImageArguments image;
    std::string report;
    std::string negative;  ///< a mesh's path
    std::optional<double> weld_mm;
    bool orient_shells = false;
    Tuning tuning;
    std::optional<AdaptiveOptions> adaptive;  ///< but for the frame and the ranges
    std::vector<HeightRange> height_ranges;
    std::uint64_t memory_bytes = 0;  ///< 0: the mesh is held
    bool hash = false;
    bool split = false;  ///< each object of a file is a mesh

    bool in_ranges() const noexcept { return memory_bytes > 0; }
    /// At least two where each may hold several.
    std::size_t mesh_count() const noexcept { return std::max<std::size_t>(split ? 2 : 1, meshes.size()); }
    bool output_to_stdout() const noexcept {
        return std::any_of(outputs.outputs.begin(), outputs.outputs.end(), is_standard);
    }
    /// Unless it is to be quiet.
    void say(const std::string& words, bool stdout_taken = false) const {
        print_words(words, stdout_taken || output_to_stdout(), quiet);
    }
};

/// Declares the flags on `command`, to be stored in `arguments`. Values are checked, and files that flags name are read,
/// when the command line is parsed, which throws CLI::ParseError or Failure.
void declare(CLI::App& command, SliceArguments& arguments);

/// The flags of adaptive heights.
void declare_adaptive(CLI::App& command, SliceArguments& arguments);

// --- the stages

/// Sets the heights of the planes, whatever the flags say of them.
void cut_at(SliceOptions& options, std::vector<double> heights);

/// The tool's own work on the mesh that was sliced last, and the time that it took.
struct ToolRun {
    std::vector<std::string> outputs{};          ///< the files that were written, or -
    std::map<std::string, std::string> words{};  ///< as OutputJob::words
    /// Stages of the tool, by the names of the report. That of the report itself, which has only the making, is "report".
    std::map<std::string_view, double> ms{};
    std::uint64_t peak_rss_bytes = 0;
    std::vector<std::string> warnings{};
    std::uint64_t shells = 0;         ///< looked at by --orient-shells
    std::uint64_t turned_shells = 0;  ///< of these
    std::optional<RandomHeights> random_heights{};
    bool print_hash = false;
    std::string ranges{};  ///< how a mesh larger than memory was sliced, a line
};

/// The members that the tool adds to the report. They refer to `run`.
std::vector<ReportMember> members_of(const ToolRun& run);

/// Some lines, each a keyword and what there is to say, with a final newline.
std::string summary(const SlicedPart& part, const ReportParts& parts, const ToolRun& run);

/// Warnings of open layers, layers of which nothing is cut or left, solid that is taken away, doubts of the mesh's scale.
/// `image`: whose slices were cut.
std::vector<std::string> warnings_of(const SlicedPart& part, const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image);

/// Slices a mesh larger than memory: each layer is cut, written, forgotten. The part's result gets layers and stitches only;
/// its open layers, and its hash where `hash` asks for it or an output has a record, are found on the way. Returns what puts
/// the files in their places; it refers to `job`. Throws Failure, also where an output cannot be written; none is in its
/// place then.
std::function<void(const ToldLayers&)> slice_streamed(const OutputJob& job, SlicedPart& part, const Source& mesh,
                                                      const SliceOptions& options, const Tuning& tuning, bool hash,
                                                      Context context);

}  // namespace lamella::cli
