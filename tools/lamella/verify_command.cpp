// lamella verify: whether outputs are what their records say.
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "lamella/medical/record.hpp"
#include "lamella/version.hpp"
#include "made_again.hpp"
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

std::string joined(const std::vector<std::string>& lines) {
    std::string all;
    for (const std::string& line : lines) {
        all.append(all.empty() ? "" : "; ").append(line);
    }
    return all;
}

FileSeal sealed(const fs::path& path, const Context& context) {
    Result<FileSeal> seal = seal_file(path, context);
    return seal ? std::move(seal).value() : throw Failure(bad_input, seal.error().message);
}

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
    Result<Record> record = read_record(path);
    if (!record) {
        throw Failure(bad_input, record.error().message);
    }
    const fs::path name(record->output.path);
    refuse_if(name.empty() || name.filename() != name || name == "." || name == "..", bad_input,
              "its record names the output '" + name.string() + "'");
    return std::move(record).value();
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
            say(output, "differs: " + joined(found) + other_version(record));
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
        if (std::string own = difference(record.output, sealed(output, context_)); !own.empty()) {
            found.push_back(std::move(own));
        }
        if (!remakes()) {
            return found;
        }
        const std::vector<fs::path> inputs = inputs_of(record, record_path);
        const std::size_t before = found.size();
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const std::string what = difference(record.inputs[i], sealed(inputs[i], context_));
            if (!what.empty()) {
                found.push_back("the input '" + inputs[i].string() + "': " + what);
            }
        }
        if (found.size() == before) {
            const std::vector<std::string> more = verify::differences_from_remade(record, output, inputs, context_);
            found.insert(found.end(), more.begin(), more.end());
        }
        return found;
    }

    static std::string other_version(const Record& record) {
        return record.version == version ? "" : " (it was made by lamella " + record.version + ", this is " + version + ")";
    }

    /// The meshes given in place of those in the record; else each where its path leads from here or from the record.
    std::vector<fs::path> inputs_of(const Record& record, const fs::path& record_path) const {
        const std::size_t parts = verify::count_of_parts(record);
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
