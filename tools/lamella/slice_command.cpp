// lamella slice: read, slice, write, report.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "mesh_input.hpp"
#include "output_path.hpp"
#include "scale_words.hpp"
#include "slice_arguments.hpp"
#include "slice_summary.hpp"

namespace lamella::cli {

namespace {

class SliceCommand {
public:
    SliceCommand(const SliceArguments& arguments, Interrupt& interrupt)
        : arguments_(arguments), interrupt_(interrupt), bar_(arguments.progress) {}

    void run() {
        require_outputs();
        interrupt_.tidy({arguments_.output, arguments_.report});
        SliceOptions options = options_of(arguments_);
        const MeshFile mesh = read();
        const SliceResult result = slice_mesh(mesh, options);
        if (result.summary.segments == 0) {
            note(why_nothing_is_cut(result.summary));
        }
        if (result.summary.emptied_layers > 0 && result.contours.empty()) {
            note(why_nothing_is_left(result));
        }
        note_doubts_of_scale(result, mesh);
        write(result);
        report(result, mesh);
    }

private:
    /// What can be known of the outputs before any work is done.
    void require_outputs() const {
        if (!arguments_.output.empty()) {
            require_writable(arguments_.output);
            require_different(arguments_.output, arguments_.mesh, "--output", "the mesh");
            require_extension(arguments_.output, "--output", ".svg");
        }
        if (!arguments_.report.empty()) {
            require_writable(arguments_.report);
            require_different(arguments_.report, arguments_.mesh, "--report", "the mesh");
            require_different_output(arguments_.report, arguments_.output, "--report", "--output");
        }
    }

    static std::string why_nothing_is_cut(const SliceSummary& found) {
        return "no plane meets the mesh, which reaches from " + exact_text(found.min_mm[2]) + " to " +
               exact_text(found.max_mm[2]) + " mm along the slicing direction";
    }

    static std::string why_nothing_is_left(const SliceResult& result) {
        const double offset_mm = result.region.offset_mm;
        const std::string what = offset_mm < 0 ? "an offset of " + exact_text(offset_mm) + " mm" : "the fill rule";
        return what + " leaves nothing: " +
               (result.summary.emptied_layers == 1
                    ? "the one layer that the mesh crosses is empty"
                    : "all " + counted(result.summary.emptied_layers, "layer") + " that the mesh crosses are empty");
    }

    void note_doubts_of_scale(const SliceResult& result, const MeshFile& mesh) {
        const bool moved = !arguments_.transform.empty() || !arguments_.normal.empty();
        const MeasuredMesh measured{result.summary.min_mm, result.summary.max_mm, result.unit_mm,
                                    least_plane_distance(result.plan), moved};
        for (const std::string& doubt : doubts_of_scale(arguments_, mesh, measured)) {
            note(doubt);
        }
    }

    void note(const std::string& warning) {
        bar_.wipe();
        warn(warning);
        run_.warnings.push_back(warning);
    }

    MeshFile read() {
        MeshFile mesh = read_mesh_of(arguments_, bar_);
        for (const std::string& warning : mesh.warnings) {
            note(warning);
        }
        return mesh;
    }

    SliceResult slice_mesh(const MeshFile& mesh, SliceOptions& options) {
        if (arguments_.weld_mm) {
            weld_vertices(mesh);
        }
        const Stage stage(bar_, "slicing");
        options.control.stop = interrupt_.defer();
        options.control.progress = stage.progress();
        Result<SliceResult> result = welded_ ? slice(*welded_, options) : slice(mesh, options);
        if (!result) {
            throw slicing_failure(result.error());
        }
        return std::move(result).value();
    }

    void weld_vertices(const MeshFile& mesh) {
        const Stage stage(bar_, "welding");
        const Stopwatch watch;
        Result<WeldedMesh> welded = weld(mesh, {.tolerance_mm = *arguments_.weld_mm, .control = control_of(stage)});
        run_.weld_ms = watch.ms();
        if (!welded) {
            interrupt_.die_if_interrupted();
            throw Failure(failure_of(welded.error()).status(), arguments_.name() + ": " + welded.error().message);
        }
        welded_ = std::move(welded).value();
    }

    Failure slicing_failure(const Error& error) const {
        interrupt_.die_if_interrupted();
        const Failure failure = failure_of(error);
        if (error.code == ErrorCode::empty_mesh && welded_ && welded_->joined > 0) {
            return {bad_input, arguments_.name() + ": welding at " + exact_text(*arguments_.weld_mm) +
                                   " mm leaves nothing: " + error.message};
        }
        // Of an option the message says all; of a mesh it must say which.
        return failure.status() == bad_input ? Failure(bad_input, arguments_.name() + ": " + error.message) : failure;
    }

    void write(const SliceResult& result) {
        if (arguments_.output.empty()) {
            return;
        }
        const Stage stage(bar_, "writing");
        const Stopwatch watch;
        const Status status =
            write_svg(result, output_path(arguments_.output), {.welded = welded(), .control = control_of(stage)});
        if (!status) {
            throw failure_of(status.error());
        }
        run_.output = arguments_.output;
        run_.write_ms = watch.ms();
    }

    template <class T>
    static T found(Result<T> result) {
        if (!result) {
            throw failure_of(result.error());
        }
        return std::move(result).value();
    }

    /// What a stage of the report finds.
    template <class Call>
    auto timed(std::string_view what, double& ms, const Call& call) {
        const Stage stage(bar_, what);
        const Stopwatch watch;
        auto answer = found(call(control_of(stage)));
        ms = watch.ms();
        return answer;
    }

    void report(const SliceResult& result, const MeshFile& mesh) {
        ReportParts parts{.mesh_name = arguments_.mesh, .file = &mesh, .welded = welded()};
        if (arguments_.report.empty()) {
            end_run();
            print_words(summary(result, parts, run_), arguments_.output_to_stdout());
            return;
        }
        const MeshView sliced = welded_ ? welded_->view() : mesh.view();
        const auto ledger =
            timed("ledger", run_.ledger_ms, [&](const Control& c) { return make_ledger(sliced, result, c); });
        const auto volume =
            timed("certificate", run_.certificate_ms, [&](const Control& c) { return certify_volume(sliced, result, c); });
        const auto crossings =
            timed("crossings", run_.crossings_ms, [&](const Control& c) { return find_crossings(result, c); });
        interrupt_.end_deferring();  // what follows does not look for stop requests
        end_run();
        const std::vector<ReportMember> members = members_of(run_, mesh);
        parts.ledger = &ledger;
        parts.volume = &volume;
        parts.crossings = &crossings;
        parts.members = members;
        const Stopwatch watch;
        write_report(found(make_report_json(result, parts)));
        run_.report_ms = watch.ms();
        end_run();
        print_words(summary(result, parts, run_) + report_line(),
                    arguments_.output_to_stdout() || arguments_.report_to_stdout());
    }

    void end_run() {
        run_.total_ms = total_.ms();
        run_.peak_rss_bytes = peak_rss_bytes();
    }

    Control control_of(const Stage& stage) {
        return {.threads = arguments_.threads, .stop = interrupt_.defer(), .progress = stage.progress()};
    }

    const WeldedMesh* welded() const noexcept { return welded_ ? &*welded_ : nullptr; }

    void write_report(const std::string& json) const {
        if (arguments_.report_to_stdout()) {
            print(json);
            return;
        }
        const Status status = write_text_file(arguments_.report, json);
        if (!status) {
            throw failure_of(status.error());
        }
    }

    std::string report_line() const {
        return arguments_.report_to_stdout() ? std::string() : "report    " + arguments_.report + "\n";
    }

    const SliceArguments& arguments_;
    Interrupt& interrupt_;
    ProgressBar bar_;
    std::optional<WeldedMesh> welded_;
    ToolRun run_;
    Stopwatch total_;
};

}  // namespace

void add_slice_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("slice", "Slice a mesh into closed, oriented, nested contours");
    const auto arguments = std::make_shared<SliceArguments>();
    declare(*command, *arguments);
    command->callback([arguments, &interrupt] { SliceCommand(*arguments, interrupt).run(); });
}

}  // namespace lamella::cli
