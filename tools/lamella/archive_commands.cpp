// lamella merge: archives of ranges of layers become that of all layers. lamella convert: what an archive holds, as any
// other output of lamella slice; a mesh, as binary STL or PLY. lamella combine: the layers of archives as one, likewise.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "files/combination.hpp"
#include "files/mesh_input.hpp"
#include "lamella/io/mesh_writer.hpp"
#include "lamella/medical.hpp"
#include "outputs/outputs.hpp"
#include "processes/process.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

struct MergeArguments : MeshArguments {
    std::vector<std::string> parts;
    std::string output;
};

void merge_parts(const MergeArguments& arguments, Interrupt& interrupt) {
    const PlannedOutput output{arguments.output, OutputFormat::hdf5};
    refuse_if(!has_archives(), bad_usage, "--output: '" + output.path + "': this build has no HDF5");
    require_extension(output.path, "--output", ".h5");
    FilePlan plan;
    for (const std::string& part : arguments.parts) {
        plan.reads(part, "one of the parts");
    }
    for (const std::string& file : output.files(false)) {
        require_writable(file);
        plan.writes(file, "--output", "another output");
    }
    interrupt.tidy({output.path, output.record_path()});
    Stages stages(arguments.progress, arguments.threads, interrupt);
    std::vector<std::filesystem::path> parts;
    std::transform(arguments.parts.begin(), arguments.parts.end(), std::back_inserter(parts), path_of);
    const Result<MergedArchive> merged =
        stages.run("merging", [&](const Context& context) { return merge_archives(parts, path_of(output.path), context); });
    if (!merged) {
        const Failure failure = failure_of(merged.error());
        throw Failure(failure.status() == bad_usage ? bad_input : failure.status(), merged.error().message);
    }
    if (takes_record(output)) {
        stages.run("sealing", [&](const Context& context) {
            Record record;
            record.command = "merge";
            record.patient_frame = name_of(merged->info.frame);
            record.grid_mm = {merged->grid_mm};
            record.fill_rule = name_of(merged->fill_rule);
            record.result_hashes = {hex_text(merged->hash)};
            for (const std::string& part : arguments.parts) {
                record.inputs.push_back(done_or_thrown(seal_file(path_of(part), context)));
            }
            write_record_beside(output, std::move(record), context);
        });
    }
    print_words(counted(parts.size(), "part") + ", " + counted(merged->layers, "layer") + "\n" + wrote({output.path}), false,
                arguments.quiet);
}

struct ConvertArguments : MeshArguments {
    std::vector<std::string> archives;  ///< `mesh` is the one that is worked on
    OutputArguments outputs;
    ImageArguments image;  ///< of which only --like can be given
    std::optional<Combination> combination{};
};

bool same_voxels(const ImageGeometry& a, const ImageGeometry& b) {
    return a.size == b.size && a.spacing_mm == b.spacing_mm && a.origin_mm == b.origin_mm && a.axes == b.axes &&
           a.shear_mm == b.shear_mm && a.uneven_slices_mm == b.uneven_slices_mm;
}

class ConvertCommand {
public:
    ConvertCommand(const CLI::App& command, const ConvertArguments& arguments, Interrupt& interrupt)
        : command_(command),
          arguments_(arguments),
          stages_(arguments.progress, arguments.threads, interrupt),
          job_{.arguments = arguments.outputs, .command = command.get_name()} {}

    void run() {
        file_plan_.reads(arguments_.image.like, "the file of --like");
        file_plan_.reads(arguments_.outputs.label_table, "the file of --label-table");
        for (const std::string& archive : arguments_.archives) {
            file_plan_.reads(archive, "the archive");
        }
        const std::size_t meshes = arguments_.combination ? 1 : arguments_.archives.size();
        // The archives say whether there is an image, and how many planes a slice has.
        job_.outputs = plan_outputs(arguments_.outputs, meshes, {.in_archives = true}, file_plan_);
        stages_.interrupt().tidy(files_of(job_.outputs, meshes > 1));
        for (const std::string& archive : arguments_.archives) {
            read(archive);
        }
        if (arguments_.combination) {
            combine();
        }
        if (!arguments_.outputs.label_table.empty()) {
            add_input(arguments_.outputs.label_table);
        }
        if (!arguments_.image.like.empty()) {
            use_image();
        }
        require_image_outputs_possible();
        for (const SlicedPart& part : job_.parts) {
            if (job_.image) {
                require_overlap(*job_.image, part.name, part.result.info.box);
            }
        }
        job_.options = recorded_options(command_);
        stages_.run("writing", [this](const Context& context) {
            write_outputs(job_, context, [this](const std::string& warning) { stages_.warn(warning); });
        });
        const std::vector<std::string>& outputs = arguments_.outputs.outputs;
        print_words(wrote(job_.written, job_.words), std::any_of(outputs.begin(), outputs.end(), is_standard),
                    arguments_.quiet);
        if (job_.failure) {
            throw Failure(*job_.failure);
        }
    }

private:
    void read(const std::string& path) {
        Archive archive = stages_.done("reading " + printable(path),
                                       [&](const Context& context) { return read_archive(path_of(path), context); });
        SlicedPart part;
        part.name = archive.info.name;
        part.result = std::move(archive.result);
        part.frame = archive.info.frame;
        part.mesh_sha256 = archive.info.mesh_sha256;
        if (archive.info.weld) {
            part.welded.emplace();
            part.welded->tolerance_mm = archive.info.weld->tolerance_mm;
            part.welded->joined = archive.info.weld->joined;
        }
        part.open = stages_.run("reading " + printable(path),
                                [&](const Context& context) { return open_layers_of(part.result, context); });
        if (part.open.layers > 0 && !arguments_.outputs.strict) {
            stages_.warn(path + ": " + describe(part.open, "lamella slice --stitch "));
        }
        refuse_if(!job_.parts.empty() && (archive.info.geometry.has_value() != job_.image.has_value() ||
                                          (job_.image && !same_voxels(*job_.image, *archive.info.geometry)) ||
                                          archive.info.subslices != job_.subslices),
                  bad_input, path + ": not cut for the same image as " + arguments_.archives.front());
        job_.image = std::move(archive.info.geometry);
        job_.subslices = archive.info.subslices;
        job_.parts.push_back(std::move(part));
        add_input(path);
    }

    /// For the records.
    void add_input(const std::string& path) {
        job_.inputs.push_back(stages_.done("reading " + printable(path), [&](const Context& context) {
            return seal_file(path_of(path), context, arguments_.image.of_like);
        }));
    }

    /// The parts become one, with the name of the first.
    void combine() {
        std::vector<const SliceResult*> layers;
        for (const SlicedPart& part : job_.parts) {
            layers.push_back(&part.result);
            refuse_if(
                part.frame != job_.parts.front().frame, bad_input,
                arguments_.archives[layers.size() - 1] + ": not in the patient frame of " + arguments_.archives.front());
        }
        SlicedPart whole;
        whole.result = combined(layers, arguments_.archives, *arguments_.combination, stages_);
        whole.name = job_.parts.front().name;
        whole.frame = job_.parts.front().frame;
        job_.parts.clear();
        job_.parts.push_back(std::move(whole));
    }

    /// --like: an image that says more than its geometry, which archives hold.
    void use_image() {
        ImageGeometry image = done_or_thrown(read_image_geometry(path_of(arguments_.image.like), arguments_.image.of_like));
        for (const std::string& warning : image.warnings) {
            stages_.warn(warning);
        }
        refuse_if(!job_.image || !same_voxels(image, *job_.image), bad_input,
                  arguments_.archives.front() + ": not cut at the slices of " + arguments_.image.like);
        add_series(image, file_plan_);
        job_.image = std::move(image);
        add_input(arguments_.image.like);
    }

    void require_image_outputs_possible() const {
        const auto first = std::find_if(job_.outputs.begin(), job_.outputs.end(),
                                        [](const PlannedOutput& output) { return output.is_mask() || output.is_dicom(); });
        if (first == job_.outputs.end()) {
            return;
        }
        if (!job_.image) {
            throw Failure(bad_input, arguments_.archives.front() +
                                         ": no image geometry in it: it was sliced without --like and --spacing");
        }
        require_image_serves(*job_.image, job_.outputs, arguments_.outputs);
        refuse_if(job_.subslices > 1 && (job_.parts.size() > 1 || !first->is_mask()), bad_usage,
                  "--output: '" + first->path + "': cut at several planes a slice, which only a mask of one mesh takes");
        for (std::size_t i = 0; i < job_.parts.size(); ++i) {
            const SliceResult& result = job_.parts[i].result;
            if (result.layers.size() < result.info.planned_layers) {
                throw Failure(bad_input, arguments_.archives[i] + ": " + counted(result.layers.size(), "layer") + " of " +
                                             grouped(result.info.planned_layers) + "; lamella merge joins such parts");
            }
        }
    }

    const CLI::App& command_;
    const ConvertArguments& arguments_;
    Stages stages_;
    OutputJob job_;
    FilePlan file_plan_;
};

/// The mesh of `inputs`, which must be one, as binary STL or PLY: a file that can be sliced within a budget of memory. Warns
/// of coordinates that STL rounds, and of a unit that is lost.
void convert_mesh(const std::vector<std::string>& inputs, const std::string& output, const MeshArguments& reading,
                  Interrupt& interrupt) {
    refuse_if(inputs.size() != 1, bad_usage, "--output: '" + output + "' takes one mesh");
    require_writable(output);
    FilePlan plan;
    plan.reads(inputs.front(), "the mesh");
    plan.writes(output, "--output", "the output");
    interrupt.tidy({output});
    MeshArguments arguments = reading;
    arguments.mesh = inputs.front();
    Stages stages(arguments.progress, arguments.threads, interrupt);
    const MeshFile mesh = read_mesh_and_warn(arguments, stages);
    const WrittenMesh written =
        stages.done("writing", [&](const Context& context) { return write_mesh(mesh, path_of(output), context); });
    if (written.rounded) {
        warn(output + ": coordinates are rounded to the 32 bits of STL; PLY keeps them");
    }
    if (mesh.states_unit && mesh.mm_per_unit != 1) {
        const std::string unit = exact_text(mesh.mm_per_unit);
        warn(output + ": does not state that its unit is " + unit + " mm; slice it with --unit " + unit);
    }
    print_words(output + ": " + counted(mesh.triangle_count, "triangle") + " of " + description(mesh) + "\n", false,
                arguments.quiet);
}

}  // namespace

void add_merge_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("merge", "Join archives (.h5) of ranges of layers");
    const auto arguments = std::make_shared<MergeArguments>();
    add_text(*command, "parts", arguments->parts, "PART.h5", "Archives that lamella slice --layers A:B wrote, in any order")
        ->required();
    add_text(*command, "-o,--output", arguments->output, "WHOLE.h5", "Archive to write: that of all layers")->required();
    declare_running(*command, *arguments);
    declare_quiet(*command, *arguments);
    declare_worker(*command);
    command->callback([arguments, &interrupt] { merge_parts(*arguments, interrupt); });
}

void add_combine_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("combine", "Combine the layers of archives (.h5): unite, subtract, ...");
    const auto arguments = std::make_shared<ConvertArguments>();
    add_text(*command, "archives", arguments->archives, "IN.h5", "Archives of lamella slice with the same planes and grid")
        ->required();
    declare_combination(*command, arguments->combination.emplace());
    declare_outputs(*command, arguments->outputs);
    command->get_option("--output")->required();
    declare_running(*command, *arguments);
    declare_quiet(*command, *arguments);
    declare_worker(*command);
    command->callback([command, arguments, &interrupt] { ConvertCommand(*command, *arguments, interrupt).run(); });
}

void add_convert_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command =
        app.add_subcommand("convert", "Write archives (.h5) as any other output, or a mesh as binary STL or PLY");
    const auto arguments = std::make_shared<ConvertArguments>();
    add_text(*command, "archives", arguments->archives, "IN",
             "Archives of lamella slice, several for a mask or a table; or a mesh, for .stl and .ply")
        ->required();
    declare_outputs(*command, arguments->outputs);
    arguments->outputs.besides = ", and of a mesh .stl and .ply";
    command->get_option("--output")->required();
    declare_like(*command, arguments->image,
                 "The image at whose slices the archives were cut, for outputs that need more of it");
    declare_running(*command, *arguments);
    declare_quiet(*command, *arguments);
    declare_worker(*command);
    command->callback([command, arguments, &interrupt] {
        const OutputArguments& wanted = arguments->outputs;
        if (wanted.to.empty() && wanted.outputs.size() == 1 && is_written_as_mesh(path_of(wanted.outputs.front()))) {
            return convert_mesh(arguments->archives, wanted.outputs.front(), *arguments, interrupt);
        }
        ConvertCommand(*command, *arguments, interrupt).run();
    });
}

}  // namespace lamella::cli
