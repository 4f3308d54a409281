// The commands, and flags of all of them: how values are checked and stored, and the options of a slice as flags. These are
// declared, parsed and checked by engine/options/options.inc, a line each.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "io/text/text.hpp"
#include "lamella/options.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

// The subcommands. Each adds itself to the application and runs when it was the one chosen; all throw Failure.
void add_slice_command(CLI::App& app, Interrupt& interrupt);
void add_info_command(CLI::App& app, Interrupt& interrupt);
void add_check_command(CLI::App& app, Interrupt& interrupt);
void add_make_command(CLI::App& app, Interrupt& interrupt);
void add_convert_command(CLI::App& app, Interrupt& interrupt);
void add_combine_command(CLI::App& app, Interrupt& interrupt);
void add_tracks_command(CLI::App& app, Interrupt& interrupt);
void add_merge_command(CLI::App& app, Interrupt& interrupt);
void add_verify_command(CLI::App& app, Interrupt& interrupt);
void add_batch_command(CLI::App& app, Interrupt& interrupt);
void add_screens_command(CLI::App& app, Interrupt& interrupt);
void add_view_command(CLI::App& app, Interrupt& interrupt);

/// A check for options whose value may not be empty: what is wrong with it, if anything.
std::string given(const std::string& text);

/// An option with a value, which `type` names in the help.
template <class T>
CLI::Option* add(CLI::App& command, const std::string& flag, T& value, const std::string& type, const std::string& help) {
    return command.add_option(flag, value, help)->type_name(type);
}

/// The same of text, which may not be empty; of a list the flag is repeated.
template <class T>
CLI::Option* add_text(CLI::App& command, const std::string& flag, T& value, const std::string& type,
                      const std::string& help) {
    CLI::Option* const option = add(command, flag, value, type, help)->check(given);
    return flag.starts_with('-') && option->get_items_expected_max() > 1 ? option->take_all()->allow_extra_args(false)
                                                                         : option;
}

/// A transform of words of a list: records hold them as they are listed.
inline std::string in_lower_case(const std::string& word) {
    return lower_case(word);
}

/// An option whose value `take` stores, or says what is wrong with it.
CLI::Option* add_parsed(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                        std::function<std::string(const std::string&)> take);

/// An option that takes a number that is at least 0, of mm where the type is "MM".
CLI::Option* add_number(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                        std::function<void(double)> take);

/// An option that takes a number of bytes from 1 on: "1500000", "200K", "2GB", "1TiB", all of powers of 1024.
CLI::Option* add_bytes(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                       std::uint64_t& bytes);

/// An option that takes three numbers with commas between; of the text follows what `take` says is wrong with it.
CLI::Option* add_triple(CLI::App& command, const std::string& flag, const std::string& help,
                        std::function<std::string(const std::array<double, 3>&)> take);

/// An option that takes MIN:MAX, in mm with 0 < MIN <= MAX.
CLI::Option* add_range(CLI::App& command, const std::string& flag, const std::string& help,
                       std::function<void(double, double)> take);

/// An option of which `take` gets all values.
CLI::Option* add_repeatable(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                            const std::function<void(const std::vector<std::string>&)>& take);

/// An option that takes a whole number from 0 on.
CLI::Option* add_count(CLI::App& command, const std::string& flag, const std::string& help,
                       std::function<void(std::uint64_t)> take);

/// An option that takes one of some words, in any case; `take` stores its index.
CLI::Option* add_choice(CLI::App& command, const std::string& flag, std::span<const std::string_view> words,
                        const std::string& help, std::function<void(std::size_t)> take);

/// The same of an enumeration whose values follow the words.
template <class Enum>
CLI::Option* add_choice(CLI::App& command, const std::string& flag, std::span<const std::string_view> words,
                        const std::string& help, Enum& value) {
    return add_choice(command, flag, words, help, [&value](std::size_t i) { value = static_cast<Enum>(i); });
}

/// Declares the flags of a slice's options, or `only` that one, which set `options`. Those that `command` has already are
/// left out. A file that heights or a matrix are in is read when the command line is parsed, which throws Failure.
void declare_options(CLI::App& command, SliceOptions& options, std::string_view only = {});

/// With the defaults of the tool.
SliceOptions tool_options();
/// The tool's fill rule, where contours are asked for.
void make_region(SliceOptions& options);

/// An option of slice whose default is not what it was. Records and results of a batch state it always: where one does not,
/// an older version made it, by the older default.
struct ChangedDefault {
    std::string_view name;
    std::string_view now;
    std::string_view before;
};
extern const std::array<ChangedDefault, 2> changed_defaults;

/// Renames the options, and values, of slice that an earlier version recorded by other names.
void put_in_words_of_today(std::vector<std::string>& words);

/// The name of a flag of slice that an earlier version called so; empty if none did.
std::string_view name_of_today(std::string_view flag);

/// True if the value of that flag is the path of a file with the option's value.
bool is_file_of(std::string_view flag, const std::string& value);

}  // namespace lamella::cli
