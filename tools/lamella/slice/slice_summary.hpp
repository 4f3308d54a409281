// The summary of a slicing for people, and the members that the tool adds to the report.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lamella/audit/open_layers.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/io/report.hpp"
#include "lamella/result.hpp"

namespace lamella::cli {

/// The tool's own work, and the time that it took.
struct ToolRun {
    std::vector<std::string> outputs;  ///< the files that were written, or -
    OpenLayers open{};                 ///< of the result
    double weld_ms = 0;
    double write_ms = 0;
    double ledger_ms = 0;
    double certificate_ms = 0;
    double crossings_ms = 0;
    double report_ms = 0;  ///< making and writing it, of which the report itself can hold only the making
    double total_ms = 0;
    std::uint64_t peak_rss_bytes = 0;
    std::vector<std::string> warnings{};
    std::uint64_t shells = 0;                 ///< looked at by --orient-shells
    std::uint64_t turned_shells = 0;          ///< of these
    std::optional<std::uint64_t> contours{};  ///< of a result that keeps its layers only
    std::optional<std::uint64_t> hash{};
    std::string ranges{};  ///< how a mesh larger than memory was sliced, a line
};

/// The members that the tool adds to the report. They refer to `run`.
std::vector<ReportMember> members_of(const ToolRun& run, const MeshFile& mesh);

/// Some lines, each a keyword and what there is to say, with a final newline.
std::string summary(const SliceResult& result, const ReportParts& parts, const ToolRun& run);

/// A line an output.
std::string wrote(const std::vector<std::string>& outputs);

}  // namespace lamella::cli
