// lamella slice: read, slice, write, report.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "files/streams.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "outputs/output_checks.hpp"
#include "outputs/recorded_options.hpp"
#include "outputs/write_outputs.hpp"
#include "processes/workers.hpp"
#include "slice/slice_arguments.hpp"
#include "slice/slice_stages.hpp"
#include "slice/slice_summary.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/stages.hpp"

namespace lamella::cli {

namespace {

class SliceCommand {
public:
    SliceCommand(const CLI::App& command, const SliceArguments& arguments, Interrupt& interrupt)
        : command_(command),
          arguments_(arguments),
          stages_(arguments.progress, arguments.threads, interrupt),
          job_{.outputs = plan_slice_outputs(arguments), .arguments = arguments_.outputs, .command = command.get_name()} {}

    void run() {
        stages_.interrupt().tidy(files_to_write(arguments_, job_.outputs));
        std::vector<MeshFile> files = find_image();
        if (arguments_.mesh_count() == 1) {
            const MeshFile mesh = files.empty() ? read(arguments_.meshes.front()) : std::move(files.front());
            slice_part(mesh, mesh_name_of(arguments_.mesh));
            write();
            report(mesh);
        } else {
            slice_all(std::move(files));
            write();
            print_words(words_ + wrote(run_.outputs), arguments_.output_to_stdout());
        }
        if (failure_) {
            throw Failure(*failure_);
        }
    }

    /// For a batch: of one file.
    SliceFacts facts() const {
        SliceFacts facts{.warnings = run_.warnings};
        for (const SlicedPart& part : job_.parts) {
            facts.layers = part.result.layers.size();  // the same of all
            facts.triangles += part.result.summary.triangles;
            facts.contours += run_.contours.value_or(part.result.contours.size());
            facts.open_contours += part.result.summary.open_contours;
            facts.close_gaps_mm = std::max(facts.close_gaps_mm, part.result.close_gaps_mm);
        }
        return facts;
    }

private:
    /// The meshes, where all of them are needed before the first one is sliced.
    std::vector<MeshFile> find_image() {
        std::vector<MeshFile> files;
        if (!arguments_.image.given()) {
            return files;
        }
        if (!arguments_.image.spacing.empty()) {
            for (const std::string& mesh : arguments_.meshes) {
                files.push_back(read(mesh));
            }
        }
        job_.image = image_for(files, arguments_);
        job_.subslices = arguments_.image.subslices;
        note_all(job_.image->warnings);
        require_image_serves(*job_.image, job_.outputs, arguments_.outputs);
        require_series_kept(*job_.image, files_to_write(arguments_, job_.outputs));
        return files;
    }

    void note(const std::string& warning) {
        stages_.warn(warning);
        run_.warnings.push_back(warning);
    }

    void note_all(const std::vector<std::string>& warnings) {
        for (const std::string& warning : warnings) {
            note(warning);
        }
    }

    MeshFile read(const std::string& path) {
        arguments_.mesh = path;
        MeshFile mesh = read_for_slicing(arguments_, stages_);
        note_all(mesh.warnings);
        return mesh;
    }

    void slice_all(std::vector<MeshFile> files) {
        for (std::size_t i = 0; i < arguments_.meshes.size(); ++i) {
            arguments_.mesh = arguments_.meshes[i];
            MeshFile mesh = files.empty() ? read(arguments_.mesh) : std::move(files[i]);
            if (arguments_.split) {
                slice_objects(mesh);
            } else {
                slice_part(mesh, mesh_name_of(arguments_.mesh));
                add_summary(mesh, arguments_.mesh);
            }
        }
    }

    /// Each solid part as a mesh of its own, all at the planes of the whole.
    void slice_objects(MeshFile& mesh) {
        std::vector<MeshPart> parts = mesh.parts;
        if (parts.empty()) {
            note(arguments_.name() + ": names no objects to split it into, and is one");
            parts = {{mesh_name_of(arguments_.mesh), PartRole::solid, 0, mesh.triangle_count}};
        }
        planes_ = job_.image ? ExplicitPlanes{} : planes_of(mesh);
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

    ExplicitPlanes planes_of(const MeshFile& mesh) {
        SliceArguments whole = arguments_;
        whole.layers.clear();
        whole.hash = false;
        const SliceResult cut = cut_mesh(mesh, {}, options_of(whole), whole, nullptr, stages_, run_);
        ExplicitPlanes planes;
        for (const Layer& layer : cut.layers) {
            planes.heights_mm.push_back(layer.plane_mm);
        }
        return planes;
    }

    void add_summary(const MeshFile& mesh, const std::string& name) {
        end_run();
        words_ += summary(job_.parts.back().result, {.mesh_name = name, .file = &mesh}, run_);
    }

    /// `first`: of its file.
    void slice_part(const MeshFile& mesh, const std::string& name, bool first = true) {
        const std::size_t earlier = run_.warnings.size();  // of meshes before
        SlicedPart part;
        part.name = name;
        const SliceOptions options = options_for(mesh, part);
        begin_streaming(name);
        mended_ = mend_mesh(mesh, arguments_, stages_, run_);
        part.result = cut_mesh(mesh, mended_, options, arguments_, streamed_ ? &*streamed_ : nullptr, stages_, run_);
        part.welded = std::move(mended_.welded);
        part.hash = run_.hash;
        if (!arguments_.hash) {
            run_.hash.reset();
        }
        examine(mesh, part);
        if (wants_records()) {
            part.mesh_sha256 = first ? add_input(arguments_.mesh, mesh.file_bytes) : job_.inputs.back().sha256;
        }
        if (wants_facts()) {
            part.facts = stages_.done("measuring", [&](const Control& control) {
                return measure_facts(sliced_view(mesh, part), mesh.to_mm(), part.result, control);
            });
            part.facts->warnings = mesh.warnings;
            part.facts->warnings.insert(part.facts->warnings.end(),
                                        run_.warnings.begin() + static_cast<std::ptrdiff_t>(earlier), run_.warnings.end());
        }
        job_.parts.push_back(std::move(part));
    }

    SliceOptions options_for(const MeshFile& mesh, SlicedPart& part) const {
        SliceOptions options = options_of(arguments_);
        if (planes_) {
            options.plan.spacing = *planes_;
        }
        part.frame = mesh.patient_frame == PatientFrame::unstated ? arguments_.image.frame : mesh.patient_frame;
        if (job_.image) {
            part.frame = patient_frame_of(mesh, arguments_.image, arguments_.name());
            options.plan.spacing = ExplicitPlanes{job_.image->slice_heights_mm(job_.subslices)};
            options.transform = job_.image->slicing_frame(part.frame);
        }
        return options;
    }

    /// Within --memory, where all outputs take one layer after the other.
    void begin_streaming(const std::string& name) {
        const bool one_mesh = arguments_.meshes.size() == 1;
        if (in_ranges() && (job_.outputs.empty() || (one_mesh && StreamedOutputs::serve(job_.outputs)))) {
            streamed_.emplace(job_.outputs, name, job_.image ? &*job_.image : nullptr);
            job_.finish_streamed = [this] { streamed_->finish(); };
        }
    }

    /// Warns before anything is written.
    void examine(const MeshFile& mesh, SlicedPart& part) {
        if (mended_.oriented && !mended_.oriented->complete) {
            note("--orient-shells: " + part.name +
                 " has open shells, or too many in a row: cavities may have been turned outwards");
        }
        if (job_.image) {
            require_overlap(*job_.image, part.name, part.result.summary);
        }
        if (!streamed_) {
            run_.open = done_or_thrown(find_open_layers(part.result, {.threads = arguments_.threads}));
        }
        part.open = run_.open;
        note_all(warnings_of(part, run_.contours, arguments_, mesh, job_.image));
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

    /// Returns its SHA-256.
    std::string add_input(const std::string& path, std::uint64_t bytes) {
        job_.inputs.push_back(is_standard(path) ? FileSeal{path, bytes, ""} : done_or_thrown(seal_file(path)));
        return job_.inputs.back().sha256;
    }

    /// The triangles that were sliced, in the unit of the file.
    MeshView sliced_view(const MeshFile& mesh, const SlicedPart& part) const {
        return mended_.oriented ? mended_.oriented->mesh.view() : (part.welded ? part.welded->view() : mesh.view());
    }

    void write() {
        if (job_.outputs.empty()) {
            return;
        }
        job_.options = recorded_options(command_);
        for (const RecordedOption& option : job_.options) {
            if (wants_records() && option.names_file()) {
                (void)add_input(*option.value, 0);
            }
        }
        const Stopwatch watch;
        WrittenOutputs written = stages_.run("writing", [this](const Control& control) {
            return write_outputs(job_, control, [this](const std::string& warning) { note(warning); });
        });
        run_.outputs = std::move(written.paths);
        failure_ = std::move(written.failure);
        run_.write_ms = watch.ms();
    }

    /// The summary of one mesh, and its report where one is wanted.
    void report(const MeshFile& mesh) {
        const SlicedPart& part = job_.parts.front();
        ReportParts parts{.mesh_name = arguments_.mesh, .file = &mesh, .welded = part.welded ? &*part.welded : nullptr};
        if (arguments_.report.empty()) {
            end_run();
            return print_words(summary(part.result, parts, run_), arguments_.output_to_stdout());
        }
        const SliceResult& result = part.result;
        const MeshView sliced = sliced_view(mesh, part);
        const auto ledger = stages_.done(
            "ledger", [&](const Control& c) { return make_ledger(sliced, result, c); }, &run_.ledger_ms);
        const auto volume = stages_.done(
            "certificate", [&](const Control& c) { return certify_volume(sliced, result, c); }, &run_.certificate_ms);
        const auto crossings = stages_.done(
            "crossings", [&](const Control& c) { return find_crossings(result, c); }, &run_.crossings_ms);
        stages_.interrupt().end_deferring();  // what follows does not look for stop requests
        end_run();
        const std::vector<ReportMember> members = members_of(run_, mesh);
        parts.ledger = &ledger;
        parts.volume = &volume;
        parts.crossings = &crossings;
        parts.members = members;
        const Stopwatch watch;
        write_text(arguments_.report, done_or_thrown(make_report_json(result, parts)));
        run_.report_ms = watch.ms();
        end_run();
        print_words(
            summary(result, parts, run_) + (arguments_.report_to_stdout() ? "" : "report    " + arguments_.report + "\n"),
            arguments_.output_to_stdout() || arguments_.report_to_stdout());
    }

    void end_run() {
        run_.total_ms = total_.ms();
        run_.peak_rss_bytes = peak_rss_bytes();
    }

    const CLI::App& command_;
    SliceArguments arguments_;
    Stages stages_;
    OutputJob job_;
    std::string words_;  ///< the summaries of several meshes
    MendedMesh mended_;  ///< of the mesh that was sliced last
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
        pass_on(*command, slicing.facts());
    });
}

}  // namespace lamella::cli
