// lamella slice: read, slice, write, report.
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <utility>

#include "files/mesh_input.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "options/asked.hpp"
#include "outputs/outputs.hpp"
#include "processes/process.hpp"
#include "slice/mesh_to_slice.hpp"
#include "slice/seal_aside.hpp"
#include "slice/slice.hpp"
#include "system/process.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

class SliceCommand {
public:
    SliceCommand(const CLI::App& command, const SliceArguments& arguments, Interrupt& interrupt)
        : arguments_(arguments),
          stages_(arguments.progress, arguments.threads, interrupt),
          job_{.arguments = arguments_.outputs, .command = command.get_name(), .options = recorded_options(command)} {
        run_.random_heights = arguments.tuning.random_heights;
        run_.print_hash = arguments.hash;
        arguments_.all_roles = true;
    }

    void run() {
        plan();
        if (!arguments_.negative.empty()) {
            negative_ = read(arguments_.negative);
        }
        std::vector<MeshToSlice> meshes = find_image();
        std::string words;
        for (std::size_t i = 0; i < arguments_.meshes.size(); ++i) {
            MeshToSlice mesh = meshes.empty() ? read(arguments_.meshes[i]) : std::move(meshes[i]);
            arguments_.mesh = arguments_.meshes[i];
            if (arguments_.split) {
                words += slice_objects(mesh);
                continue;
            }
            slice_part(mesh, mesh_name_of(arguments_.mesh));
            if (arguments_.mesh_count() == 1) {
                write();
                report(mesh);
            } else {
                words += summary_of(mesh, arguments_.mesh);
            }
        }
        if (arguments_.mesh_count() > 1) {
            write();
            arguments_.say(words + wrote(run_.outputs, run_.words));
        }
        if (job_.failure) {
            throw Failure(*job_.failure);
        }
    }

    /// Counts and warnings, for a batch: of one file.
    Facts facts() const {
        SliceInfo sum;
        double stitch_mm = 0;
        for (const SlicedPart& part : job_.parts) {
            const SliceInfo& info = part.result.info;
            sum.layers = info.layers;  // the same of all
            sum.triangles += info.triangles;
            sum.contours += info.contours;
            sum.open_contours += info.open_contours;
            stitch_mm = std::max(stitch_mm, part.reach_mm());
        }
        Facts warnings = Facts::array();
        for (const std::string& warning : run_.warnings) {
            warnings.push_back(printable(warning));
        }
        return {{"triangles", sum.triangles},         {"layers", sum.layers},   {"contours", sum.contours},
                {"open_contours", sum.open_contours}, {"stitch_mm", stitch_mm}, {"warnings", warnings}};
    }

private:
    /// Refuses before any work is done what could not be written, or would overwrite a mesh, the file of another option or
    /// another output.
    void plan() {
        refuse_if(arguments_.in_ranges() && !arguments_.report.empty(), bad_usage,
                  "--memory: --report looks at the whole mesh, which is not held");
        refuse_if(arguments_.in_ranges() && !arguments_.negative.empty(), bad_usage,
                  "--memory: --negative needs whole meshes, which are not held");
        if (arguments_.in_ranges() && std::any_of(arguments_.meshes.begin(), arguments_.meshes.end(), is_standard)) {
            throw Failure(bad_usage, "--memory: standard input cannot be read twice; write it to a file first");
        }
        for (const RecordedOption& option : job_.options) {
            if (option.names_file()) {
                file_plan_.reads(*option.value, "the file of " + option.name);
            }
        }
        for (const std::string& mesh : arguments_.meshes) {
            file_plan_.reads(mesh, "the mesh");
        }
        job_.outputs = plan_outputs(arguments_.outputs, arguments_.mesh_count(), arguments_.image, file_plan_);
        refuse_if(arguments_.split && arguments_.meshes.size() > 1 && has_format(job_.outputs, OutputFormat::layers),
                  bad_usage, "--output: a file of layers takes the objects of one mesh file, not of several");
        const auto takes_layers = [](const PlannedOutput& output) {
            return output.format == OutputFormat::layers || output.format == OutputFormat::table;
        };
        streams_ = arguments_.in_ranges() &&
                   (job_.outputs.empty() ||
                    (arguments_.meshes.size() == 1 && std::all_of(job_.outputs.begin(), job_.outputs.end(), takes_layers)));
        std::vector<std::string> files = files_of(job_.outputs, arguments_.mesh_count() > 1);
        if (const std::string& report = arguments_.report; !report.empty()) {
            refuse_if(!are_all_layers(arguments_.options), bad_usage,
                      "--report: not with --layers, as it judges the whole mesh");
            refuse_if(arguments_.mesh_count() > 1, bad_usage, "--report: one mesh a report, not several");
            require_writable(report);
            file_plan_.writes(report, "--report", "the report");
            files.emplace_back(report);
        }
        stages_.interrupt().tidy(std::move(files));
    }

    /// The meshes, where all of them are needed before the first one is sliced.
    std::vector<MeshToSlice> find_image() {
        std::vector<MeshToSlice> meshes;
        if (!arguments_.image.given()) {
            return meshes;
        }
        if (!arguments_.image.like.empty()) {
            job_.image = done_or_thrown(read_image_geometry(path_of(arguments_.image.like), arguments_.image.of_like));
        } else {
            for (const std::string& mesh : arguments_.meshes) {
                meshes.push_back(read(mesh));
            }
            job_.image = image_around(meshes, arguments_);
        }
        job_.subslices = arguments_.image.subslices;
        note_all(job_.image->warnings);
        require_image_serves(*job_.image, job_.outputs, arguments_.outputs);
        add_series(*job_.image, file_plan_);
        return meshes;
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

    MeshToSlice read(const std::string& path) {
        arguments_.mesh = path;
        MeshToSlice mesh;
        if (arguments_.in_ranges()) {
            const StreamOptions options{.memory_bytes = arguments_.memory_bytes,
                                        .temporary_folder = folder_beside(arguments_),
                                        .read = {.mm_per_unit = arguments_.unit_mm.value_or(0)}};
            mesh.stream = done_or_thrown(open_mesh(path_of(path), options));
        } else {
            mesh.file = read_mesh_of(arguments_, stages_);
        }
        mesh.warnings = mesh.about().warnings;
        const PatientFrame asked = arguments_.image.frame;
        const PatientFrame stated = mesh.about().patient_frame;
        if (asked != PatientFrame::unstated && stated != PatientFrame::unstated && stated != asked) {
            mesh.warnings.push_back(arguments_.name() + ": states the patient frame " + std::string(name_of(stated)) +
                                    ", which holds instead of --frame " + std::string(name_of(asked)));
        }
        note_all(mesh.warnings);
        return mesh;
    }

    /// Each solid part as a mesh of its own, all at the planes of the whole. Returns their summaries.
    std::string slice_objects(MeshToSlice& mesh) {
        std::vector<MeshPart> parts = mesh.file.parts;
        if (parts.empty()) {
            note(arguments_.name() + ": names no objects to split it into, and is one");
            parts = {{mesh_name_of(arguments_.mesh), PartRole::solid, 0, mesh.file.triangle_count}};
        }
        if (arguments_.adaptive) {
            slabs_ = slabs_of(mesh);
        } else {
            heights_ = job_.image ? std::vector<double>() : heights_of(mesh);
        }
        label_parts(mesh);
        std::string words;
        std::uint32_t number = 0;  // among parts_of() the file
        for (const MeshPart& part : parts) {
            if (part.role != PartRole::solid && part.first_triangle == 0) {
                continue;  // left out
            }
            label_ = number++;
            if (part.role != PartRole::negative) {
                mesh.file.first_triangle = part.first_triangle;
                mesh.file.triangle_count = part.triangle_count;
                slice_part(mesh, part.name, words.empty());
                words += summary_of(mesh, arguments_.name() + ", " + part.name);
            }
        }
        labelled_.reset();
        return words;
    }

    /// Where the parts of a file cut each other, or a file of layers takes them, all are cut at once.
    void label_parts(MeshToSlice& mesh) {
        mesh.parts = parts_to_cut(mesh.file, std::nullopt, negative_view(), true);
        const bool cut_each_other = !mesh.parts.empty();
        const bool in_layers = has_format(job_.outputs, OutputFormat::layers);
        if (!cut_each_other && !in_layers) {
            return;
        }
        refuse_if(arguments_.weld_mm || arguments_.orient_shells, bad_usage,
                  arguments_.name() + ": --split objects with --weld or --orient-shells: its parts " +
                      (cut_each_other ? "cut each other" : "are cut at once for a file of layers"));
        mesh.parts = cut_each_other ? mesh.parts : parts_of(mesh.file);
        SlicedPart all;
        SliceOptions options = options_for(mesh.about(), all);
        options.slabs = slabs_;
        cut_mesh(mesh, options, arguments_.tuning, all);
        mesh.parts.clear();
        if (in_layers) {
            job_.whole = done_or_thrown(all.result.copy());
            job_.part_names = names_of_parts(mesh.file);
        }
        if (cut_each_other) {
            labelled_ = std::move(all.result);
        }
    }

    std::optional<MeshView> negative_view() const { return negative_ ? std::optional(negative_->view()) : std::nullopt; }

    /// One region of all that is solid, where something is taken away.
    void take_out(MeshToSlice& mesh, SliceOptions& options) {
        const bool mended = mesh.is_mended();
        mesh.parts = parts_to_cut(mesh.file, mended ? std::optional(mesh.view()) : std::nullopt, negative_view(), false);
        if (mesh.parts.empty()) {
            return;
        }
        refuse_if(!arguments_.report.empty(), bad_usage,
                  "--report: " + arguments_.name() + ": judges a mesh, from which something is taken away here");
        cut_as_one(options);
    }

    std::vector<double> heights_of(const MeshToSlice& mesh) {
        SliceOptions whole = arguments_.options;
        set_layers(whole, 0, all_layers);
        SlicedPart cut;
        cut_mesh(mesh, whole, arguments_.tuning, cut);
        std::vector<double> heights;
        for (const Layer& layer : cut.result.layers) {
            heights.push_back(layer.plane_mm);
        }
        return heights;
    }

    std::vector<Slab> slabs_of(const MeshToSlice& mesh) {
        AdaptiveOptions options = *arguments_.adaptive;
        options.ranges = arguments_.height_ranges;
        options.frame = arguments_.options.frame;
        const auto find = [&](const Context& context) { return adaptive_layers(mesh.source(), options, context); };
        const Stopwatch watch;
        const Array<Slab> slabs = done_or_thrown(stages_.run("choosing heights", find), arguments_.name());
        run_.ms["heights"] = watch.ms();
        return {slabs.begin(), slabs.end()};
    }

    /// `first`: of its file.
    void slice_part(MeshToSlice& mesh, const std::string& name, bool first = true) {
        const std::size_t earlier = run_.warnings.size();  // of meshes before
        SlicedPart part;
        part.name = name;
        SliceOptions options = options_for(mesh.about(), part);
        run_.ms["read"] = mesh.about().read_ms;
        run_.ms["parse"] = mesh.about().parse_ms;
        mend(mesh);
        if (arguments_.adaptive) {
            options.slabs = slabs_.empty() ? slabs_of(mesh) : slabs_;
        }
        if (!labelled_ && !mesh.stream) {
            take_out(mesh, options);
            require_on_screen(job_, mesh.source(), options);
        }
        Tuning tuning = arguments_.tuning;
        if (heights_) {
            tuning.random_heights.reset();
        }
        SealAside aside(mesh.stream && wants_records() && arguments_.threads != 1 ? arguments_.mesh : "");
        cut_mesh(mesh, options, tuning, part);
        const bool is_cut_out = labelled_ || !mesh.parts.empty();
        if (is_cut_out) {
            make_one_mesh(part.result, mesh.view());
        }
        if (arguments_.hash && !streams_) {
            part.hash = part.result.hash();
        }
        examine(mesh, part);
        if (wants_records()) {
            part.mesh_sha256 =
                first ? add_input(arguments_.mesh, mesh.about().file_bytes, std::move(aside)) : job_.inputs.back().sha256;
        }
        if (wants_facts() && !is_cut_out) {
            part.facts = stages_.done(
                "measuring", [&](const Context& context) { return measure_facts(mesh.view(), part.result, context); });
            part.facts->warnings = mesh.warnings;
            part.facts->warnings.insert(part.facts->warnings.end(),
                                        run_.warnings.begin() + static_cast<std::ptrdiff_t>(earlier), run_.warnings.end());
        }
        part.welded = std::exchange(mesh.welded, std::nullopt);
        job_.parts.push_back(std::move(part));
    }

    /// By --weld and --orient-shells.
    void mend(MeshToSlice& mesh) {
        mesh.welded.reset();
        mesh.oriented.reset();
        if (arguments_.weld_mm) {
            const auto join = [&](const Context& context) { return weld(mesh.view(), *arguments_.weld_mm, context); };
            const Stopwatch watch;
            mesh.welded = done_or_thrown(stages_.run("welding", join), arguments_.name());
            run_.ms["weld"] = watch.ms();
        }
        if (arguments_.orient_shells) {
            const auto turn = [&](const Context& context) { return orient_shells(mesh.view(), 0, context); };
            mesh.oriented = done_or_thrown(stages_.run("turning shells", turn), arguments_.name());
            run_.shells = mesh.oriented->shells;
            run_.turned_shells = mesh.oriented->turned_shells;
        }
    }

    SliceOptions options_for(const MeshFile& mesh, SlicedPart& part) const {
        SliceOptions options = arguments_.options;
        if (heights_) {
            cut_at(options, *heights_);
        }
        part.frame = mesh.patient_frame == PatientFrame::unstated ? arguments_.image.frame : mesh.patient_frame;
        if (job_.image) {
            part.frame = patient_frame_of(mesh, arguments_.image, arguments_.name());
            cut_across(options, *job_.image, part.frame, job_.image->slice_heights_mm(job_.subslices));
        }
        return options;
    }

    void cut_mesh(const MeshToSlice& mesh, const SliceOptions& options, const Tuning& tuning, SlicedPart& part) {
        const Amount amount{static_cast<double>(mesh.about().triangle_count), "triangles"};
        const Status cut = stages_.run("slicing", amount, [&](const Context& context) -> Status {
            if (streams_) {
                job_.finish_streamed = slice_streamed(job_, part, mesh.source(), options, tuning, arguments_.hash, context);
                return {};
            }
            Slicer slicer;
            const LayerSet own{.layers = labelled_ ? *labelled_ : part.result, .part = label_};
            const Result<SliceInfo> info = labelled_
                                               ? Overlay().combine(part.result, {&own, 1}, unite, {}, context)
                                               : slice_tuned(slicer, part.result, mesh.source(), options, tuning, context);
            return info ? Status() : info.error();
        });
        if (mesh.stream) {
            const MeshStream::Spent spent = mesh.stream->spent();
            run_.ranges =
                "ranges    " + counted(spent.ranges, "range") + " of layers within " + file_size_text(spent.memory_bytes) +
                (spent.spilled_bytes > 0 ? ", " + file_size_text(spent.spilled_bytes) + " by way of a temporary file" : "") +
                "\n";
            return done_or_thrown(cut);  // messages name the file
        }
        if (!cut && cut.error().code == ErrorCode::empty_mesh && mesh.welded && mesh.welded->joined > 0) {
            throw Failure(bad_input, arguments_.name() + ": welding at " + exact_text(*arguments_.weld_mm) +
                                         " mm leaves nothing: " + cut.error().message);
        }
        done_or_thrown(cut, arguments_.name());
    }

    /// Warns before anything is written.
    void examine(const MeshToSlice& mesh, SlicedPart& part) {
        if (mesh.oriented && !mesh.oriented->complete) {
            note("--orient-shells: " + part.name +
                 " has open shells, or too many in a row: cavities may have been turned outwards");
        }
        if (job_.image) {
            require_overlap(*job_.image, part.name, part.result.info.box);
        }
        if (!streams_) {
            part.open = open_layers_of(part.result, {.threads = arguments_.threads});
        }
        note_all(warnings_of(part, arguments_, mesh.about(), job_.image));
    }

    bool wants_records() const {
        return std::any_of(job_.outputs.begin(), job_.outputs.end(), std::mem_fn(&PlannedOutput::has_record));
    }

    /// Facts are those of the whole mesh: where something is taken out of it, there are none.
    bool wants_facts() const { return !arguments_.in_ranges() && has_format(job_.outputs, OutputFormat::table); }

    /// Returns its SHA-256.
    std::string add_input(const std::string& path, std::uint64_t bytes, SealAside&& aside = SealAside()) {
        const auto sum = [&](const Context& context) { return aside.seal(path, context, arguments_.image.of_like); };
        return job_.inputs.emplace_back(is_standard(path) ? FileSeal{path, bytes, ""} : stages_.done("hashing", sum)).sha256;
    }

    void write() {
        if (job_.outputs.empty()) {
            return;
        }
        for (const RecordedOption& option : job_.options) {
            if (wants_records() && option.names_file()) {
                (void)add_input(*option.value, 0);
            }
        }
        const Stopwatch watch;
        stages_.run("writing", [this](const Context& context) {
            write_outputs(job_, context, [this](const std::string& warning) { note(warning); });
        });
        run_.outputs = job_.written;
        run_.words = job_.words;
        run_.ms["write"] = watch.ms();
    }

    /// The summary of one mesh, and its report where one is wanted.
    void report(const MeshToSlice& mesh) {
        const SlicedPart& part = job_.parts.front();
        ReportParts parts{
            .mesh_name = arguments_.mesh, .file = &mesh.about(), .welded = part.welded ? &*part.welded : nullptr};
        if (arguments_.report.empty()) {
            end_run();
            return arguments_.say(summary(part, parts, run_));
        }
        const MeshView sliced = part.welded && !mesh.oriented ? part.welded->view() : mesh.view();
        const auto ask = [&](const char* what, const AuditOptions& question) {
            const auto find = [&](const Context& context) { return audit(part.result, sliced, question, context); };
            return stages_.done(what, find, &run_.ms[what]);
        };
        Audit found = ask("ledger", {.open = false, .volume = false, .crossings = false});
        found.volume = std::move(ask("certificate", {.open = false, .ledger = false, .crossings = false}).volume);
        found.crossings = std::move(ask("crossings", {.open = false, .volume = false, .ledger = false}).crossings);
        stages_.interrupt().end_deferring();  // what follows does not look for stop requests
        end_run();
        const std::vector<ReportMember> members = members_of(run_);
        parts.audit = &found;
        parts.members = members;
        const Stopwatch watch;
        write_text(arguments_.report, done_or_thrown(make_report_json(part.result, parts)));
        run_.ms["report"] = watch.ms();
        end_run();
        const bool to_stdout = is_standard(arguments_.report);
        arguments_.say(summary(part, parts, run_) + (to_stdout ? "" : "report    " + arguments_.report + "\n"), to_stdout);
    }

    std::string summary_of(const MeshToSlice& mesh, const std::string& name) {
        end_run();
        return summary(job_.parts.back(), {.mesh_name = name, .file = &mesh.about()}, run_);
    }

    void end_run() {
        run_.ms["total"] = total_.ms();
        run_.peak_rss_bytes = peak_rss_bytes();
    }

    SliceArguments arguments_;
    Stages stages_;
    OutputJob job_;
    FilePlan file_plan_;
    bool streams_ = false;                        ///< within --memory, where all outputs take one layer after the other
    std::vector<Slab> slabs_;                     ///< adaptive ones, of the file whose objects are being sliced
    std::optional<std::vector<double>> heights_;  ///< of the file whose objects are being sliced
    std::optional<MeshToSlice> negative_;         ///< of --negative
    std::optional<SliceResult> labelled_;         ///< of the file whose parts cut each other
    std::uint32_t label_ = 0;                     ///< there, of the part that is worked on
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
        if (command->count("--worker") > 0) {
            print(slicing.facts().dump() + "\n");
        }
    });
}

}  // namespace lamella::cli
