// lamella batch: many meshes, each sliced by a process of its own, resumed where it was left.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <utility>

#include "base/system/machine.hpp"
#include "batch/batch.hpp"
#include "files/flags.hpp"
#include "outputs/outputs.hpp"
#include "slice/slice.hpp"
#include "system/process.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace batch {

namespace {

// --- what the machine grants this process

constexpr double no_limit = std::numeric_limits<double>::infinity();

/// The least limit in a file of this name in the control groups of this process, its own and those above it: a number, or
/// "max", over another number that may follow. `controller`: of version 1, or "" for all of version 2.
double group_limit(const std::string& controller, const std::string& name) {
    std::ifstream groups("/proc/self/cgroup");
    double least = no_limit;
    for (std::string line; std::getline(groups, line);) {  // "9:memory:/user.slice", or "0::/user.slice" for all
        const std::size_t middle = line.find(':' + controller + ":/");
        if (middle == std::string::npos) {
            continue;
        }
        std::filesystem::path group = line.substr(middle + controller.size() + 3);
        const std::filesystem::path top = std::filesystem::path("/sys/fs/cgroup") / controller;
        for (bool more = true; more; group = group.parent_path()) {
            more = !group.empty();
            std::ifstream file(top / group / name);
            std::string limit;
            double period = 1;
            file >> limit;
            if (!(file >> period)) {
                period = 1;
            }
            least = std::min(least, parse_number(limit).value_or(no_limit) / period);
        }
    }
    return least;
}

/// Processors: the lesser of what the machine has and what this process's control group grants, in cpu.max "200000 100000":
/// two.
int usable_threads() {
    return static_cast<int>(std::max(1.0, std::min<double>(granted_processors(), std::ceil(group_limit("", "cpu.max")))));
}

/// Three quarters of the memory that they have, or what is free if that is less.
std::uint64_t usable_memory() {
    constexpr double least = 32 << 20;
    constexpr double most = 1e18;  // where no limit is known
    const double group = std::min(group_limit("", "memory.max"), group_limit("memory", "memory.limit_in_bytes"));
    const auto known = [](std::uint64_t bytes) { return bytes > 0 ? static_cast<double>(bytes) : no_limit; };
    const double all = std::min(known(physical_memory_bytes()), group);
    return static_cast<std::uint64_t>(std::clamp(std::min(all / 4 * 3, known(free_memory_bytes())), least, most));
}

// --- the command

/// The options of slice, some with another meaning, and those of a batch.
void declare(CLI::App& command, BatchArguments& arguments) {
    cli::declare(command, arguments.slice);
    for (const char* const of_slice : {"--memory", "--hash"}) {
        command.remove_option(command.get_option(of_slice));
    }
    command.get_option("mesh")
        ->description("Mesh files, folders, globs, manifests (.csv, .jsonl); with --merge, results of shards")
        ->type_name("SOURCE");
    command.get_option("--output")->description("Files to write, with {stem}, {name}, {parent}, {dir} for each mesh");
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
                  [](CLI::Option* own) { own->group("Batch"); });
}

ResultsName results_name_of(const BatchArguments& arguments) {
    constexpr std::uint32_t most_shards = 100'000;
    const std::vector<std::string>& outputs = arguments.slice.outputs.outputs;
    refuse_if(arguments.results.empty() && outputs.empty(), bad_usage,
              "--results: give it a folder for results.jsonl, such as --results out, as no --output on the command "
              "line names one");
    ResultsName name;
    name.folder = arguments.results;
    if (name.folder.empty()) {  // in which all outputs lie: "out" of 'out/{stem}.svg', "." of '{stem}.svg'
        const std::filesystem::path fixed = path_of(outputs.front().substr(0, outputs.front().find('{')));
        name.folder = fixed.has_parent_path() ? fixed.parent_path().string() : ".";
    }
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

void slice_meshes(const CLI::App& command, BatchArguments& arguments, Interrupt& interrupt) {
    arguments.jobs = arguments.jobs > 0 ? arguments.jobs : usable_threads();
    arguments.memory_bytes = arguments.memory_bytes > 0 ? arguments.memory_bytes : usable_memory();
    const ResultsName name = results_name_of(arguments);
    if (const ImageArguments& image = arguments.slice.image; !image.like.empty()) {  // with a bad one every mesh would fail
        (void)done_or_thrown(read_image_geometry(path_of(image.like), image.of_like));
    }
    std::vector<Item> items = plan_items(command, arguments.slice.meshes, {name.path(), name.path_of_whole()});
    std::size_t count = 0;
    std::erase_if(items, [&](const Item&) { return count++ % std::max(name.shards, 1U) != name.shard; });
    run_batch(std::move(items), name, arguments, interrupt);
}

}  // namespace

}  // namespace batch

void add_batch_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command =
        app.add_subcommand("batch", "Slice many meshes, each into files of its own, and go on where it was left");
    const auto arguments = std::make_shared<batch::BatchArguments>();
    batch::declare(*command, *arguments);
    command->footer(
        "A manifest list.csv with the lines \"path,like\", \"liver.stl,ct.nii.gz\": lamella batch list.csv --frame lps -o "
        "'masks/{stem}.nii.gz'");
    command->callback([command, arguments, &interrupt] {
        arguments->merge ? batch::merge_shards(arguments->slice.meshes)
                         : batch::slice_meshes(*command, *arguments, interrupt);
    });
}

}  // namespace lamella::cli
