// lamella slice: read, slice, write, report.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "files/mesh_input.hpp"
#include "files/output_path.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "outputs/recorded_options.hpp"
#include "outputs/write_outputs.hpp"
#include "outputs/write_structure_output.hpp"
#include "processes/worker_side.hpp"
#include "slice/image_around.hpp"
#include "slice/part_warnings.hpp"
#include "slice/plan_outputs.hpp"
#include "slice/range_slicing.hpp"
#include "slice/slice_arguments.hpp"
#include "slice/slice_summary.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

class SliceCommand {
public:
    SliceCommand(const CLI::App& command, const SliceArguments& arguments, Interrupt& interrupt)
        : command_(command),
          arguments_(arguments),
          interrupt_(interrupt),
          bar_(arguments.progress),
          job_{
              .outputs = {},
              .arguments = arguments_.outputs,
              .parts = {},
              .image = {},
              .command = command.get_name(),
              .inputs = {},
              .options = {},
          } {}

    void run() {
        slice_and_write();
        if (failure_) {
            throw Failure(*failure_);
        }
    }

    /// For a batch: of one file.
    std::optional<SliceFacts> facts() const {
        if (job_.parts.empty()) {
            return std::nullopt;
        }
        SliceFacts facts{.layers = job_.parts.front().result.layers.size(), .warnings = run_.warnings};
        for (const SlicedPart& part : job_.parts) {
            facts.triangles += part.result.summary.triangles;
            facts.contours += run_.contours.value_or(part.result.contours.size());
            facts.open_contours += part.result.summary.open_contours;
            facts.close_gaps_mm = std::max(facts.close_gaps_mm, part.result.close_gaps_mm);
        }
        return facts;
    }

private:
    void slice_and_write() {
        require_ranges_possible(arguments_);
        plan_outputs();
        std::vector<MeshFile> files;
        if (arguments_.image.spacing.empty()) {
            if (!arguments_.image.like.empty()) {
                use_image(read_image_of(arguments_.image));
            }
        } else {
            read_all(files);
            use_image(image_around(files, arguments_));
        }
        for (std::size_t i = 0; i < arguments_.meshes.size(); ++i) {
            arguments_.mesh = arguments_.meshes[i];
            MeshFile mesh = files.empty() ? read() : std::move(files[i]);
            if (arguments_.split) {
                slice_objects(mesh);
                continue;
            }
            slice_part(mesh, mesh_name_of(arguments_.mesh));
            if (arguments_.meshes.size() == 1) {
                write();
                report(job_.parts.front().result, mesh);
                return;
            }
            add_summary(mesh, arguments_.mesh);
        }
        write();
        print_words(words_ + wrote(run_), arguments_.output_to_stdout());
    }

    void plan_outputs() {
        job_.outputs = planned_outputs_of(arguments_);
        interrupt_.tidy(files_to_write(arguments_, job_.outputs));
    }

    void use_image(ImageGeometry image) {
        for (const std::string& warning : image.warnings) {
            note(warning);
        }
        require_image_serves(image, job_.outputs, arguments_.outputs);
        require_series_kept(image, files_to_write(arguments_, job_.outputs));
        job_.image = std::move(image);
        job_.subslices = arguments_.image.subslices;
    }

    void read_all(std::vector<MeshFile>& files) {
        for (const std::string& mesh : arguments_.meshes) {
            arguments_.mesh = mesh;
            files.push_back(read());
        }
    }

    /// Each solid part as a mesh of its own, all at the planes of the whole.
    void slice_objects(MeshFile& mesh) {
        std::vector<MeshPart> parts = mesh.parts;
        if (parts.empty()) {
            note(arguments_.name() + ": names no objects to split it into, and is one");
            parts = {{mesh_name_of(arguments_.mesh), PartRole::solid, 0, mesh.triangle_count}};
        }
        SliceOptions options = options_of(arguments_);
        options.layers = {};
        planes_ = ExplicitPlanes{};
        if (!job_.image) {
            const Result<SliceResult> whole = slice(mesh, options);
            for (const Layer& layer : whole ? whole->layers.span() : throw slicing_failure(whole.error())) {
                planes_->heights_mm.push_back(layer.plane_mm);
            }
        }
        bool first = true;
        for (const MeshPart& part : parts) {
            if (part.role == PartRole::solid) {
                mesh.first_triangle = part.first_triangle;
                mesh.triangle_count = part.triangle_count;
                slice_part(mesh, part.name, std::exchange(first, false));
                add_summary(mesh, arguments_.name() + ", " + part.name);
            }
        }
    }

    void add_summary(const MeshFile& mesh, const std::string& name) {
        end_run();
        words_ += summary(job_.parts.back().result, {.mesh_name = name, .file = &mesh}, run_);
    }

    /// `first`: of its file.
    void slice_part(const MeshFile& mesh, const std::string& name, bool first = true) {
        const std::size_t earlier = run_.warnings.size();  // of meshes before
        SliceOptions options = options_of(arguments_);
        SlicedPart part;
        part.name = name;
        if (planes_) {
            options.plan.spacing = *planes_;
        }
        part.frame = mesh.patient_frame == PatientFrame::unstated ? arguments_.image.frame : mesh.patient_frame;
        if (job_.image) {
            part.frame = patient_frame_of(mesh, arguments_.image, arguments_.name());
            options.plan.spacing = ExplicitPlanes{job_.image->slice_heights_mm(job_.subslices)};
            options.transform = job_.image->slicing_frame(part.frame);
        }
        const bool one_mesh = arguments_.meshes.size() == 1;
        if (in_ranges() && (job_.outputs.empty() || (one_mesh && StreamedOutputs::serve(job_.outputs)))) {
            job_.streamed = &streamed_.emplace(job_.outputs, part.name, job_.image ? &*job_.image : nullptr);
        }
        part.result = slice_mesh(mesh, options);
        part.hash = run_.hash;
        if (!arguments_.hash) {
            run_.hash.reset();
        }
        part.first_layer = part.result.first_layer;
        part.all_layers = part.result.all_layers;
        part.welded = std::move(welded_);
        welded_.reset();
        if (oriented_ && !oriented_->complete) {
            note("--orient-shells: " + name +
                 " has open shells, or too many in a row: cavities may have been turned outwards");
        }
        if (job_.image) {
            require_overlap(*job_.image, part.name, part.result.summary);
        }
        if (!job_.streamed) {
            run_.open = done_or_thrown(find_open_layers(part.result, {.threads = arguments_.threads}));
        }
        part.open = run_.open;
        for (const std::string& warning : warnings_of(part, run_.contours, arguments_, mesh, job_.image)) {
            note(warning);
        }
        if (wants_records()) {
            part.mesh_sha256 =
                (first ? add_input(arguments_.mesh, mesh.file_bytes) : std::as_const(job_.inputs.back())).sha256;
        }
        if (wants_facts()) {
            part.facts = facts_of(mesh, part);
            part.facts->warnings = mesh.warnings;
            part.facts->warnings.insert(part.facts->warnings.end(),
                                        run_.warnings.begin() + static_cast<std::ptrdiff_t>(earlier), run_.warnings.end());
        }
        job_.parts.push_back(std::move(part));
    }

    bool wants_records() const {
        return std::any_of(job_.outputs.begin(), job_.outputs.end(),
                           [](const PlannedOutput& output) { return output.has_record(); });
    }

    bool in_ranges() const noexcept { return !arguments_.memory.empty(); }

    /// Facts are those of the whole mesh.
    bool wants_facts() const {
        return !in_ranges() && std::any_of(job_.outputs.begin(), job_.outputs.end(), [](const PlannedOutput& output) {
            return output.format == OutputFormat::csv || output.format == OutputFormat::json_lines;
        });
    }

    const FileSeal& add_input(const std::string& path, std::uint64_t bytes) {
        return job_.inputs.emplace_back(is_standard(path) ? FileSeal{path, bytes, ""} : done_or_thrown(seal_file(path)));
    }

    MeshFacts facts_of(const MeshFile& mesh, const SlicedPart& part) {
        const Stage stage(bar_, "measuring");
        return done_or_thrown(measure_facts(sliced_view(mesh, part), mesh.to_mm(), part.result, control_of(stage)));
    }

    void note(const std::string& warning) {
        bar_.wipe();
        warn(warning);
        run_.warnings.push_back(warning);
    }

    MeshFile read() {
        MeshFile mesh = in_ranges() ? describe_mesh_of(arguments_) : read_mesh_of(arguments_, bar_);
        const PatientFrame asked = arguments_.image.frame;
        if (asked != PatientFrame::unstated && mesh.patient_frame != PatientFrame::unstated && mesh.patient_frame != asked) {
            mesh.warnings.push_back(arguments_.name() + ": states the patient frame " +
                                    std::string(name_of(mesh.patient_frame)) + ", which holds instead of --frame " +
                                    std::string(name_of(asked)));
        }
        for (const std::string& warning : mesh.warnings) {
            note(warning);
        }
        return mesh;
    }

    SliceResult slice_mesh(const MeshFile& mesh, SliceOptions& options) {
        if (arguments_.weld_mm) {
            weld_vertices(mesh);
        }
        if (arguments_.orient_shells) {
            turn_shells(mesh);
        }
        const Stage stage(bar_, "slicing");
        options.control.stop = interrupt_.defer();
        options.control.progress = stage.progress();
        Result<SliceResult> result = in_ranges() ? slice_in_ranges(arguments_, options, job_.streamed, run_)
                                     : oriented_ ? slice(oriented_->mesh, options)
                                     : welded_   ? slice(*welded_, options)
                                                 : slice(mesh, options);
        if (!result) {
            throw slicing_failure(result.error());
        }
        if (arguments_.hash && !in_ranges()) {
            run_.hash = hash_result(*result);
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

    void turn_shells(const MeshFile& mesh) {
        const Stage stage(bar_, "turning shells");
        Result<OrientedMesh> oriented = orient_shells(welded_ ? welded_->view() : mesh.view(),
                                                      {.mm_per_unit = mesh.mm_per_unit, .control = control_of(stage)});
        if (!oriented) {
            throw slicing_failure(oriented.error());
        }
        oriented_ = std::move(oriented).value();
        run_.shells = oriented_->shells;
        run_.turned_shells = oriented_->turned_shells;
    }

    /// What was sliced, in the unit of the file.
    MeshView sliced_view(const MeshFile& mesh, const SlicedPart& part) const {
        return oriented_ ? oriented_->mesh.view() : (part.welded ? part.welded->view() : mesh.view());
    }

    Failure slicing_failure(const Error& error) const {
        interrupt_.die_if_interrupted();
        const Failure failure = failure_of(error);
        if (error.code == ErrorCode::empty_mesh && welded_ && welded_->joined > 0) {
            return {bad_input, arguments_.name() + ": welding at " + exact_text(*arguments_.weld_mm) +
                                   " mm leaves nothing: " + error.message};
        }
        // Of an option the message says all; of a mesh it must say which.
        return failure.status() == bad_input && !in_ranges() ? Failure(bad_input, arguments_.name() + ": " + error.message)
                                                             : failure;
    }

    void write() {
        if (job_.outputs.empty()) {
            return;
        }
        job_.options = recorded_options(command_);
        for (const RecordedOption& option : job_.options) {
            if (wants_records() && option.names_file()) {
                add_input(*option.value, 0);
            }
        }
        const Stage stage(bar_, "writing");
        const Stopwatch watch;
        WrittenOutputs written =
            write_outputs(job_, control_of(stage), [this](const std::string& warning) { note(warning); });
        run_.outputs = std::move(written.paths);
        failure_ = std::move(written.failure);
        run_.write_ms = watch.ms();
    }

    /// What a stage of the report finds.
    template <class Call>
    auto timed(std::string_view what, double& ms, const Call& call) {
        const Stage stage(bar_, what);
        const Stopwatch watch;
        auto answer = done_or_thrown(call(control_of(stage)));
        ms = watch.ms();
        return answer;
    }

    void report(const SliceResult& result, const MeshFile& mesh) {
        const WeldedMesh* const welded = job_.parts.front().welded ? &*job_.parts.front().welded : nullptr;
        ReportParts parts{.mesh_name = arguments_.mesh, .file = &mesh, .welded = welded};
        if (arguments_.report.empty()) {
            end_run();
            print_words(summary(result, parts, run_), arguments_.output_to_stdout());
            return;
        }
        const MeshView sliced = sliced_view(mesh, job_.parts.front());
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
        write_report(done_or_thrown(make_report_json(result, parts)));
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

    void write_report(const std::string& json) const {
        if (arguments_.report_to_stdout()) {
            print(json);
            return;
        }
        done_or_thrown(write_text_file(arguments_.report, json));
    }

    std::string report_line() const {
        return arguments_.report_to_stdout() ? std::string() : "report    " + arguments_.report + "\n";
    }

    const CLI::App& command_;
    SliceArguments arguments_;
    Interrupt& interrupt_;
    ProgressBar bar_;
    OutputJob job_;
    std::string words_;  ///< the summaries of several meshes
    std::optional<WeldedMesh> welded_;
    std::optional<OrientedMesh> oriented_;
    std::optional<StreamedOutputs> streamed_;
    std::optional<Failure> failure_;        ///< of an output, beside others that were written
    std::optional<ExplicitPlanes> planes_;  ///< of the file whose objects are being sliced
    ToolRun run_;
    Stopwatch total_;
};

}  // namespace

void add_slice_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("slice", "Slice a mesh into closed, oriented, nested contours");
    const auto arguments = std::make_shared<SliceArguments>();
    declare(*command, *arguments);
    declare_worker(*command);
    command->callback([command, arguments, &interrupt] {
        SliceCommand slicing(*command, *arguments, interrupt);
        slicing.run();
        if (const auto facts = slicing.facts()) {
            pass_on(*command, *facts);
        }
    });
}

}  // namespace lamella::cli
