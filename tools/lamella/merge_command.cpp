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

class MergeCommand {
public:
    MergeCommand(const MergeArguments& arguments, Interrupt& interrupt)
        : arguments_(arguments),
          stages_(arguments.progress, arguments.threads, interrupt),
          output_{arguments.output, OutputFormat::hdf5} {}

    void run() {
        require_possible();
        const MergedArchive merged = merge();
        record(merged);
        print_words(
            counted(arguments_.parts.size(), "part") + ", " + counted(merged.layers, "layer") + "\n" + wrote({output_.path}),
            false);
    }

private:
    void require_possible() {
        if (!has_archives()) {
            throw Failure(bad_usage, "--output: '" + output_.path + "': this build has no HDF5");
        }
        require_extension(output_.path, "--output", ".h5");
        for (const std::string& file : output_.files(false)) {
            require_writable(file);
            for (const std::string& part : arguments_.parts) {
                require_different(file, part, "--output", "one of the parts");
            }
        }
        stages_.interrupt().tidy({output_.path, output_.record_path()});
    }

    MergedArchive merge() {
        const std::vector<std::filesystem::path> parts(arguments_.parts.begin(), arguments_.parts.end());
        Result<MergedArchive> merged =
            stages_.run("merging", [&](const Control& control) { return merge_archives(parts, output_.path, control); });
        if (!merged) {
            const Failure failure = failure_of(merged.error());
            throw Failure(failure.status() == bad_usage ? bad_input : failure.status(), merged.error().message);
        }
        return std::move(merged).value();
    }

    void record(const MergedArchive& merged) {
        if (!takes_record(output_)) {
            return;
        }
        Record record;
        record.command = "merge";
        record.patient_frame = name_of(merged.info.frame);
        record.grid_mm = {merged.unit_mm};
        record.fill_rule = name_of(merged.fill_rule);
        record.result_hashes = {hexadecimal(merged.hash)};
        stages_.run("sealing", [&](const Control& control) {
            for (const std::string& part : arguments_.parts) {
                record.inputs.push_back(done_or_thrown(seal_file(part, control)));
            }
            write_record_beside(output_, std::move(record), control);
        });
    }

    const MergeArguments& arguments_;
    Stages stages_;
    PlannedOutput output_;
};

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
    command->callback([arguments, &interrupt] { MergeCommand(*arguments, interrupt).run(); });
}

}  // namespace lamella::cli
