#include "made_again.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <stdlib.h>

#include "files/streams.hpp"
#include "outputs/write_outputs.hpp"
#include "processes/workers.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::verify {

namespace fs = std::filesystem;

namespace {

/// A temporary folder, which goes with its contents: in it what is made again, and the inputs of a record under the names
/// that the record has, by links, since names and warnings of inputs are part of some outputs.
class Workshop {
public:
    /// Throws Failure (bad_input, bad_output), std::filesystem::filesystem_error.
    explicit Workshop(const Record& record) {
        constexpr std::size_t deepest = 64;
        std::size_t ups = 0;
        for (const FileSeal& input : record.inputs) {
            const fs::path path = fs::path(input.path).lexically_normal();
            ups = std::max(ups, static_cast<std::size_t>(std::count(path.begin(), path.end(), "..")));
        }
        refuse_if(ups > deepest, bad_input, "a path of its record leads up by " + std::to_string(ups) + " folders");
        std::string name = (fs::path(temporary_folder()) / "lamella-verify-XXXXXX").string();
        refuse_if(::mkdtemp(name.data()) == nullptr, bad_output, "no temporary folder can be made: " + name);
        top_ = fs::canonical(name);
        inputs_ = top_ / "in";
        for (std::size_t i = 0; i < ups; ++i) {
            inputs_ /= "folder";
        }
        fs::create_directories(inputs_);
        fs::create_directory(outputs());
    }
    ~Workshop() {
        std::error_code left_behind;
        fs::remove_all(top_, left_behind);
    }
    Workshop(const Workshop&) = delete;
    Workshop& operator=(const Workshop&) = delete;

    fs::path outputs() const { return top_ / "out"; }
    /// Where the tool works: so deep that no recorded path leads out of the folder.
    const fs::path& inputs() const noexcept { return inputs_; }

    /// The word that names the input for a process that works there. Throws Failure (bad_input) where the record is
    /// nonsense.
    std::string add(const std::string& recorded, const fs::path& actual) {
        fs::path name = fs::path(recorded).lexically_normal();
        if (name.is_absolute()) {
            if (name == actual.lexically_normal()) {
                return recorded;
            }
            name = fs::path("elsewhere") / std::to_string(++elsewhere_) / name.filename();
        } else if (is_standard(recorded)) {
            name = "mesh";  // as slice names what comes from standard input
        }
        const fs::path link = inputs_ / name;
        refuse_if(!link.lexically_normal().string().starts_with((top_ / "in/").string()) || !name.has_filename(), bad_input,
                  "its record names the input '" + recorded + "'");
        fs::create_directories(link.parent_path());
        if (!fs::is_symlink(link)) {
            fs::create_symlink(actual, link);
        } else if (fs::read_symlink(link) != actual) {
            throw Failure(bad_input, "its record names two inputs '" + recorded + "'");
        }
        return name.string().starts_with('-') ? "./" + name.string() : name.string();
    }

private:
    fs::path top_;
    fs::path inputs_;
    int elsewhere_ = 0;
};

/// Refuses what no command of the tool records.
void require_makeable(const Record& record) {
    refuse_if(record.command != "slice" && record.command != "convert" && record.command != "merge", bad_input,
              "its record names the command '" + record.command + "'");
    const std::size_t hashes = record.result_hashes.size();
    refuse_if(hashes == 0 || record.inputs.size() < count_of_parts(record) || count_of_parts(record) == 0, bad_input,
              "its record has " + counted(record.inputs.size(), "input") + " and " + counted(hashes, "hash", "hashes"));
}

/// The options of the record, which must be those of slice that records hold. `files` are what they name, in their order.
/// Throws Failure (bad_input).
void add_options(const Record& record, std::span<const fs::path> files, Workshop& workshop,
                 std::vector<std::string>& words) {
    CLI::App slice_command;
    SliceArguments arguments;
    declare(slice_command, arguments);
    std::size_t file = record.inputs.size() - files.size();
    for (std::size_t i = 0; i < record.options.size(); ++i) {
        const std::string& name = record.options[i];
        const CLI::Option* const option = name.starts_with("--") ? slice_command.get_option_no_throw(name) : nullptr;
        refuse_if(option == nullptr || !is_recorded(name), bad_input, "'" + name + "' is no option that a record holds");
        if (is_flag(*option)) {
            words.push_back(name);
            continue;
        }
        refuse_if(++i == record.options.size(), bad_input, "its option " + name + " has no value");
        std::string value = record.options[i];
        if (RecordedOption{name, value}.names_file()) {
            refuse_if(files.empty(), bad_input,
                      std::string("its record lacks the SHA-256 of ").append(name).append(" ").append(value));
            value = workshop.add(record.inputs[file++].path, files.front());
            files = files.subspan(1);
        }
        words.push_back(std::string(name).append("=").append(value));
    }
}

std::vector<std::string> words_for(const Record& record, const std::vector<fs::path>& inputs, const fs::path& output,
                                   Workshop& workshop, int threads) {
    std::vector<std::string> words = {"--output=" + output.string(), "--progress=never",
                                      "--threads=" + std::to_string(threads)};
    for (const ChangedDefault& changed : changed_defaults) {
        const bool states = std::find(record.options.begin(), record.options.end(), changed.name) != record.options.end();
        if (record.command == "slice" && !states) {
            words.push_back(std::string(changed.name).append("=").append(changed.before));
        }
    }
    const std::size_t parts = count_of_parts(record);
    add_options(record, std::span(inputs).subspan(parts), workshop, words);
    for (std::size_t i = 0; i < parts; ++i) {
        words.push_back(workshop.add(record.inputs[i].path, inputs[i]));
    }
    return words;
}

void run(const ToolCall& call, const Context& context) {
    constexpr std::chrono::milliseconds between_looks{100};
    WorkerPool pool(0);
    pool.start(0, call);
    while (pool.running() > 0) {
        refuse_if(context.stop(), bad_input, "cancelled");
        for (const WorkerEnd& end : pool.wait(between_looks)) {
            refuse_if(!end.failure.empty(), bad_input, end.failure);
        }
    }
}

bool same_bytes(const fs::path& a, const fs::path& b, const Context& context) {
    const Result<FileSeal> one = seal_file(a, context);
    const Result<FileSeal> other = seal_file(b, context);
    refuse_if(context.stop(), bad_input, "cancelled");
    return one && other && one->bytes == other->bytes && one->sha256 == other->sha256;
}

void compare_records(const Record& record, const Record& again, std::vector<std::string>& found) {
    for (std::size_t i = 0; i < record.result_hashes.size(); ++i) {
        if (i >= again.result_hashes.size() || again.result_hashes[i] != record.result_hashes[i]) {
            found.push_back("the hash of mesh " + std::to_string(i + 1) + " in its record is not that of its layers");
        }
    }
    for (const auto& [what, same] : {std::pair{"patient frame", record.patient_frame == again.patient_frame},
                                     {"grid", record.grid_mm == again.grid_mm},
                                     {"fill rule", record.fill_rule == again.fill_rule},
                                     {"length of gaps", record.stitch_mm.empty() || record.stitch_mm == again.stitch_mm}}) {
        if (!same) {
            found.push_back(std::string("the ") + what + " in its record is not that of its layers");
        }
    }
}

void compare_files(const fs::path& made, const fs::path& output, const std::string& recorded_name, const Context& context,
                   std::vector<std::string>& found) {
    for (const auto& entry : fs::directory_iterator(made)) {
        const fs::path name = entry.path().filename();
        if (name == recorded_name + ".lamella.json") {
            continue;
        }
        const bool is_output = name == recorded_name;
        const fs::path other = is_output ? output : output.parent_path() / name;
        std::error_code unknown;
        if (!fs::exists(other, unknown)) {
            found.push_back("'" + name.string() + "' beside it is missing");
        } else if (!same_bytes(entry.path(), other, context)) {
            found.push_back(is_output ? "made again it has other bytes" : "'" + name.string() + "' beside it differs");
        }
    }
}

}  // namespace

std::size_t count_of_parts(const Record& record) noexcept {
    if (record.command == "merge") {
        return record.inputs.size();
    }
    const std::vector<std::string>& words = record.options;
    if (std::find(words.begin(), words.end(), "--split") == words.end()) {
        return record.result_hashes.size();
    }
    // A mesh has several hashes then; files of options come after the meshes.
    std::size_t files = 0;
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
        files += RecordedOption{words[i], words[i + 1]}.names_file() ? 1 : 0;
    }
    return record.inputs.size() - std::min(files, record.inputs.size());
}

std::vector<std::string> differences_from_remade(const Record& recorded, const fs::path& output,
                                                 const std::vector<fs::path>& inputs, const Context& context) {
    Record record = recorded;
    put_in_words_of_today(record.options);
    require_makeable(record);
    try {
        Workshop workshop(record);
        const fs::path made = workshop.outputs() / record.output.path;
        const std::vector<std::string> words = words_for(record, inputs, made, workshop, context.threads);
        // No other thread looks at the environment, which the process that is started inherits.
        record.source_date_epoch.empty() ? ::unsetenv("SOURCE_DATE_EPOCH")
                                         : ::setenv("SOURCE_DATE_EPOCH", record.source_date_epoch.c_str(), 1);
        run({record.command, words, workshop.inputs().string()}, context);
        const Result<Record> again = read_record(made.string() + ".lamella.json");
        if (!again) {
            throw failure_of(again.error());
        }
        std::vector<std::string> found;
        compare_records(record, *again, found);
        compare_files(workshop.outputs(), output, record.output.path, context, found);
        std::sort(found.begin(), found.end());
        return found;
    } catch (const fs::filesystem_error& error) {
        throw Failure(bad_input, error.code().message());
    }
}

}  // namespace lamella::cli::verify
