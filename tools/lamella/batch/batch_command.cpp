// lamella batch: many meshes, each sliced by a process of its own, resumed where it was left.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "batch/batch.hpp"
#include "batch/machine.hpp"
#include "commands.hpp"
#include "outputs/planned_outputs.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace batch {

namespace {

constexpr const char* own_group = "Batch";

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
    const std::size_t of_slice = command.get_options().size();
    add(command, "--jobs", arguments.jobs, "N", "Use N processors (0: all)")->check(CLI::Range(0, most_threads));
    add_bytes(command, "--memory", "BYTES", "For all meshes at once, as 16G (three quarters of what there is)",
              arguments.memory_bytes);
    add_number(command, "--timeout", "S", "End a mesh that takes longer (0: never)",
               [&arguments](double seconds) { arguments.timeout_s = seconds; });
    add(command, "--retries", arguments.retries, "N", "Try again after a crash, want of memory or a timeout (1)")
        ->check(CLI::Range(0, 100));
    add_text(command, "--shard", arguments.shard, "I/N", "Only every N-th mesh, from the I-th on, counted from 0");
    add_text(command, "--results", arguments.results, "FOLDER",
             "Folder of results.jsonl (that of --output before the first {)");
    command.add_flag("--force", arguments.force, "Do what is done, too");
    command.add_flag("--hash", arguments.hash, "Tell whether a mesh has changed by its content, not by its time");
    command.add_flag("--merge", arguments.merge, "Join the results of all shards into results.jsonl");
    const std::vector<CLI::Option*> all = command.get_options([](const CLI::Option*) { return true; });
    std::for_each(all.begin() + static_cast<std::ptrdiff_t>(of_slice), all.end(),
                  [](CLI::Option* own) { own->group(own_group); });
}

ResultsName results_name_of(const BatchArguments& arguments) {
    constexpr std::uint32_t most_shards = 100'000;
    const std::vector<std::string>& outputs = arguments.slice.outputs.outputs;
    refuse_if(arguments.results.empty() && outputs.empty(), bad_usage,
              "--results: give it a folder for results.jsonl, such as --results out, as no --output on the command "
              "line names one");
    ResultsName name;
    name.folder = arguments.results.empty() ? fixed_folder(outputs.front()) : arguments.results;
    if (!arguments.shard.empty()) {
        const std::optional<ResultsName> shard = parse_shard(arguments.shard, "/");
        if (!shard || shard->shards > most_shards) {
            throw Failure(bad_usage, "--shard: '" + arguments.shard + "' is not I/N with 0 <= I < N, such as 0/4");
        }
        name.shard = shard->shard;
        name.shards = shard->shards;
    }
    return name;
}

Failure failed_items(std::size_t failed, std::size_t items) {
    return {some_failed, grouped(failed) + " of " + counted(items, "mesh", "meshes") + " failed"};
}

/// Throws Failure where every mesh would fail.
void require_image(const ImageArguments& image) {
    if (!image.like.empty()) {
        (void)done_or_thrown(read_image_geometry(image.like));
    }
    if (!image.spacing.empty()) {
        for (const double side : parse_triple(image.spacing, "--spacing")) {
            refuse_if(!(side > 0), bad_usage, "--spacing: '" + image.spacing + "': a voxel's sides are above 0");
        }
    }
}

void slice_meshes(const CLI::App& command, BatchArguments& arguments, Interrupt& interrupt) {
    const SliceOptionNames names;
    const std::vector<std::string>& sources = arguments.slice.meshes;
    arguments.jobs = arguments.jobs > 0 ? arguments.jobs : usable_threads();
    arguments.memory_bytes = arguments.memory_bytes > 0 ? arguments.memory_bytes : usable_memory();
    const ResultsName name = results_name_of(arguments);
    require_image(arguments.slice.image);
    std::vector<std::string> own_files = {name.path(), name.path_of_whole()};
    std::copy_if(sources.begin(), sources.end(), std::back_inserter(own_files), is_named_as_manifest);
    std::vector<Item> items = plan_items(list_sources(sources, names), names.typed(command), own_files);
    std::size_t count = 0;
    std::erase_if(items, [&](const Item&) { return count++ % std::max(name.shards, 1U) != name.shard; });
    count = items.size();
    if (const std::size_t failed = run_batch(std::move(items), name, arguments, interrupt); failed > 0) {
        throw failed_items(failed, count);
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
