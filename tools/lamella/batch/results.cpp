#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "batch/batch.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/medical/record.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

using Names = std::unordered_set<std::string>;

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
        const std::uintmax_t bytes = std::filesystem::file_size(path_of(path), unknown);
        outputs.push_back({{"path", text_of_name(path)}});
        if (sizes && !unknown) {
            outputs.back()["bytes"] = bytes;
        }
    }
    return outputs;
}

/// 0 when all is on disk, else an error number.
int write_to_disk(File& file, std::string_view text, std::uint64_t offset) noexcept {
    const int error_number = file.write_at(std::as_bytes(std::span(text)), offset);
    return error_number == 0 ? file.sync() : error_number;
}

/// Adds all lines of a file but one that is torn; returns the bytes of those. Throws Failure (bad_input) if it cannot be
/// read, or holds another line.
std::size_t add_results(const std::string& path, ResultLines& lines) {
    const std::string text = read_bytes(path);
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

/// Writes the lines, by mesh, then by output. The lock of the file that is replaced ends after that, where a system allows
/// it. Throws Failure (bad_output).
void write_durably(const std::string& path, const ResultLines& lines, File replaced) {
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
    OutputFile file = done_or_thrown(OutputFile::create(path_of(path)));
    file.append(text);
    if (!File::can_be_replaced) {
        (void)replaced.close();
    }
    done_or_thrown(file.commit(true));
}

/// Drops the lines of which another item of this batch writes an output.
void drop_overwritten(ResultLines& lines, const Names& written, const Names& kept) {
    std::erase_if(lines, [&](const auto& line) {
        const std::vector<std::string>& outputs = line.second.outputs;
        return !kept.contains(line.first) && std::any_of(outputs.begin(), outputs.end(), [&](const std::string& output) {
            return written.contains(output);
        });
    });
}

/// The shard whose results have this name.
std::optional<ResultsName> shard_at(const std::filesystem::path& path) {
    constexpr std::string_view begin = "results.";
    constexpr std::string_view end = ".jsonl";
    const std::string name = path.filename().string();
    const std::size_t size = name.size() - std::min(name.size(), begin.size() + end.size());
    std::optional<ResultsName> shard =
        parse_shard(std::string_view(name).substr(std::min(name.size(), begin.size()), size), "-of-");
    if (shard) {
        shard->folder = path.parent_path().empty() ? "." : path.parent_path().string();
    }
    return shard && path_of(shard->path()).filename() == name ? shard : std::nullopt;
}

/// All shards of one batch, in their order.
std::vector<ResultsName> shards_of(const std::vector<std::string>& sources) {
    std::vector<ResultsName> shards;
    for (const std::string& source : sources) {
        std::error_code problem;
        const std::size_t before = shards.size();
        const bool is_folder = std::filesystem::is_directory(path_of(source), problem);
        std::vector<std::filesystem::path> paths{path_of(source)};
        if (is_folder) {
            const auto entries = entries_of(path_of(source), problem);
            paths.assign(entries.begin(), entries.end());
        }
        for (const std::filesystem::path& path : paths) {
            if (const std::optional<ResultsName> shard = shard_at(path)) {
                shards.push_back(*shard);
            }
        }
        refuse_if(is_folder && problem, bad_input, source + ": cannot be listed: " + problem.message());
        refuse_if(shards.size() == before, is_folder ? bad_input : bad_usage,
                  source + (is_folder ? ": no results.I-of-N.jsonl of shards" : ": is not named results.I-of-N.jsonl"));
    }
    std::sort(shards.begin(), shards.end(), [](const ResultsName& a, const ResultsName& b) { return a.shard < b.shard; });
    const ResultsName& first = shards.front();
    std::uint32_t missing = 0;
    for (const ResultsName& shard : shards) {
        refuse_if(shard.shards != first.shards || shard.folder != first.folder, bad_input,
                  "'" + first.path() + "' and '" + shard.path() + "' are of different batches");
        refuse_if(shard.shard + 1 == missing, bad_usage, "'" + shard.path() + "' is given twice");
        missing += shard.shard == missing ? 1 : 0;
    }
    refuse_if(missing < first.shards, bad_input,
              "'" + ResultsName{first.folder, missing, first.shards}.path() + "' is missing: shard " +
                  std::to_string(missing) + "/" + std::to_string(first.shards) + " has not ended");
    return shards;
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

ResultLine::ResultLine(const Item& item, const std::string& reason, const Json& facts)
    : mesh(item.mesh), failure(printable(reason)), outputs(item.files) {
    json = {{"mesh", text_of_name(mesh)}, {"status", failure.empty() ? "done" : "failed"}};
    if (!failure.empty()) {
        json["reason"] = failure;
    }
    json["options"] = as_text(item.words);
    json["inputs"] = item.inputs;
    json["outputs"] = outputs_of(item, failure.empty());
    json.update(facts);
}

bool ResultLine::is_of(const Item& item) const {
    std::error_code unknown;
    const Json& found = json.at("outputs");
    return failure.empty() && mesh == item.mesh && json.at("options") == as_text(item.words) &&
           json.at("inputs") == item.inputs && found == outputs_of(item, true) && found[0].contains("bytes") &&
           (item.report.empty() || std::filesystem::exists(path_of(item.report), unknown));
}

bool ResultLine::is_of_older_version() const {
    return std::any_of(changed_defaults.begin(), changed_defaults.end(), [&](const ChangedDefault& changed) {
        const Json& words = json.at("options");
        return std::none_of(words.begin(), words.end(), [&](const Json& word) {
            return word.get<std::string>().starts_with(std::string(changed.name) + "=");
        });
    });
}

Json fact_of(const std::string& path, bool hash, const Callback<bool()>& stop) {
    const std::filesystem::path given = path_of(path);
    std::uint64_t bytes = 0;
    std::int64_t modified = 0;
    const auto add = [&](const std::filesystem::path& file) {
        FileStatus found;
        if (status_of(file, found) == 0 && found.type == std::filesystem::file_type::regular) {
            bytes += found.size;
            modified = std::max(modified, static_cast<std::int64_t>(found.changed));
        }
    };
    std::error_code problem;
    if (hash && std::filesystem::is_regular_file(given, problem)) {
        const Result<FileSeal> seal = seal_file(given, {.stop = stop});
        if (seal) {
            return {{"path", text_of_name(path)}, {"bytes", seal->bytes}, {"sha256", seal->sha256}};
        }
        refuse_if(seal.error().code == ErrorCode::cancelled, bad_input, seal.error().message);
    }
    if (std::filesystem::is_directory(given, problem)) {
        for (const std::filesystem::directory_entry& entry : entries_of(given, problem)) {
            add(entry.path());
        }
    } else {
        add(given);
    }
    return {{"path", text_of_name(path)}, {"bytes", bytes}, {"modified_ns", modified}};
}

std::string ResultsName::path() const {
    const std::string of_shard = "." + std::to_string(shard) + "-of-" + std::to_string(shards);
    return (path_of(folder) / ("results" + when(shards > 0, of_shard) + ".jsonl")).string();
}

std::optional<ResultsName> parse_shard(std::string_view text, std::string_view between) {
    const std::size_t middle = text.find(between);
    ResultsName name;
    return middle != std::string_view::npos && read_integer(text.substr(0, middle), name.shard) &&
                   read_integer(text.substr(middle + between.size()), name.shards) && name.shard < name.shards
               ? std::optional(name)
               : std::nullopt;
}

ResultsFile::ResultsFile(const ResultsName& name) : path_(name.path()), shard_(name.shards > 0) {
    std::error_code unknown;  // shows when the file is opened
    std::filesystem::create_directories(path_of(name.folder), unknown);
    if (const int failure = file_.open_or_create(path_of(path_), 0666); failure != 0) {
        throw unwritable(path_, failure);
    }
    // Where a file system has no locks, that two batches do not meet is up to who starts them.
    refuse_if(file_.lock() == EWOULDBLOCK, bad_output, path_ + ": another lamella batch is at work on it");
    if (shard_ && std::filesystem::exists(path_of(name.path_of_whole()), unknown)) {
        (void)add_results(name.path_of_whole(), lines_);
    }
    bytes_ = add_results(path_, lines_);
    if (const int failure = file_.truncate(bytes_); failure != 0) {  // a torn line
        throw unwritable(path_, failure);
    }
}

const ResultLine* ResultsFile::find(const std::string& key) const {
    const auto found = lines_.find(key);
    return found == lines_.end() ? nullptr : &found->second;
}

void ResultsFile::append(const ResultLine& result) {
    const std::string line = result.json.dump() + "\n";
    if (const int error_number = write_to_disk(file_, line, bytes_); error_number != 0) {
        (void)file_.truncate(bytes_);
        throw unwritable(path_, error_number);
    }
    bytes_ += line.size();
    lines_.insert_or_assign(result.key(), result);
}

void ResultsFile::finish(const std::vector<Item>& items) {
    Names keys;
    Names written;
    for (const Item& item : items) {
        keys.insert(item.key());
        written.insert(item.files.begin(), item.files.end());
    }
    if (shard_) {
        std::erase_if(lines_, [&](const auto& line) { return !keys.contains(line.first); });
    }
    drop_overwritten(lines_, written, keys);
    write_durably(path_, lines_, std::move(file_));
}

void merge_shards(const std::vector<std::string>& sources) {
    const std::vector<ResultsName> shards = shards_of(sources);
    ResultLines lines;
    for (const ResultsName& shard : shards) {
        (void)add_results(shard.path(), lines);
    }
    const std::string path = shards.front().path_of_whole();
    const std::size_t items = lines.size();
    std::vector<std::string> failures;
    Names written;
    for (const auto& [key, line] : lines) {
        if (!line.failure.empty()) {
            failures.push_back("failed    " + printable(line.mesh + ": " + line.failure) + "\n");
        }
        written.insert(line.outputs.begin(), line.outputs.end());
    }
    std::sort(failures.begin(), failures.end());
    std::error_code unknown;
    if (std::filesystem::exists(path_of(path), unknown)) {
        ResultLines earlier;
        (void)add_results(path, earlier);
        drop_overwritten(earlier, written, {});
        lines.merge(earlier);
    }
    write_durably(path, lines, File());
    print("meshes    " + grouped(items) + ": " + grouped(items - failures.size()) + " done, " + grouped(failures.size()) +
          " failed\nresults   " + printable(path) + "\n" + joined(failures, ""));
    refuse_if(!failures.empty(), some_failed,
              grouped(failures.size()) + " of " + counted(items, "mesh", "meshes") + " failed");
}

}  // namespace lamella::cli::batch
