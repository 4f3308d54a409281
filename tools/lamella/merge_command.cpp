// lamella merge: archives of ranges of layers become that of all layers.
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "lamella/medical.hpp"
#include "outputs/output_formats.hpp"
#include "outputs/write_outputs.hpp"
#include "processes/workers.hpp"
#include "slice/slice_arguments.hpp"
#include "slice/slice_summary.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/stages.hpp"

namespace lamella::cli {

namespace {

struct MergeArguments : MeshArguments {
    std::vector<std::string> parts;
    std::string output;
};

void require_possible(const MergeArguments& arguments, const PlannedOutput& output) {
    if (!has_archives()) {
        throw Failure(bad_usage, "--output: '" + output.path + "': this build has no HDF5");
    }
    require_extension(output.path, "--output", ".h5");
    for (const std::string& file : output.files(false)) {
        require_writable(file);
        for (const std::string& part : arguments.parts) {
            require_different(file, part, "--output", "one of the parts");
        }
    }
}

void record(const MergedArchive& merged, const MergeArguments& arguments, const PlannedOutput& output,
            const Control& control) {
    Record record;
    record.command = "merge";
    record.patient_frame = name_of(merged.info.frame);
    record.grid_mm = {merged.unit_mm};
    record.fill_rule = name_of(merged.fill_rule);
    record.result_hashes = {hexadecimal(merged.hash)};
    for (const std::string& part : arguments.parts) {
        record.inputs.push_back(done_or_thrown(seal_file(part, control)));
    }
    write_record_beside(output, std::move(record), control);
}

void merge_parts(const MergeArguments& arguments, Interrupt& interrupt) {
    const PlannedOutput output{arguments.output, OutputFormat::hdf5};
    require_possible(arguments, output);
    interrupt.tidy({output.path, output.record_path()});
    Stages stages(arguments.progress, arguments.threads, interrupt);
    const std::vector<std::filesystem::path> parts(arguments.parts.begin(), arguments.parts.end());
    const Result<MergedArchive> merged =
        stages.run("merging", [&](const Control& control) { return merge_archives(parts, output.path, control); });
    if (!merged) {
        const Failure failure = failure_of(merged.error());
        throw Failure(failure.status() == bad_usage ? bad_input : failure.status(), merged.error().message);
    }
    if (takes_record(output)) {
        stages.run("sealing", [&](const Control& control) { record(*merged, arguments, output, control); });
    }
    print_words(counted(parts.size(), "part") + ", " + counted(merged->layers, "layer") + "\n" + wrote({output.path}),
                false);
}

}  // namespace

void add_merge_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("merge", "Join archives (.h5) of ranges of layers");
    const auto arguments = std::make_shared<MergeArguments>();
    command->add_option("parts", arguments->parts, "Archives that lamella slice --layers A:B wrote, in any order")
        ->required()
        ->type_name("PART.h5")
        ->check(given_path);
    command->add_option("-o,--output", arguments->output, "Archive to write: that of all layers")
        ->required()
        ->type_name("WHOLE.h5")
        ->check(given_path);
    declare_threads(*command, *arguments);
    declare_progress(*command, *arguments);
    declare_worker(*command);
    command->callback([arguments, &interrupt] { merge_parts(*arguments, interrupt); });
}

}  // namespace lamella::cli
