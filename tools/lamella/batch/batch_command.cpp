// lamella batch: many meshes, each sliced by a process of its own, resumed where it was left.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "batch/admission.hpp"
#include "batch/batch_run.hpp"
#include "batch/plan.hpp"
#include "batch/results.hpp"
#include "commands.hpp"
#include "outputs/image_arguments.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace batch {

namespace {

constexpr const char* own_group = "Batch";

struct BatchArguments {
    SliceArguments slice;  ///< its meshes are the sources; what it holds else is read from the command
    int jobs = 0;          ///< 0: as many as there are processors
    std::string memory;
    double timeout_s = 0;
    int retries = 1;
    std::string shard;
    std::string results;
    bool force = false;
    bool hash = false;
    bool merge = false;
};

/// A check in place of CLI11's, which says of what is no number that it is out of a range.
std::string seconds(const std::string& text) {
    const std::optional<double> value = parse_number(text);
    return value && *value >= 0 && *value <= 1e9 ? "" : "'" + text + "' is not a number of seconds";
}

/// The options of slice, some with another meaning.
void declare_slice_options(CLI::App& command, SliceArguments& arguments) {
    declare(command, arguments);
    for (const char* const of_slice : {"--memory", "--hash"}) {
        command.remove_option(command.get_option(of_slice));
    }
    command.get_option("mesh")
        ->description("Mesh files, folders, globs, manifests (.csv, .jsonl); with --merge, results of shards")
        ->type_name("SOURCE");
    command.get_option("--output")->description("Files to write, with {stem}, {name}, {parent}, {dir} for each mesh");
}

void declare_own_options(CLI::App& command, BatchArguments& arguments) {
    command.add_option("--jobs", arguments.jobs, "Use N processors (0: all)")
        ->type_name("N")
        ->check(CLI::Range(0, most_threads))
        ->group(own_group);
    command.add_option("--memory", arguments.memory, "For all meshes at once, as 16G (three quarters of what there is)")
        ->type_name("BYTES")
        ->check(given)
        ->group(own_group);
    command.add_option("--timeout", arguments.timeout_s, "End a mesh that takes longer (0: never)")
        ->type_name("S")
        ->check(seconds)
        ->group(own_group);
    command.add_option("--retries", arguments.retries, "Try again after a crash, want of memory or a timeout (1)")
        ->type_name("N")
        ->check(CLI::Range(0, 100))
        ->group(own_group);
    command.add_option("--shard", arguments.shard, "Only every N-th mesh, from the I-th on, counted from 0")
        ->type_name("I/N")
        ->check(given)
        ->group(own_group);
    command.add_option("--results", arguments.results, "Folder of results.jsonl (that of --output before the first {)")
        ->type_name("FOLDER")
        ->check(given_path)
        ->group(own_group);
    command.add_flag("--force", arguments.force, "Do what is done, too")->group(own_group);
    command.add_flag("--hash", arguments.hash, "Tell whether a mesh has changed by its content, not by its time")
        ->group(own_group);
    command.add_flag("--merge", arguments.merge, "Join the results of all shards into results.jsonl")->group(own_group);
}

LedgerName ledger_name_of(const BatchArguments& arguments) {
    constexpr std::uint32_t most_shards = 100'000;
    const std::vector<std::string>& outputs = arguments.slice.outputs.outputs;
    if (arguments.results.empty() && outputs.empty()) {
        throw Failure(bad_usage,
                      "--results: give it a folder for results.jsonl, such as --results out, as no --output on the command "
                      "line names one");
    }
    LedgerName name;
    name.folder = arguments.results.empty() ? fixed_folder(outputs.front()) : arguments.results;
    if (arguments.shard.empty()) {
        return name;
    }
    const std::string_view text = arguments.shard;
    const std::size_t slash = text.find('/');
    if (slash == std::string_view::npos || !parse_shard(text.substr(0, slash), text.substr(slash + 1), name) ||
        name.shards > most_shards) {
        throw Failure(bad_usage, "--shard: '" + arguments.shard + "' is not I/N with 0 <= I < N, such as 0/4");
    }
    return name;
}

Failure failed_items(std::size_t failed, std::size_t items) {
    return {some_failed, grouped(failed) + " of " + counted(items, "mesh", "meshes") + " failed"};
}

/// Throws Failure where every mesh would fail.
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
    return {.jobs = arguments.jobs > 0 ? arguments.jobs : usable_threads(),
            .memory_bytes = arguments.memory.empty() ? usable_memory() : parse_bytes(arguments.memory, "--memory"),
            .timeout_s = arguments.timeout_s,
            .retries = arguments.retries,
            .force = arguments.force,
            .hash = arguments.hash,
            .names_without_memory = words.names_without_memory(),
            .progress = arguments.slice.progress};
}

/// Every N-th where the batch is divided.
std::vector<Item> items_of_shard(std::vector<Item> items, const LedgerName& name) {
    if (name.shards == 0) {
        return items;
    }
    std::vector<Item> own;
    for (std::size_t i = name.shard; i < items.size(); i += name.shards) {
        own.push_back(std::move(items[i]));
    }
    return own;
}

void slice_meshes(const CLI::App& command, const BatchArguments& arguments, Interrupt& interrupt) {
    const SliceWords words;
    const std::vector<std::string>& sources = arguments.slice.meshes;
    const RunOptions options = run_options(arguments, words);
    const LedgerName name = ledger_name_of(arguments);
    require_image(arguments.slice.image);
    std::vector<std::string> own_files = {name.path(), name.path_of_whole()};
    for (const std::string& source : sources) {
        if (is_named_as_manifest(source)) {
            own_files.push_back(source);
        }
    }
    std::vector<Item> items =
        items_of_shard(plan_items(list_sources(sources, words), words.typed(command), words, own_files), name);
    const std::size_t count = items.size();
    const BatchOutcome outcome = run_batch(std::move(items), name, options, interrupt);
    print(outcome.summary);
    if (outcome.failed > 0) {
        throw failed_items(outcome.failed, count);
    }
}

void merge_results(const BatchArguments& arguments) {
    const MergedResults merged = merge_shards(arguments.slice.meshes);
    const std::size_t failed = merged.failures.size();
    std::string text = "meshes    " + grouped(merged.items) + ": " + grouped(merged.items - failed) + " done, " +
                       grouped(failed) + " failed\nresults   " + printable(merged.path) + "\n";
    for (const std::string& failure : merged.failures) {
        text += "failed    " + printable(failure) + "\n";
    }
    print(text);
    if (failed > 0) {
        throw failed_items(failed, merged.items);
    }
}

}  // namespace

}  // namespace batch

void add_batch_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command =
        app.add_subcommand("batch", "Slice many meshes, each into files of its own, and go on where it was left");
    const auto arguments = std::make_shared<batch::BatchArguments>();
    batch::declare_slice_options(*command, arguments->slice);
    batch::declare_own_options(*command, *arguments);
    command->footer(
        "A manifest list.csv with the lines \"path,like\", \"liver.stl,ct.nii.gz\": lamella batch list.csv --frame lps -o "
        "'masks/{stem}.nii.gz'");
    command->callback([command, arguments, &interrupt] {
        arguments->merge ? batch::merge_results(*arguments) : batch::slice_meshes(*command, *arguments, interrupt);
    });
}

}  // namespace lamella::cli
