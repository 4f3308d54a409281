// lamella verify: whether outputs are what their records say, and, made once more by this program itself from the inputs and
// options of its record, the same.
#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <stdlib.h>

#include "commands.hpp"
#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "lamella/medical/record.hpp"
#include "lamella/version.hpp"
#include "outputs/write_outputs.hpp"
#include "processes/process.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view record_end = ".lamella.json";

struct VerifyArguments {
    std::vector<std::string> given;
    std::vector<std::string> meshes;
    bool inputs = false;
    int threads = 0;
};

/// How a file differs from what a record says of it; empty if it does not. Of what came from standard input only the size is
/// known.
std::string difference(const FileSeal& recorded, const FileSeal& found) {
    if (found.bytes != recorded.bytes) {
        return "has " + counted(found.bytes, "byte") + ", its record says " + grouped(recorded.bytes);
    }
    const bool known = !recorded.sha256.empty() || !is_standard(recorded.path);
    return known && found.sha256 != recorded.sha256 ? "its SHA-256 is not that of its record" : "";
}

/// A record of which what follows can be used. Throws Failure (bad_input).
Record record_at(const fs::path& path) {
    Record record = done_or_thrown(read_record(path));
    const fs::path name(record.output.path);
    refuse_if(name.empty() || name.filename() != name || name == "." || name == "..", bad_input,
              "its record names the output '" + name.string() + "'");
    return record;
}

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

/// How many of the record's inputs the output was made of: meshes, archives or parts. What options name follows them.
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

std::vector<std::string> remaking_words(const Record& record, const std::vector<fs::path>& inputs, const fs::path& output,
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

/// How the output differs from one made again, if it does: one line a finding. `output`: where it lies, with what lies
/// beside it, such as a table of labels. `inputs`: where each input of the record lies now, as absolute paths. They are laid
/// out under the names that the record has, since names and warnings are part of some outputs. Throws Failure where the
/// output cannot be made again.
std::vector<std::string> differences_from_remade(const Record& recorded, const fs::path& output,
                                                 const std::vector<fs::path>& inputs, const Context& context) {
    Record record = recorded;
    put_in_words_of_today(record.options);
    require_makeable(record);
    try {
        Workshop workshop(record);
        const fs::path made = workshop.outputs() / record.output.path;
        const std::vector<std::string> words = remaking_words(record, inputs, made, workshop, context.threads);
        // No other thread looks at the environment, which the process that is started inherits.
        record.source_date_epoch.empty() ? ::unsetenv("SOURCE_DATE_EPOCH")
                                         : ::setenv("SOURCE_DATE_EPOCH", record.source_date_epoch.c_str(), 1);
        const ProcessEnd end =
            run_process({record.command, words, workshop.inputs().string()}, 0, [&] { return context.stop(); });
        refuse_if(!end.failure.empty(), bad_input, context.stop() ? "cancelled" : end.failure);
        std::vector<std::string> found;
        compare_records(record, done_or_thrown(read_record(made.string() + ".lamella.json")), found);
        compare_files(workshop.outputs(), output, record.output.path, context, found);
        std::sort(found.begin(), found.end());
        return found;
    } catch (const fs::filesystem_error& error) {
        throw Failure(bad_input, error.code().message());
    }
}

class VerifyCommand {
public:
    VerifyCommand(const VerifyArguments& arguments, Interrupt& interrupt)
        : arguments_(arguments), context_{.threads = arguments.threads, .stop = interrupt.defer()} {}

    void run() {
        for (const std::string& given : arguments_.given) {
            std::error_code unknown;
            if (fs::is_directory(given, unknown)) {
                verify_folder(given);
            } else if (given.ends_with(record_end)) {
                verify_record(given);
            } else {
                verify_output(given, given + std::string(record_end));
            }
        }
        refuse_if(differing_ > 0, some_failed,
                  of_all(differing_) + (differing_ == 1 ? " differs" : " differ") +
                      (unread_ > 0 ? ", " + of_all(unread_) + " not verified" : ""));
        refuse_if(unread_ > 0, bad_input, of_all(unread_) + " not verified");
    }

private:
    std::string of_all(std::size_t count) const { return std::to_string(count) + " of " + counted(all_, "output"); }

    void say(const std::string& name, const std::string& words) {
        ++all_;
        print(printable(name + ": " + words) + "\n");
    }

    void say_unread(const std::string& name, const std::string& reason) {
        ++unread_;
        say(name, "not verified: " + reason);
    }

    /// `output` lies beside its record, `record_path`.
    void verify_output(const fs::path& output, const fs::path& record_path) {
        try {
            const Record record = record_at(record_path);
            const std::vector<std::string> found = differences(record, output, record_path);
            if (found.empty()) {
                return say(output, remakes() ? "as recorded, and so are its inputs; equal when made again" : "as recorded");
            }
            ++differing_;
            say(output, "differs: " + joined(found, "; ") + other_version(record));
        } catch (const Failure& failure) {
            if (context_.stop()) {
                throw;
            }
            say_unread(output, failure.what());
        }
    }

    /// The output that the record names, or if that is not there the one that has the record's name.
    void verify_record(const std::string& path) {
        const fs::path by_name(path.substr(0, path.size() - record_end.size()));
        const Result<Record> record = read_record(path);
        std::error_code unknown;
        const fs::path named = record ? by_name.parent_path() / record->output.path : by_name;
        const bool renamed = fs::exists(by_name, unknown) || !fs::exists(named, unknown);
        verify_output(renamed ? by_name : named, path);
    }

    void verify_folder(const std::string& folder) {
        std::vector<std::string> records;
        std::error_code problem;
        const auto options = fs::directory_options::skip_permission_denied;
        for (fs::recursive_directory_iterator at(folder, options, problem), end; !problem && at != end;
             at.increment(problem)) {
            if (at->path().string().ends_with(record_end) && !at->is_directory(problem)) {
                records.push_back(at->path().string());
            }
        }
        if (problem || records.empty()) {
            say_unread(folder, problem ? problem.message() : "no records in the folder");
        }
        std::sort(records.begin(), records.end());
        for (const std::string& record : records) {
            verify_record(record);
        }
    }

    bool remakes() const noexcept { return arguments_.inputs || !arguments_.meshes.empty(); }

    std::vector<std::string> differences(const Record& record, const fs::path& output, const fs::path& record_path) const {
        std::vector<std::string> found;
        if (std::string own = difference(record.output, done_or_thrown(seal_file(output, context_))); !own.empty()) {
            found.push_back(std::move(own));
        }
        if (!remakes()) {
            return found;
        }
        const std::vector<fs::path> inputs = inputs_of(record, record_path);
        const std::size_t before = found.size();
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const std::string what = difference(record.inputs[i], done_or_thrown(seal_file(inputs[i], context_)));
            if (!what.empty()) {
                found.push_back("the input '" + inputs[i].string() + "': " + what);
            }
        }
        if (found.size() == before) {
            const std::vector<std::string> more = differences_from_remade(record, output, inputs, context_);
            found.insert(found.end(), more.begin(), more.end());
        }
        return found;
    }

    static std::string other_version(const Record& record) {
        return record.version == version ? "" : " (it was made by lamella " + record.version + ", this is " + version + ")";
    }

    /// The meshes given in place of those in the record; else each where its path leads from here or from the record.
    std::vector<fs::path> inputs_of(const Record& record, const fs::path& record_path) const {
        const std::size_t parts = count_of_parts(record);
        if (!arguments_.meshes.empty() && arguments_.meshes.size() != parts) {
            const std::string made_of =
                record.command == "slice" ? counted(parts, "mesh", "meshes") : counted(parts, "archive");
            throw Failure(bad_input,
                          "it was made of " + made_of + ", and --mesh gives " + std::to_string(arguments_.meshes.size()));
        }
        std::vector<fs::path> inputs;
        for (std::size_t i = 0; i < record.inputs.size(); ++i) {
            if (i < parts && !arguments_.meshes.empty()) {
                inputs.push_back(fs::absolute(arguments_.meshes[i]));
                continue;
            }
            const std::string& path = record.inputs[i].path;
            refuse_if(is_standard(path), bad_input, "its mesh came from standard input: give it with --mesh");
            std::error_code unknown;
            const fs::path beside = record_path.parent_path() / path;
            inputs.push_back(
                fs::absolute(fs::exists(path, unknown) || !fs::exists(beside, unknown) ? fs::path(path) : beside));
        }
        return inputs;
    }

    const VerifyArguments& arguments_;
    Context context_;
    std::size_t all_ = 0;
    std::size_t differing_ = 0;
    std::size_t unread_ = 0;
};

}  // namespace

void add_verify_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("verify", "Check outputs against the records beside them");
    const auto arguments = std::make_shared<VerifyArguments>();
    add_text(*command, "output", arguments->given, "OUTPUT|RECORD|FOLDER",
             "Outputs, their records NAME.lamella.json, or folders of them")
        ->required();
    command->add_flag("--inputs", arguments->inputs,
                      "Check also the inputs that the records name, and make each output again");
    add_text(*command, "--mesh", arguments->meshes, "MESH",
             "The same with this mesh, or archive, in place of the record's; once for each")
        ->excludes("--inputs");
    declare_threads(*command, arguments->threads);
    command->callback([arguments, &interrupt] { VerifyCommand(*arguments, interrupt).run(); });
}

}  // namespace lamella::cli
