// lamella check: what is wrong with a mesh, and where.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "check_words.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "lamella/io/check_report.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/io/text_file.hpp"
#include "lamella/mesh/check.hpp"
#include "mesh_input.hpp"
#include "output_path.hpp"
#include "scale_words.hpp"
#include "slice_arguments.hpp"

namespace lamella::cli {

namespace {

constexpr std::size_t most_marks =
    1'000'000;  ///< of each kind, as of what is listed; also keeps vertex numbers within PLY's int

struct CheckArguments : MeshArguments {
    std::string report;
    std::string marks;
    double tolerance_mm = CheckOptions{}.tolerance_mm;
    std::size_t places = CheckOptions{}.most_places;
    bool all_kinds = false;

    bool report_to_stdout() const { return report == "-"; }
};

void require_outputs(const CheckArguments& arguments) {
    if (!arguments.report.empty() && !arguments.report_to_stdout()) {
        require_writable(arguments.report);
        require_different(arguments.report, arguments.mesh, "--report", "the mesh");
        require_different(arguments.report, arguments.marks, "--report", "--marks");
    }
    if (!arguments.marks.empty()) {
        require_writable(arguments.marks);
        require_different(arguments.marks, arguments.mesh, "--marks", "the mesh");
        require_extension(arguments.marks, "--marks", ".ply");
    }
}

MeshCheck checked(const CheckArguments& arguments, const MeshFile& mesh, ProgressBar& bar) {
    const Stage stage(bar, "checking");
    CheckOptions options;
    options.control.threads = arguments.threads;
    options.control.progress = stage.progress();
    options.tolerance_mm = arguments.tolerance_mm;
    options.most_places = arguments.marks.empty() ? arguments.places : std::max(arguments.places, most_marks);
    Result<MeshCheck> result = check(mesh, options);
    if (!result) {
        const Failure failure = failure_of(result.error());
        throw failure.status() == bad_input ? Failure(bad_input, arguments.mesh + ": " + failure.what()) : failure;
    }
    return std::move(result).value();
}

/// The members that the tool adds to the report. They refer to `mesh`.
std::vector<ReportMember> members_of(const CheckTimes& ms, const MeshFile& mesh, double write_ms, double total_ms) {
    return {{ReportPlace::in_times, "read", mesh.read_ms},
            {ReportPlace::in_times, "parse", mesh.parse_ms},
            {ReportPlace::in_times, "measure", ms.measure},
            {ReportPlace::in_times, "faces", ms.faces},
            {ReportPlace::in_times, "edges", ms.edges},
            {ReportPlace::in_times, "joints", ms.joints},
            {ReportPlace::in_times, "shells", ms.shells},
            {ReportPlace::in_times, "meeting", ms.meeting},
            {ReportPlace::in_times, "gaps", ms.gaps},
            {ReportPlace::in_times, "write", write_ms},
            {ReportPlace::in_times, "total", total_ms},
            {ReportPlace::at_end, "warnings", std::span<const std::string>(mesh.warnings)}};
}

/// "--tolerance: ..." rather than the library's words, which name no option.
void require_tolerance(const CheckArguments& arguments) {
    if (!(std::isfinite(arguments.tolerance_mm) && arguments.tolerance_mm >= 0)) {
        throw Failure(bad_usage, "--tolerance: not a number of mm, zero or more");
    }
}

void require(const Status& status) {
    if (!status) {
        throw failure_of(status.error());
    }
}

void run(const CheckArguments& arguments, Interrupt& interrupt) {
    require_tolerance(arguments);
    require_outputs(arguments);
    interrupt.tidy({arguments.report, arguments.marks});
    const Stopwatch watch;
    ProgressBar bar(arguments.progress);
    MeshFile mesh = read_mesh_and_warn(arguments, bar);
    const MeshCheck found = checked(arguments, mesh, bar);
    for (std::string& doubt :
         doubts_of_scale(arguments, mesh, {found.info.min_mm, found.info.max_mm, found.info.unit_mm, std::nullopt})) {
        warn(doubt);
        mesh.warnings.push_back(std::move(doubt));
    }
    double write_ms = 0;
    if (!arguments.marks.empty()) {
        const Stage stage(bar, "writing");
        const Stopwatch writing;
        require(write_marks(found, arguments.marks));
        write_ms = writing.ms();
    }
    const std::string words = check_words(arguments.mesh, mesh, found, {arguments.places, arguments.all_kinds});
    if (arguments.report.empty()) {
        print(words);
        return;
    }
    const std::vector<ReportMember> members = members_of(found.ms, mesh, write_ms, watch.ms());
    const Result<std::string> json =
        make_check_json(found, {.mesh_name = arguments.mesh, .file = &mesh, .members = members}, arguments.places);
    if (!json) {
        throw failure_of(json.error());
    }
    if (arguments.report_to_stdout()) {
        (void)std::fputs(words.c_str(), stderr);
        print(json.value());
        return;
    }
    require(write_text_file(arguments.report, json.value()));
    print(words);
}

}  // namespace

void add_check_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("check", "Say what is wrong with a mesh, and where");
    const auto arguments = std::make_shared<CheckArguments>();
    declare_mesh(*command, *arguments);
    declare_progress(*command, *arguments);
    command->add_option("--report", arguments->report, "JSON report to write; - for standard output")
        ->type_name("FILE|-")
        ->check(given_path);
    command->add_option("--marks", arguments->marks, "PLY file of coloured points and edges at every place")
        ->type_name("FILE.ply")
        ->check(given_path);
    command->add_option("--tolerance", arguments->tolerance_mm, "Widest gap that counts as a crack or T-junction (0.01)")
        ->type_name("MM");
    command->add_option("--places", arguments->places, "List at most N places of each kind (10)")
        ->type_name("N")
        ->check(CLI::Range(0, static_cast<int>(most_marks)));
    command->add_flag("--all", arguments->all_kinds, "List the kinds of faults that were not found, too");
    command->callback([arguments, &interrupt] { run(*arguments, interrupt); });
}

}  // namespace lamella::cli
