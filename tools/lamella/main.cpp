// The command line tool. Exit status: 0 done, 2 usage, 3 input that cannot be used, 4 output that cannot be written, 5
// some items of a batch failed, or outputs differ from their records.
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "files/flags.hpp"
#include "lamella/version.hpp"
#include "system/terminal.hpp"
#include "terminal/console.hpp"
#include "terminal/manual.hpp"

namespace lamella::cli {

namespace {

/// One line that says how to type it right next time.
std::string usage_line(const CLI::App& app, const CLI::ParseError& error) {
    std::string command = "lamella";
    for (const CLI::App* chosen : app.get_subcommands()) {
        command += " " + chosen->get_name();
    }
    const std::vector<std::string> unknown = app.remaining(true);
    const std::string first = unknown.empty() ? "" : unknown.front();
    const std::string_view today = name_of_today(first.substr(0, first.find('=')));
    const bool no_command = app.get_subcommands().empty() && !unknown.empty();
    return (no_command       ? "'" + first + "' is not a command"
            : !today.empty() ? first + ": is called " + std::string(today) + " now"
                             : std::string(error.what())) +
           " (see " + command + " --help)";
}

/// Throws Failure.
int run(const std::vector<std::string>& words) {
    static Interrupt& interrupt = *new Interrupt;
    CLI::App app("Slices triangle meshes into closed, oriented, nested contours", "lamella");
    app.allow_windows_style_options(false);  // "/a" is a path
    app.set_version_flag("--version", lamella::version);
    // Thrown as --help is, by which a command is not required.
    const auto print_instead = [](const std::string& text) { throw CLI::CallForVersion(text, 0); };
    app.add_flag_callback(
        "--man", [&] { print_instead(manual_of(app)); }, "Print the manual page, for man(1)");
    app.add_flag_callback(
        "--completion", [&] { print_instead(bash_completion_of(app)); }, "Print completion for bash");
    app.require_subcommand(1);
    for (const auto add : {add_slice_command, add_info_command, add_check_command, add_make_command, add_verify_command,
                           add_batch_command, add_convert_command, add_combine_command, add_merge_command,
                           add_tracks_command, add_screens_command, add_view_command}) {
        add(app, interrupt);
    }
    // The last word comes first. To CLI11 "[a,b]" is a list of a and b where several words are taken; a path it becomes as
    // "./[a,b]".
    std::vector<std::string> reversed(words.rbegin(), words.rend());
    for (std::string& word : reversed) {
        if (word.starts_with('[') && word.ends_with(']')) {
            word.insert(0, "./");
        }
    }
    try {
        app.parse(reversed);
        return done;
    } catch (const CLI::Success& asked) {  // --help, --version and the like
        return app.exit(asked);
    } catch (const CLI::ParseError& error) {
        complain(usage_line(app, error));
        return bad_usage;
    } catch (const Failure&) {
        interrupt.die_if_interrupted();
        throw;
    }
}

constexpr std::string_view out_of_memory = "out of memory";

/// Where there is no memory at all the runtime has none to throw with either, and would abort.
[[noreturn]] void end_without_memory() noexcept {
    for (const std::string_view part : {std::string_view("lamella: "), out_of_memory, std::string_view("\n")}) {
        write_error(part);
    }
    std::_Exit(bad_input);
}

/// Ahead of the constructors of static objects, the first to allocate.
[[gnu::constructor(101)]] void expect_no_memory() noexcept {
    std::set_new_handler(end_without_memory);
}

int run_tool(int count, char** words) {
    try {
        return run(begin_program(count, words));
    } catch (const Failure& failure) {
        complain(failure.what());
        return failure.status();
    } catch (const std::bad_alloc&) {
        complain(out_of_memory);
        return bad_input;
    } catch (const std::exception& unforeseen) {
        complain(unforeseen.what());
        return bad_input;
    }
}

}  // namespace

}  // namespace lamella::cli

int main(int count, char** words) {
    std::set_new_handler(nullptr);
    return lamella::cli::run_tool(count, words);
}
