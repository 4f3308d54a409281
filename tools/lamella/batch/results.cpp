#include "batch/batch.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <tuple>
#include <unordered_set>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "lamella/io/name_text.hpp"
#include "lamella/medical/record.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli::batch {

namespace {

Json as_text(const std::vector<std::string>& names) {
    Json array = Json::array();
    for (const std::string& name : names) {
        array.push_back(text_of_name(name));
    }
    return array;
}

/// The outputs of an item; `sizes`: with their bytes, which an output that is not there lacks.
Json outputs_of(const Item& item, bool sizes) {
    Json outputs = Json::array();
    for (const std::string& path : item.files) {
        std::error_code unknown;
        const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
        outputs.push_back({{"path", text_of_name(path)}});
        if (sizes && !unknown) {
            outputs.back()["bytes"] = bytes;
        }
    }
    return outputs;
}

using ResultLines = std::unordered_map<std::string, ResultLine>;

std::int64_t modified_ns(const struct stat& file) {
    return std::int64_t{file.st_mtim.tv_sec} * 1'000'000'000 + file.st_mtim.tv_nsec;
}

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
    refuse_if(::flock(file.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK, bad_output,
              path + ": another lamella batch is at work on it");
    return file;
}

/// Adds all lines of a file but one that is torn; returns the bytes of those. Throws Failure (bad_input) if it cannot be
/// read, or holds another line.
std::size_t add_results(const std::string& path, ResultLines& lines) {
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    refuse_if(!file.is_open() || file.bad(), bad_input,
              "cannot read '" + path + "': " + std::generic_category().message(errno));
    std::vector<std::string_view> whole = split(text, '\n');
    const std::size_t bytes = text.size() - whole.back().size();
    whole.pop_back();
    for (std::size_t i = 0; i < whole.size(); ++i) {
        try {
            ResultLine result(Json::parse(whole[i]));
            std::string key = result.key();
            lines.insert_or_assign(std::move(key), std::move(result));
        } catch (const Json::exception&) {
            throw Failure(bad_input, path + ":" + std::to_string(i + 1) + ": no line of lamella batch");
        }
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
        text += line->json.dump() + "\n";
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
        const std::vector<std::string>& outputs = line.second.outputs;
        return !kept.contains(line.first) && std::any_of(outputs.begin(), outputs.end(), [&](const std::string& output) {
            return written.contains(output);
        });
    });
}

/// In their order.
std::vector<LedgerName> shards_of(const std::vector<std::string>& sources) {
    std::vector<LedgerName> shards;
    const auto add = [&shards](const std::filesystem::path& path) {
        std::string name = path.filename().string();
        std::optional<LedgerName> shard;
        if (name.starts_with("results.") && name.ends_with(".jsonl") && name.size() > 14) {
            shard = parse_shard(name.substr(8, name.size() - 14), "-of-");
        }
        if (shard) {
            const std::string folder = path.parent_path().string();
            shard->folder = folder.empty() ? "." : folder;
            shards.push_back(*shard);
        }
        return shard.has_value();
    };
    for (const std::string& source : sources) {
        std::error_code problem;
        if (!std::filesystem::is_directory(source, problem)) {
            refuse_if(!add(source), bad_usage, source + ": is not named results.I-of-N.jsonl");
            continue;
        }
        const std::size_t before = shards.size();
        for (const std::filesystem::directory_entry& entry : entries_of(source, problem)) {
            add(entry.path());
        }
        refuse_if(problem || shards.size() == before, bad_input,
                  source + (problem ? ": cannot be listed: " + problem.message() : ": no results.I-of-N.jsonl of shards"));
    }
    std::sort(shards.begin(), shards.end(), [](const LedgerName& a, const LedgerName& b) { return a.shard < b.shard; });
    return shards;
}

/// One batch, and all of it.
void require_all(const std::vector<LedgerName>& shards) {
    const LedgerName& first = shards.front();
    std::uint32_t missing = 0;
    for (std::size_t i = 0; i < shards.size(); ++i) {
        refuse_if(shards[i].shards != first.shards || shards[i].folder != first.folder, bad_input,
                  "'" + first.path() + "' and '" + shards[i].path() + "' are of different batches");
        refuse_if(i > 0 && shards[i].shard == shards[i - 1].shard, bad_usage, "'" + shards[i].path() + "' is given twice");
        missing += shards[i].shard == missing ? 1 : 0;
    }
    if (missing < first.shards) {
        throw Failure(bad_input, "'" + LedgerName{first.folder, missing, first.shards}.path() + "' is missing: shard " +
                                     std::to_string(missing) + "/" + std::to_string(first.shards) + " has not ended");
    }
}

}  // namespace

ResultLine::ResultLine(Json line) : json(std::move(line)) {
    const auto name_in = [](const Json& text) { return name_of_text(text.get<std::string>()); };
    mesh = name_in(json.at("mesh"));
    if (json.at("status").get<std::string>() != "done") {
        failure = json.at("reason").get<std::string>();
    }
    (void)json.at("options").get<std::vector<std::string>>();
    for (const Json& input : json.at("inputs")) {
        (void)input.at("bytes").get<std::uint64_t>();
    }
    (void)json.at("inputs").at(0);
    (void)json.at("outputs").at(0);
    for (const Json& output : json.at("outputs")) {
        outputs.push_back(name_in(output.at("path")));
    }
}

ResultLine result_of(const Item& item, const std::string& failure, const Json& facts) {
    const bool done = failure.empty();
    Json json = {{"mesh", text_of_name(item.mesh)}, {"status", done ? "done" : "failed"}};
    if (!done) {
        json["reason"] = printable(failure);
    }
    json["options"] = as_text(item.words);
    json["inputs"] = item.inputs;
    json["outputs"] = outputs_of(item, done);
    json.update(facts);
    return ResultLine(std::move(json));
}

Json fact_of(const std::string& path, bool hash, const Callback<bool()>& stop) {
    struct stat file {};
    std::uint64_t bytes = 0;
    std::int64_t modified = 0;
    const auto add = [&] {
        bytes += static_cast<std::uint64_t>(file.st_size);
        modified = std::max(modified, modified_ns(file));
    };
    const bool found = ::stat(path.c_str(), &file) == 0;
    if (found && S_ISDIR(file.st_mode)) {
        std::error_code problem;
        for (const std::filesystem::directory_entry& entry : entries_of(path, problem)) {
            if (::stat(entry.path().c_str(), &file) == 0 && S_ISREG(file.st_mode)) {
                add();
            }
        }
    } else if (found && hash && S_ISREG(file.st_mode)) {
        const Result<FileSeal> seal = seal_file(path, {.stop = stop});
        if (!seal && seal.error().code == ErrorCode::cancelled) {
            throw failure_of(seal.error());
        }
        if (seal) {
            return {{"path", text_of_name(path)}, {"bytes", seal->bytes}, {"sha256", seal->sha256}};
        }
        bytes = static_cast<std::uint64_t>(file.st_size);
    } else if (found) {
        add();
    }
    return {{"path", text_of_name(path)}, {"bytes", bytes}, {"modified_ns", modified}};
}

bool is_done(const Item& item, const ResultLine& line) {
    std::error_code unknown;
    const Json& outputs = line.json.at("outputs");
    return line.done() && line.mesh == item.mesh && line.json.at("options") == as_text(item.words) &&
           line.json.at("inputs") == item.inputs && outputs == outputs_of(item, true) && outputs[0].contains("bytes") &&
           (item.report.empty() || std::filesystem::exists(item.report, unknown));
}

bool is_of_older_version(const ResultLine& line) {
    return std::any_of(changed_defaults.begin(), changed_defaults.end(), [&](const ChangedDefault& changed) {
        const Json& words = line.json.at("options");
        return std::none_of(words.begin(), words.end(), [&](const Json& word) {
            return word.get<std::string>().starts_with(std::string(changed.name) + "=");
        });
    });
}

std::string LedgerName::path() const {
    const std::string name = "results." + std::to_string(shard) + "-of-" + std::to_string(shards) + ".jsonl";
    return shards == 0 ? path_of_whole() : (std::filesystem::path(folder) / name).string();
}

std::string LedgerName::path_of_whole() const {
    return (std::filesystem::path(folder) / "results.jsonl").string();
}

std::optional<LedgerName> parse_shard(const std::string& text, const std::string& between) {
    const std::size_t middle = std::min(text.find(between), text.size());
    LedgerName name;
    const std::string_view all(text);
    return middle < text.size() && parse_integer(all.substr(0, middle), name.shard) &&
                   parse_integer(all.substr(middle + between.size()), name.shards) && name.shard < name.shards
               ? std::optional(name)
               : std::nullopt;
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
    const std::string line = result.json.dump() + "\n";
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
        written.insert(line.outputs.begin(), line.outputs.end());
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
