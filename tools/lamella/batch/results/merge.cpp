#include "batch/results/merge.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <system_error>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "batch/results/ledger.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

std::optional<std::uint32_t> whole_number(std::string_view text) {
    std::uint32_t value = 0;
    const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    return problem == std::errc() && stop == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// Of results.I-of-N.jsonl.
std::optional<LedgerName> parse_shard_name(const std::filesystem::path& path) {
    constexpr std::string_view before = "results.";
    constexpr std::string_view between = "-of-";
    constexpr std::string_view after = ".jsonl";
    const std::string name = path.filename().string();
    const std::size_t middle = name.find(between);
    if (!name.starts_with(before) || !name.ends_with(after) || middle == std::string::npos) {
        return std::nullopt;
    }
    const std::string_view text = name;
    const auto shard = whole_number(text.substr(before.size(), middle - before.size()));
    const auto shards =
        whole_number(text.substr(middle + between.size(), text.size() - after.size() - middle - between.size()));
    if (!shard || !shards || *shard >= *shards) {
        return std::nullopt;
    }
    const std::string folder = path.parent_path().string();
    return LedgerName{folder.empty() ? "." : folder, *shard, *shards};
}

std::vector<std::filesystem::path> shard_files(const std::string& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code problem;
    for (std::filesystem::directory_iterator at(folder, problem); !problem && at != std::filesystem::directory_iterator();
         at.increment(problem)) {
        if (parse_shard_name(at->path())) {
            files.push_back(at->path());
        }
    }
    if (problem) {
        throw Failure(bad_input, folder + ": cannot be listed: " + problem.message());
    }
    if (files.empty()) {
        throw Failure(bad_input, folder + ": no results.I-of-N.jsonl of shards");
    }
    return files;
}

std::vector<LedgerName> shards_of(const std::vector<std::string>& sources) {
    std::vector<std::filesystem::path> files;
    for (const std::string& source : sources) {
        std::error_code unknown;
        if (std::filesystem::is_directory(source, unknown)) {
            const std::vector<std::filesystem::path> found = shard_files(source);
            files.insert(files.end(), found.begin(), found.end());
        } else {
            files.emplace_back(source);
        }
    }
    std::vector<LedgerName> shards;
    for (const std::filesystem::path& file : files) {
        std::optional<LedgerName> name = parse_shard_name(file);
        if (!name) {
            throw Failure(bad_usage, file.string() + ": is not named results.I-of-N.jsonl");
        }
        shards.push_back(*std::move(name));
    }
    std::sort(shards.begin(), shards.end(), [](const LedgerName& a, const LedgerName& b) { return a.shard < b.shard; });
    return shards;
}

/// One batch, and all of it.
void require_all(const std::vector<LedgerName>& shards) {
    for (std::size_t i = 0; i < shards.size(); ++i) {
        const LedgerName& first = shards.front();
        if (shards[i].shards != first.shards || shards[i].folder != first.folder) {
            throw Failure(bad_input, "'" + first.path() + "' and '" + shards[i].path() + "' are of different batches");
        }
        if (i > 0 && shards[i].shard == shards[i - 1].shard) {
            throw Failure(bad_usage, "'" + shards[i].path() + "' is given twice");
        }
        if (shards[i].shard != i) {
            break;
        }
    }
    std::uint32_t missing = 0;
    while (missing < shards.size() && shards[missing].shard == missing) {
        ++missing;
    }
    if (missing < shards.front().shards) {
        const LedgerName absent{shards.front().folder, missing, shards.front().shards};
        throw Failure(bad_input, "'" + absent.path() + "' is missing: shard " + std::to_string(missing) + "/" +
                                     std::to_string(absent.shards) + " has not ended");
    }
}

using Lines = std::unordered_map<std::string, ResultLine>;

/// The lines of before that no shard replaces.
Lines earlier_lines(const std::string& path, const Lines& merged) {
    Lines kept;
    std::error_code unknown;
    if (!std::filesystem::exists(path, unknown)) {
        return kept;
    }
    std::unordered_set<std::string> written;
    for (const auto& [key, line] : merged) {
        for (const OutputFact& output : line.outputs) {
            written.insert(output.path);
        }
    }
    for (ResultLine& line : read_results(path)) {
        const bool replaced = std::any_of(line.outputs.begin(), line.outputs.end(),
                                          [&](const OutputFact& output) { return written.contains(output.path); });
        if (!replaced) {
            std::string key = line.key();
            kept.insert_or_assign(std::move(key), std::move(line));
        }
    }
    return kept;
}

}  // namespace

MergedResults merge_shards(const std::vector<std::string>& sources) {
    const std::vector<LedgerName> shards = shards_of(sources);
    require_all(shards);
    Lines lines;
    for (const LedgerName& shard : shards) {
        for (ResultLine& line : read_results(shard.path())) {
            std::string key = line.key();
            lines.insert_or_assign(std::move(key), std::move(line));
        }
    }
    MergedResults merged{.path = shards.front().path_of_whole(), .items = lines.size(), .failed = 0, .failures = {}};
    for (const auto& [key, line] : lines) {
        if (!line.done()) {
            merged.failures.push_back(line.mesh + ": " + line.failure);
        }
    }
    std::sort(merged.failures.begin(), merged.failures.end());
    merged.failed = merged.failures.size();
    Lines earlier = earlier_lines(merged.path, lines);
    lines.merge(earlier);
    write_durably(merged.path, ordered_text(lines));
    return merged;
}

}  // namespace lamella::cli::batch
