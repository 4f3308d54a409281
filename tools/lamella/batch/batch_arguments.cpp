#include "batch/batch_arguments.hpp"

#include <charconv>
#include <optional>
#include <system_error>

#include "batch/plan/name_pattern.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli::batch {

namespace {

constexpr const char* own_group = "Batch";
constexpr std::uint32_t most_shards = 100'000;

/// Of nothing that is no number CLI11 says that it is out of a range.
std::string seconds(const std::string& text) {
    const std::optional<double> value = parse_number(text);
    return value && *value >= 0 && *value <= 1e9 ? "" : "'" + text + "' is not a number of seconds";
}

bool parse_whole(std::string_view text, std::uint32_t& value) {
    const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    return problem == std::errc() && stop == text.data() + text.size();
}

}  // namespace

void declare_batch(CLI::App& command, BatchArguments& arguments) {
    declare(command, arguments.slice);
    for (const char* const of_slice : {"--memory", "--hash"}) {  // which mean something else for a batch
        command.remove_option(command.get_option(of_slice));
    }
    command.get_option("mesh")
        ->description("Mesh files, folders, globs, manifests (.csv, .jsonl); with --merge, results of shards")
        ->type_name("SOURCE");
    command.get_option("--output")->description("Files to write, with {stem}, {name}, {parent}, {dir} for each mesh");
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
    LedgerName name;
    if (!arguments.results.empty()) {
        name.folder = arguments.results;
    } else if (!arguments.slice.outputs.outputs.empty()) {
        name.folder = fixed_folder(arguments.slice.outputs.outputs.front());
    } else {
        throw Failure(bad_usage,
                      "--results: give it a folder for results.jsonl, such as --results out, as no --output on the command "
                      "line names one");
    }
    if (arguments.shard.empty()) {
        return name;
    }
    const std::string& text = arguments.shard;
    const std::size_t slash = text.find('/');
    if (slash == std::string::npos || !parse_whole(std::string_view(text).substr(0, slash), name.shard) ||
        !parse_whole(std::string_view(text).substr(slash + 1), name.shards) || name.shard >= name.shards ||
        name.shards > most_shards) {
        throw Failure(bad_usage, "--shard: '" + text + "' is not I/N with 0 <= I < N, such as 0/4");
    }
    return name;
}

}  // namespace lamella::cli::batch
