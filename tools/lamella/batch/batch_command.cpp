// lamella batch: many meshes, each sliced by a process of its own, resumed where it was left.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batch/admission/machine.hpp"
#include "batch/batch_arguments.hpp"
#include "batch/batch_run.hpp"
#include "batch/plan/item_plan.hpp"
#include "batch/results/merge.hpp"
#include "batch/sources/manifest.hpp"
#include "batch/sources/mesh_sources.hpp"
#include "commands.hpp"
#include "outputs/image_arguments.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

using batch::BatchArguments;
using batch::BatchRun;
using batch::Item;
using batch::LedgerName;
using batch::MergedResults;
using batch::RunOptions;
using batch::SliceWords;

Failure failed_items(std::size_t failed, std::size_t items) {
    return {some_failed, grouped(failed) + " of " + counted(items, "mesh", "meshes") + " failed"};
}

/// What every mesh would fail of.
void require_image(const ImageArguments& image) {
    if (!image.like.empty()) {
        (void)read_image_of(image);
    }
    if (!image.spacing.empty()) {
        for (const double side : parse_triple(image.spacing, "--spacing")) {
            if (!(side > 0)) {
                throw Failure(bad_usage, "--spacing: '" + image.spacing + "': a voxel's sides are above 0");
            }
        }
    }
}

RunOptions run_options(const BatchArguments& arguments, const SliceWords& words) {
    return {.jobs = arguments.jobs > 0 ? arguments.jobs : batch::usable_threads(),
            .memory_bytes = arguments.memory.empty() ? batch::usable_memory() : parse_bytes(arguments.memory, "--memory"),
            .timeout_s = arguments.timeout_s,
            .retries = arguments.retries,
            .force = arguments.force,
            .hash = arguments.hash,
            .names_without_memory = words.names_without_memory(),
            .progress = arguments.slice.progress};
}

void run_batch(const CLI::App& command, const BatchArguments& arguments, Interrupt& interrupt) {
    const SliceWords words;
    const RunOptions options = run_options(arguments, words);
    const LedgerName name = batch::ledger_name_of(arguments);
    require_image(arguments.slice.image);
    std::vector<std::string> own_files = {name.path(), name.path_of_whole()};
    for (const std::string& source : arguments.sources()) {
        if (batch::is_named_as_manifest(source)) {
            own_files.push_back(source);
        }
    }
    std::vector<Item> items =
        batch::plan_items(batch::list_sources(arguments.sources(), words), words.typed(command), words, own_files);
    if (name.shards > 0) {
        items = batch::items_of_shard(std::move(items), name.shard, name.shards);
    }
    const std::size_t count = items.size();
    BatchRun run(std::move(items), name, options, interrupt);
    run.run();
    print(run.summary());
    if (run.failed() > 0) {
        throw failed_items(run.failed(), count);
    }
}

void merge_results(const BatchArguments& arguments) {
    const MergedResults merged = batch::merge_shards(arguments.sources());
    std::string text = "meshes    " + grouped(merged.items) + ": " + grouped(merged.items - merged.failed) + " done, " +
                       grouped(merged.failed) + " failed\nresults   " + printable(merged.path) + "\n";
    for (const std::string& failure : merged.failures) {
        text += "failed    ";
        text += printable(failure);
        text += '\n';
    }
    print(text);
    if (merged.failed > 0) {
        throw failed_items(merged.failed, merged.items);
    }
}

}  // namespace

void add_batch_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command =
        app.add_subcommand("batch", "Slice many meshes, each into files of its own, and go on where it was left");
    const auto arguments = std::make_shared<BatchArguments>();
    batch::declare_batch(*command, *arguments);
    command->footer(
        "A manifest list.csv with the lines \"path,like\", \"liver.stl,ct.nii.gz\": lamella batch list.csv --frame lps -o "
        "'masks/{stem}.nii.gz'");
    command->callback([command, arguments, &interrupt] {
        if (arguments->merge) {
            merge_results(*arguments);
        } else {
            run_batch(*command, *arguments, interrupt);
        }
    });
}

}  // namespace lamella::cli
