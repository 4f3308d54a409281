#include "batch/results.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <tuple>
#include <unordered_set>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "files/mesh_input.hpp"
#include "files/text_input.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

constexpr std::string_view shard_begin = "results.";
constexpr std::string_view shard_middle = "-of-";
constexpr std::string_view shard_end = ".jsonl";

/// 0 when all is on disk, else an error number.
int write_to_disk(const Descriptor& file, std::string_view text) noexcept {
    const int error_number = write_all(file, text);
    return error_number == 0 && ::fsync(file.number()) != 0 ? errno : error_number;
}

void sync_folder(const std::string& folder) noexcept {
    const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    (void)::fsync(opened.number());  // Some file systems have none for folders.
}

Descriptor open_locked(const std::string& path) {
    std::error_code problem;  // shows when the file is opened
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), problem);
    Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
    if (file.number() < 0) {
        throw unwritable(path, errno);
    }
    // Where a file system has no locks, that two batches do not meet is up to who starts them.
    if (::flock(file.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        throw Failure(bad_output, path + ": another lamella batch is at work on it");
    }
    return file;
}

/// Adds all lines of a file but one that is torn; returns the bytes of those. Throws Failure (bad_input) if it cannot be
/// read, or holds another line.
std::size_t add_results(const std::string& path, ResultLines& lines) {
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file.is_open() || file.bad()) {
        throw Failure(bad_input, "cannot read '" + path + "': " + std::generic_category().message(errno));
    }
    std::vector<std::string_view> whole = split(text, '\n');
    const std::size_t bytes = text.size() - whole.back().size();
    whole.pop_back();
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::optional<ResultLine> result = parse_line(whole[i]);
        if (!result) {
            throw Failure(bad_input, path + ":" + std::to_string(i + 1) + ": no line of lamella batch");
        }
        std::string key = result->key();
        lines.insert_or_assign(std::move(key), *std::move(result));
    }
    return bytes;
}

/// By mesh, then by output.
std::string ordered_text(const ResultLines& lines) {
    std::vector<const ResultLine*> order;
    order.reserve(lines.size());
    for (const auto& [key, line] : lines) {
        order.push_back(&line);
    }
    std::sort(order.begin(), order.end(), [](const ResultLine* a, const ResultLine* b) {
        return std::tie(a->mesh, a->key()) < std::tie(b->mesh, b->key());
    });
    std::string text;
    for (const ResultLine* line : order) {
        text += line_of(*line);
    }
    return text;
}

/// Writes aside, waits for the disk, renames. Throws Failure (bad_output).
void write_durably(const std::string& path, const std::string& text) {
    const std::filesystem::path target(path);
    const std::string folder = target.has_parent_path() ? target.parent_path().string() : ".";
    const std::string aside = folder + "/." + target.filename().string() + "." + std::to_string(::getpid()) + "-0.part";
    const Descriptor file(::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (file.number() < 0) {
        throw unwritable(path, errno);
    }
    int error_number = write_to_disk(file, text);
    if (error_number == 0 && ::rename(aside.c_str(), path.c_str()) != 0) {
        error_number = errno;
    }
    if (error_number != 0) {
        ::unlink(aside.c_str());
        throw unwritable(path, error_number);
    }
    sync_folder(folder);
}

/// Drops the lines of which another item of this batch writes an output.
void drop_overwritten(ResultLines& lines, const std::unordered_set<std::string>& written,
                      const std::unordered_set<std::string>& kept) {
    std::erase_if(lines, [&](const auto& line) {
        const std::vector<OutputFact>& outputs = line.second.outputs;
        return !kept.contains(line.first) && std::any_of(outputs.begin(), outputs.end(), [&](const OutputFact& output) {
            return written.contains(output.path);
        });
    });
}

/// Reads I and N of results.I-of-N.jsonl; none for other names.
std::optional<LedgerName> parse_shard_name(const std::filesystem::path& path) {
    const std::string file = path.filename().string();
    const std::string_view name = file;
    const std::size_t middle = name.find(shard_middle);
    if (!name.starts_with(shard_begin) || !name.ends_with(shard_end) || middle == std::string_view::npos) {
        return std::nullopt;
    }
    const std::string folder = path.parent_path().string();
    LedgerName found{folder.empty() ? "." : folder, 0, 0};
    const std::string_view index = name.substr(shard_begin.size(), middle - shard_begin.size());
    const std::string_view count = name.substr(middle + shard_middle.size());
    return parse_shard(index, count.substr(0, count.size() - shard_end.size()), found) ? std::optional(found) : std::nullopt;
}

void add_shards_of_folder(const std::string& folder, std::vector<LedgerName>& shards) {
    std::error_code problem;
    const std::size_t before = shards.size();
    for (const std::filesystem::directory_entry& entry : entries_of(folder, problem)) {
        if (std::optional<LedgerName> name = parse_shard_name(entry.path())) {
            shards.push_back(*std::move(name));
        }
    }
    if (problem) {
        throw Failure(bad_input, folder + ": cannot be listed: " + problem.message());
    }
    if (shards.size() == before) {
        throw Failure(bad_input, folder + ": no results.I-of-N.jsonl of shards");
    }
}

/// In their order.
std::vector<LedgerName> shards_of(const std::vector<std::string>& sources) {
    std::vector<LedgerName> shards;
    for (const std::string& source : sources) {
        std::error_code unknown;
        if (std::filesystem::is_directory(source, unknown)) {
            add_shards_of_folder(source, shards);
        } else if (std::optional<LedgerName> name = parse_shard_name(source)) {
            shards.push_back(*std::move(name));
        } else {
            throw Failure(bad_usage, source + ": is not named results.I-of-N.jsonl");
        }
    }
    std::sort(shards.begin(), shards.end(), [](const LedgerName& a, const LedgerName& b) { return a.shard < b.shard; });
    return shards;
}

/// One batch, and all of it.
void require_all(const std::vector<LedgerName>& shards) {
    const LedgerName& first = shards.front();
    std::uint32_t missing = 0;
    for (std::size_t i = 0; i < shards.size(); ++i) {
        if (shards[i].shards != first.shards || shards[i].folder != first.folder) {
            throw Failure(bad_input, "'" + first.path() + "' and '" + shards[i].path() + "' are of different batches");
        }
        if (i > 0 && shards[i].shard == shards[i - 1].shard) {
            throw Failure(bad_usage, "'" + shards[i].path() + "' is given twice");
        }
        missing += shards[i].shard == missing ? 1 : 0;
    }
    if (missing < first.shards) {
        throw Failure(bad_input, "'" + LedgerName{first.folder, missing, first.shards}.path() + "' is missing: shard " +
                                     std::to_string(missing) + "/" + std::to_string(first.shards) + " has not ended");
    }
}

}  // namespace

std::string LedgerName::path() const {
    std::string name;
    name.append(shard_begin).append(std::to_string(shard)).append(shard_middle).append(std::to_string(shards));
    return shards == 0 ? path_of_whole() : (std::filesystem::path(folder) / name.append(shard_end)).string();
}

std::string LedgerName::path_of_whole() const {
    return (std::filesystem::path(folder) / "results.jsonl").string();
}

bool parse_shard(std::string_view index, std::string_view count, LedgerName& name) {
    const auto parse = [](std::string_view text, std::uint32_t& value) {
        const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
        return problem == std::errc() && stop == text.data() + text.size();
    };
    return parse(index, name.shard) && parse(count, name.shards) && name.shard < name.shards;
}

Ledger::Ledger(const LedgerName& name) : path_(name.path()), shard_(name.shards > 0), file_(open_locked(path_)) {
    std::error_code unknown;
    if (shard_ && std::filesystem::exists(name.path_of_whole(), unknown)) {
        (void)add_results(name.path_of_whole(), lines_);
    }
    bytes_ = add_results(path_, lines_);
    if (std::filesystem::file_size(path_, unknown) != bytes_ &&
        ::ftruncate(file_.number(), static_cast<off_t>(bytes_)) != 0) {
        throw unwritable(path_, errno);
    }
}

const ResultLine* Ledger::find(const std::string& key) const {
    const auto found = lines_.find(key);
    return found == lines_.end() ? nullptr : &found->second;
}

void Ledger::append(const ResultLine& result) {
    const std::string line = line_of(result);
    if (const int error_number = write_to_disk(file_, line); error_number != 0) {
        (void)!::ftruncate(file_.number(), static_cast<off_t>(bytes_));
        throw unwritable(path_, error_number);
    }
    bytes_ += line.size();
    lines_.insert_or_assign(result.key(), result);
}

void Ledger::finish(const std::vector<Item>& items) {
    std::unordered_set<std::string> keys;
    std::unordered_set<std::string> written;
    for (const Item& item : items) {
        keys.insert(item.key());
        written.insert(item.files.begin(), item.files.end());
    }
    if (shard_) {
        std::erase_if(lines_, [&](const auto& line) { return !keys.contains(line.first); });
    }
    drop_overwritten(lines_, written, keys);
    write_durably(path_, ordered_text(lines_));
}

MergedResults merge_shards(const std::vector<std::string>& sources) {
    const std::vector<LedgerName> shards = shards_of(sources);
    require_all(shards);
    ResultLines lines;
    for (const LedgerName& shard : shards) {
        (void)add_results(shard.path(), lines);
    }
    MergedResults merged{.path = shards.front().path_of_whole(), .items = lines.size(), .failures = {}};
    std::unordered_set<std::string> written;
    for (const auto& [key, line] : lines) {
        if (!line.done()) {
            merged.failures.push_back(line.mesh + ": " + line.failure);
        }
        for (const OutputFact& output : line.outputs) {
            written.insert(output.path);
        }
    }
    std::sort(merged.failures.begin(), merged.failures.end());
    std::error_code unknown;
    if (std::filesystem::exists(merged.path, unknown)) {
        ResultLines earlier;
        (void)add_results(merged.path, earlier);
        drop_overwritten(earlier, written, {});
        lines.merge(earlier);
    }
    write_durably(merged.path, ordered_text(lines));
    return merged;
}

}  // namespace lamella::cli::batch
