// lamella check: what is wrong with a mesh, and where.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "check/check_words.hpp"
#include "commands.hpp"
#include "files/mesh_list.hpp"
#include "files/output_path.hpp"
#include "files/scale_words.hpp"
#include "files/standard_streams.hpp"
#include "lamella/io/check_report.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/io/text_file.hpp"
#include "lamella/mesh/check.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

constexpr std::size_t most_marks =
    1'000'000;  ///< of each kind, as of what is listed; also keeps vertex numbers within PLY's int

struct CheckArguments : MeshListArguments {
    std::string report;
    std::string marks;
    double tolerance_mm = CheckOptions{}.tolerance_mm;
    std::size_t places = CheckOptions{}.most_places;
    bool all_kinds = false;
};

/// An array of values, each of which is text that ends a line.
std::string json_array(const std::vector<std::string>& values) {
    std::string text = "[\n";
    for (std::size_t i = 0; i < values.size(); ++i) {
        text.append(values[i], 0, values[i].size() - 1).append(i + 1 < values.size() ? ",\n" : "\n");
    }
    return text + "]\n";
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

class CheckCommand {
public:
    CheckCommand(const CheckArguments& arguments, Interrupt& interrupt)
        : arguments_(arguments), interrupt_(interrupt), list_(arguments) {}

    void run() {
        require_tolerance();
        require_outputs();
        interrupt_.tidy({arguments_.report, arguments_.marks});
        const std::optional<Failure> failure = list_.for_each(
            interrupt_, [this](const MeshArguments& mesh) { examine(mesh); },
            [this](const MeshArguments& mesh, const Failure& reason) { add_failure(mesh, reason); });
        write_report();
        print_words(held_words_, stdout_taken());
        if (failure) {
            throw Failure(*failure);
        }
    }

private:
    /// "--tolerance: ..." rather than the library's words, which name no option.
    void require_tolerance() const {
        if (!(std::isfinite(arguments_.tolerance_mm) && arguments_.tolerance_mm >= 0)) {
            throw Failure(bad_usage, "--tolerance: not a number of mm, zero or more");
        }
    }

    void require_outputs() const {
        const std::vector<std::string> meshes = list_.paths();
        if (!arguments_.report.empty()) {
            require_writable(arguments_.report);
            require_different_output(arguments_.report, arguments_.marks, "--report", "--marks");
        }
        if (!arguments_.marks.empty()) {
            if (meshes.size() > 1) {
                throw Failure(bad_usage, "--marks: the marks are of one mesh, and " + grouped(meshes.size()) + " are given");
            }
            require_writable(arguments_.marks);
        }
        for (const std::string& mesh : meshes) {
            require_different(arguments_.report, mesh, "--report", "the mesh");
            require_different(arguments_.marks, mesh, "--marks", "the mesh");
        }
        require_extension(arguments_.marks, "--marks", ".ply");
    }

    bool stdout_taken() const noexcept { return is_standard(arguments_.report) || is_standard(arguments_.marks); }

    void examine(const MeshArguments& mesh) {
        const Stopwatch watch;
        ProgressBar bar(mesh.progress);
        MeshFile file = read_mesh_and_warn(mesh, bar);
        const MeshCheck found = checked(mesh, file, bar);
        for (std::string& doubt : doubts_of_scale(mesh, file, {found.info.min_mm, found.info.max_mm, found.info.unit_mm})) {
            warn(doubt);
            file.warnings.push_back(std::move(doubt));
        }
        const double write_ms = mark_faults(found, bar);
        add_report(mesh, file, found, members_of(found.ms, file, write_ms, watch.ms()));
        add_words(check_words(mesh.name(), file, found, {arguments_.places, arguments_.all_kinds}));
    }

    /// How long it took, in milliseconds.
    double mark_faults(const MeshCheck& found, ProgressBar& bar) const {
        if (arguments_.marks.empty()) {
            return 0;
        }
        const Stage stage(bar, "writing");
        const Stopwatch watch;
        done_or_thrown(write_marks(found, output_path(arguments_.marks)));
        return watch.ms();
    }

    MeshCheck checked(const MeshArguments& mesh, const MeshFile& file, ProgressBar& bar) const {
        const Stage stage(bar, "checking");
        CheckOptions options;
        options.unit_mm = parse_grid(mesh.grid);
        options.control.threads = mesh.threads;
        options.control.progress = stage.progress();
        options.tolerance_mm = arguments_.tolerance_mm;
        options.most_places = arguments_.marks.empty() ? arguments_.places : std::max(arguments_.places, most_marks);
        Result<MeshCheck> result = check(file, options);
        if (!result) {
            const Failure failure = failure_of(result.error());
            throw failure.status() == bad_input ? Failure(bad_input, mesh.name() + ": " + failure.what()) : failure;
        }
        return std::move(result).value();
    }

    /// Of one mesh the words come when the report is written; of several at once, a blank line before each but the first.
    void add_words(const std::string& words) {
        if (!list_.several()) {
            held_words_ = words;
            return;
        }
        print_words((any_words_ ? "\n" : "") + words, stdout_taken());
        any_words_ = true;
    }

    void add_report(const MeshArguments& mesh, const MeshFile& file, const MeshCheck& found,
                    const std::vector<ReportMember>& members) {
        if (arguments_.report.empty()) {
            return;
        }
        const ReportParts parts{.mesh_name = mesh.mesh, .file = &file, .members = members};
        reports_.push_back(done_or_thrown(make_check_json(found, parts, arguments_.places)));
    }

    void add_failure(const MeshArguments& mesh, const Failure& failure) {
        if (arguments_.report.empty()) {
            return;
        }
        const ReportMember error{.key = "error", .value = std::string_view(failure.what())};
        reports_.push_back(done_or_thrown(make_mesh_json({.mesh_name = mesh.mesh, .members = {&error, 1}})));
    }

    void write_report() const {
        if (arguments_.report.empty()) {
            return;
        }
        const std::string json = list_.several() ? json_array(reports_) : reports_.front();
        if (is_standard(arguments_.report)) {
            print(json);
        } else {
            done_or_thrown(write_text_file(arguments_.report, json));
        }
    }

    const CheckArguments& arguments_;
    Interrupt& interrupt_;
    MeshList list_;
    std::vector<std::string> reports_;  ///< one of each mesh
    std::string held_words_;
    bool any_words_ = false;
};

}  // namespace

void add_check_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("check", "Say what is wrong with meshes, and where");
    const auto arguments = std::make_shared<CheckArguments>();
    declare_mesh_list(*command, *arguments);
    declare_progress(*command, arguments->each);
    command
        ->add_option("--report", arguments->report,
                     "JSON report to write, an array if several meshes are given; - for standard output")
        ->type_name("FILE|-")
        ->check(given_path);
    command
        ->add_option("--marks", arguments->marks,
                     "PLY file of coloured points and edges at every place; - for standard output")
        ->type_name("FILE.ply|-")
        ->check(given_path);
    command->add_option("--tolerance", arguments->tolerance_mm, "Widest gap that counts as a crack or T-junction (0.01)")
        ->type_name("MM");
    command->add_option("--places", arguments->places, "List at most N places of each kind (10)")
        ->type_name("N")
        ->check(CLI::Range(0, static_cast<int>(most_marks)));
    command->add_flag("--all", arguments->all_kinds, "List the kinds of faults that were not found, too");
    command->callback([arguments, &interrupt] { CheckCommand(*arguments, interrupt).run(); });
}

}  // namespace lamella::cli
