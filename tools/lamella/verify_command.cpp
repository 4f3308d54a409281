// lamella verify: whether outputs are what their records say, and, made once more by this program itself from the inputs and
// options of its record, the same.
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/system/file.hpp"
#include "files/combination.hpp"
#include "files/mesh_input.hpp"
#include "lamella/medical.hpp"
#include "lamella/version.hpp"
#include "outputs/outputs.hpp"
#include "processes/process.hpp"
#include "slice/slice.hpp"
#include "system/terminal.hpp"
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

/// How many of the record's inputs the output was made of: meshes, archives or parts. What options name follows them.
std::size_t count_of_parts(const Record& record) {
    std::size_t files = 0;
    for (std::size_t i = 0; i + 1 < record.options.size(); ++i) {
        files += RecordedOption{record.options[i], record.options[i + 1]}.names_file() ? 1U : 0U;
    }
    return record.inputs.size() - std::min(files, record.inputs.size());
}

/// The file, or folder, under another name, too. Windows has symbolic links for few, and hard ones for files of one volume.
void make_link(const fs::path& actual, const fs::path& link) {
    std::error_code problem;
    fs::create_symlink(actual, link, problem);
    if (problem == std::errc::function_not_supported || problem == std::errc::operation_not_permitted) {
        fs::create_hard_link(actual, link, problem);
        if (problem) {
            fs::copy(actual, link, fs::copy_options::recursive);
        }
    } else if (problem) {
        throw fs::filesystem_error("link", actual, link, problem);
    }
}

/// An output made once more, in a temporary folder, which goes with its contents: in it what is made, and the inputs under
/// the names that the record has, by links, since names and warnings of inputs are part of some outputs. All throws Failure
/// (bad_input) where the record is nonsense, Failure (bad_output) or std::filesystem::filesystem_error.
class Remaking {
public:
    /// `inputs`: where each input of the record lies now, as absolute paths.
    Remaking(const Record& recorded, const std::vector<fs::path>& inputs, const Context& context)
        : record_(recorded), actual_(inputs), context_(context) {
        put_in_words_of_today(record_.options);
        // What no command of the tool records is refused.
        const std::string& command = record_.command;
        refuse_if(command != "slice" && command != "convert" && command != "combine" && command != "merge", bad_input,
                  "its record names the command '" + command + "'");
        const std::size_t hashes = record_.result_hashes.size();
        const bool split = std::count(record_.options.begin(), record_.options.end(), "--split") > 0;  // several of a mesh
        parts_ = count_of_parts(record_);
        refuse_if(hashes == 0 || parts_ == 0 || (hashes != parts_ && !split && command != "merge" && command != "combine"),
                  bad_input,
                  "its record has " + counted(record_.inputs.size(), "input") + " and " + counted(hashes, "hash", "hashes"));
        fs::path made;
        const int failure = make_unique(path_of(temporary_folder()) / "lamella-verify-", {}, made, [](const fs::path& path) {
            std::error_code problem;
            const bool is_new = fs::create_directory(path, problem);
            return is_new || problem ? error_number_of(problem) : EEXIST;
        });
        refuse_if(failure != 0, bad_output, "no temporary folder can be made: " + made.string());
        fs::permissions(made, fs::perms::owner_all);
        top_ = fs::canonical(made);
        // The tool works so deep that no recorded path leads out of the folder.
        inputs_ = top_ / "in";
        for (int i = 0; i < deepest; ++i) {
            inputs_ /= "d";
        }
        fs::create_directories(inputs_);
        fs::create_directory(top_ / "out");
    }
    ~Remaking() {
        std::error_code left_behind;
        fs::remove_all(top_, left_behind);
    }
    Remaking(const Remaking&) = delete;
    Remaking& operator=(const Remaking&) = delete;

    /// One line a finding. `output`: where it lies, with what lies beside it, such as a table of labels.
    std::vector<std::string> differences(const fs::path& output) {
        const fs::path made = top_ / "out" / path_of(record_.output.path);
        // No other thread looks at the environment, which the process that is started inherits.
        set_environment("SOURCE_DATE_EPOCH", record_.source_date_epoch);
        const ProcessEnd end = run_process(words(made), inputs_.string(), 0, [this] { return context_.stop(); });
        refuse_if(!end.failure.empty(), bad_input, context_.stop() ? "cancelled" : end.failure);
        compare_records(done_or_thrown(read_record(fs::path(made) += record_end)));
        compare_files(output);
        std::sort(found_.begin(), found_.end());
        return found_;
    }

private:
    static constexpr int deepest = 64;  ///< folders that a recorded path leads up

    /// The word that names an input for a process that works in the folder.
    std::string link(std::size_t input) {
        const std::string& recorded = record_.inputs[input].path;
        const fs::path& actual = actual_[input];
        fs::path name = path_of(recorded).lexically_normal();
        if (name.is_absolute() && name == actual.lexically_normal()) {
            return recorded;
        }
        if (name.has_root_path()) {
            name = fs::path("elsewhere") / std::to_string(input) / name.filename();
        } else if (is_standard(recorded)) {
            name = "mesh";  // as slice names what comes from standard input
        }
        const fs::path link = inputs_ / name;
        refuse_if(!link.lexically_normal().string().starts_with((top_ / "in/").lexically_normal().string()) ||
                      !name.has_filename(),
                  bad_input, "its record names the input '" + recorded + "'");
        fs::create_directories(link.parent_path());
        const auto [at, is_new] = linked_.emplace(link.lexically_normal(), actual);
        if (is_new) {
            make_link(actual, link);
        }
        refuse_if(at->second != actual, bad_input, "its record names two inputs '" + recorded + "'");
        return name.string().starts_with('-') ? "./" + name.string() : name.string();
    }

    std::vector<std::string> words(const fs::path& made) {
        std::vector<std::string> words = {record_.command, "--output=" + made.string(), "--progress=never",
                                          "--threads=" + std::to_string(context_.threads)};
        for (const ChangedDefault& changed : changed_defaults) {
            const std::vector<std::string>& options = record_.options;
            if (record_.command == "slice" && std::find(options.begin(), options.end(), changed.name) == options.end()) {
                words.push_back(std::string(changed.name).append("=").append(changed.before));
            }
        }
        add_options(parts_, words);
        for (std::size_t i = 0; i < parts_; ++i) {
            words.push_back(link(i));
        }
        return words;
    }

    /// Options must be those of slice, or combine, that records hold. What they name are the inputs from `file` on.
    void add_options(std::size_t file, std::vector<std::string>& words) {
        CLI::App slice_command;
        SliceArguments arguments;
        Combination combination;
        if (record_.command == "combine") {
            declare_combination(slice_command, combination);
        }
        declare(slice_command, arguments);
        for (std::size_t i = 0; i < record_.options.size(); ++i) {
            std::string name = record_.options[i];
            const CLI::Option* const option = name.starts_with("--") ? slice_command.get_option_no_throw(name) : nullptr;
            refuse_if(option == nullptr || !is_recorded(name), bad_input, "'" + name + "' is no option that a record holds");
            if (!is_flag(*option)) {
                refuse_if(++i == record_.options.size(), bad_input, "its option " + name + " has no value");
                std::string value = record_.options[i];
                if (RecordedOption{name, value}.names_file() && file < record_.inputs.size()) {
                    value = link(file++);
                }
                name += "=" + value;
            }
            words.push_back(std::move(name));
        }
    }

    void compare_records(const Record& again) {
        const auto compare = [&](const std::string& what, bool same) {
            if (!same) {
                found_.push_back("the " + what + " in its record is not that of its layers");
            }
        };
        const std::vector<std::string>& hashes = record_.result_hashes;
        for (std::size_t i = 0; i < hashes.size(); ++i) {
            compare("hash of mesh " + std::to_string(i + 1),
                    i < again.result_hashes.size() && again.result_hashes[i] == hashes[i]);
        }
        compare("patient frame", record_.patient_frame == again.patient_frame);
        compare("grid", record_.grid_mm == again.grid_mm);
        compare("fill rule", record_.fill_rule == again.fill_rule);
        compare("length of gaps", record_.stitch_mm.empty() || record_.stitch_mm == again.stitch_mm);
    }

    void compare_files(const fs::path& output) {
        const auto digest = [this](const fs::path& file) { return done_or_thrown(seal_file(file, context_)).sha256; };
        for (const auto& entry : fs::directory_iterator(top_ / "out")) {
            const fs::path name = entry.path().filename();
            const bool is_output = name == path_of(record_.output.path);
            const fs::path other = is_output ? output : output.parent_path() / name;
            const std::string beside = "'" + name.string() + "' beside it ";
            std::error_code unknown;
            if (name == path_of(record_.output.path + std::string(record_end))) {
                continue;
            }
            if (!fs::exists(other, unknown)) {
                found_.push_back(beside + "is missing");
            } else if (digest(entry.path()) != digest(other)) {
                found_.push_back(is_output ? "made again it has other bytes" : beside + "differs");
            }
        }
    }

    Record record_;
    const std::vector<fs::path>& actual_;  ///< inputs, in the order of the record
    const Context& context_;
    std::size_t parts_ = 0;  ///< inputs that the output was made of
    fs::path top_;
    fs::path inputs_;
    std::map<fs::path, fs::path> linked_;  ///< what each link in it leads to
    std::vector<std::string> found_;
};

class VerifyCommand {
public:
    VerifyCommand(const VerifyArguments& arguments, Interrupt& interrupt)
        : arguments_(arguments), context_{.threads = arguments.threads, .stop = interrupt.defer()} {}

    void run() {
        for (const std::string& given : arguments_.given) {
            std::error_code unknown;
            if (fs::is_directory(path_of(given), unknown)) {
                verify_folder(given);
            } else if (given.ends_with(record_end)) {
                verify_record(given);
            } else {
                verify_output(path_of(given), path_of(given + std::string(record_end)));
            }
        }
        refuse_if(differing_ > 0, some_failed,
                  of_all(differing_) + (differing_ == 1 ? " differs" : " differ") +
                      (unread_ > 0 ? ", " + of_all(unread_) + " not verified" : ""));
        refuse_if(unread_ > 0, bad_input, of_all(unread_) + " not verified");
    }

private:
    std::string of_all(std::size_t count) const { return std::to_string(count) + " of " + counted(all_, "output"); }

    void say(const fs::path& name, const std::string& words) {
        ++all_;
        print(printable(name.string() + ": " + words) + "\n");
    }

    void say_unread(const fs::path& name, const std::string& reason) {
        ++unread_;
        say(name, "not verified: " + reason);
    }

    /// `output` lies beside its record, `record_path`.
    void verify_output(const fs::path& output, const fs::path& record_path) {
        try {
            const Record record = done_or_thrown(read_record(record_path));
            const fs::path name = path_of(record.output.path);
            refuse_if(name.empty() || name.filename() != name || name == "." || name == "..", bad_input,
                      "its record names the output '" + name.string() + "'");
            const std::vector<std::string> found = differences(record, output, record_path);
            if (found.empty()) {
                return say(output, remakes() ? "as recorded, and so are its inputs; equal when made again" : "as recorded");
            }
            ++differing_;
            say(output, "differs: " + joined(found, "; ") +
                            when(record.version != version,
                                 " (it was made by lamella " + record.version + ", this is " + version + ")"));
        } catch (const Failure& failure) {
            if (context_.stop()) {
                throw;
            }
            say_unread(output, failure.what());
        } catch (const fs::filesystem_error& error) {
            say_unread(output, error.code().message());
        }
    }

    /// The output that the record names, or if that is not there the one that has the record's name.
    void verify_record(const std::string& path) {
        const fs::path by_name = path_of(path.substr(0, path.size() - record_end.size()));
        const Result<Record> record = read_record(path_of(path));
        std::error_code unknown;
        const fs::path named = record ? by_name.parent_path() / path_of(record->output.path) : by_name;
        const bool renamed = fs::exists(by_name, unknown) || !fs::exists(named, unknown);
        verify_output(renamed ? by_name : named, path_of(path));
    }

    void verify_folder(const std::string& folder) {
        if (!can_list(path_of(folder))) {
            return say_unread(path_of(folder), system_message(ENAMETOOLONG));
        }
        std::vector<std::string> records;
        std::error_code problem;
        const auto options = fs::directory_options::skip_permission_denied;
        for (fs::recursive_directory_iterator at(path_of(folder), options, problem), end; !problem && at != end;
             at.increment(problem)) {
            if (!can_list(at->path())) {
                at.disable_recursion_pending();
            }
            if (at->path().string().ends_with(record_end) && !at->is_directory(problem)) {
                records.push_back(at->path().string());
            }
        }
        if (problem || records.empty()) {
            say_unread(path_of(folder), problem ? problem.message() : "no records in the folder");
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
        const auto named = std::find(record.options.begin(), record.options.end(), "--series");
        const ImageOptions series{record.options.end() - named > 1 ? named[1] : std::string()};
        const std::size_t before = found.size();
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const std::string what = difference(record.inputs[i], done_or_thrown(seal_file(inputs[i], context_, series)));
            if (!what.empty()) {
                found.push_back("the input '" + inputs[i].string() + "': " + what);
            }
        }
        if (found.size() == before) {
            if (record.version != version && has_archives() && output.extension() == ".h5") {
                (void)done_or_thrown(read_archive(output, context_));  // An archive of another form says so.
            }
            const std::vector<std::string> more = Remaking(record, inputs, context_).differences(output);
            found.insert(found.end(), more.begin(), more.end());
        }
        return found;
    }

    /// The meshes given in place of those in the record; else each where its path leads from here or from the record.
    std::vector<fs::path> inputs_of(const Record& record, const fs::path& record_path) const {
        const std::size_t parts = count_of_parts(record);
        const bool of_meshes = record.command == "slice";
        refuse_if(!arguments_.meshes.empty() && arguments_.meshes.size() != parts, bad_input,
                  "it was made of " + (of_meshes ? counted(parts, "mesh", "meshes") : counted(parts, "archive")) +
                      ", and --mesh gives " + std::to_string(arguments_.meshes.size()));
        std::vector<fs::path> inputs;
        for (std::size_t i = 0; i < record.inputs.size(); ++i) {
            if (i < parts && !arguments_.meshes.empty()) {
                inputs.push_back(fs::absolute(path_of(arguments_.meshes[i])));
                continue;
            }
            const fs::path path = path_of(record.inputs[i].path);
            refuse_if(is_standard(record.inputs[i].path), bad_input,
                      "its mesh came from standard input: give it with --mesh");
            std::error_code unknown;
            const fs::path beside = record_path.parent_path() / path;
            inputs.push_back(fs::absolute(fs::exists(path, unknown) || !fs::exists(beside, unknown) ? path : beside));
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
