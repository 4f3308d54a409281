#include "terminal/manual.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "lamella/version.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

/// Those that people see; positional ones first.
std::vector<const CLI::Option*> options_of(const CLI::App& command) {
    std::vector<const CLI::Option*> all = command.get_options();
    std::erase_if(all, [](const CLI::Option* option) { return option->get_group().empty(); });
    std::stable_partition(all.begin(), all.end(), [](const CLI::Option* option) { return option->get_positional(); });
    return all;
}

/// "MM|finest" of "MM|finest:FLOAT in [0 - 1]".
std::string_view type_of(const std::string& name) {
    return std::string_view(name).substr(0, name.find(':'));
}

/// Text in which man(7) sees no commands.
std::string plain(std::string_view text) {
    std::string all = !text.empty() && (text.front() == '.' || text.front() == '\'') ? "\\&" : "";
    for (const char c : text) {
        all += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
    }
    return all;
}

/// ".TP", the option in bold with its value in italics, and its help.
std::string entry_of(const CLI::Option& option) {
    const std::string type_name = option.get_type_name();
    const std::string_view type = type_of(type_name);
    const std::string name = option.get_positional() ? "" : "\\fB" + plain(option.get_name(false, true)) + "\\fR";
    const std::string value = type.empty() ? "" : "\\fI" + plain(type) + "\\fR";
    return ".TP\n" + name + when(!name.empty() && !value.empty(), " ") + value + "\n" + plain(option.get_description()) +
           "\n";
}

/// The words among "auto|always|never" or "MM|finest" that are typed as they stand.
std::string words_of(const CLI::Option& option) {
    const std::string type_name = option.get_type_name();
    std::vector<std::string_view> words = split(type_of(type_name), '|');
    const auto is_word = [](std::string_view text) {
        return text.size() > 1 && std::all_of(text.begin(), text.end(),
                                              [](char c) { return (c >= 'a' && c <= 'z') || c == '-' || is_digit(c); });
    };
    words.erase(std::remove_if(words.begin(), words.end(), std::not_fn(is_word)), words.end());
    return joined(words, " ");
}

constexpr std::array<std::pair<int, std::string_view>, 5> exit_statuses = {{
    {done, "Done."},
    {bad_usage, "The command line is not understood, or its options do not go together."},
    {bad_input, "An input cannot be used."},
    {bad_output, "An output cannot be written."},
    {some_failed, "Some items of a batch failed, or outputs differ from their records."},
}};

}  // namespace

std::string manual_of(const CLI::App& app) {
    std::string page = ".TH LAMELLA 1 \"\" \"lamella " + std::string(version) + "\"\n.SH NAME\nlamella \\- " +
                       plain(app.get_description()) + "\n.SH SYNOPSIS\n.B lamella\n.I command\n[options] ...\n.SH OPTIONS\n";
    for (const CLI::Option* const option : options_of(app)) {
        page += entry_of(*option);
    }
    page += ".SH COMMANDS\n";
    for (const CLI::App* const command : app.get_subcommands({})) {
        page += ".SS lamella " + command->get_name() + "\n" + plain(command->get_description()) + ".\n";
        for (const CLI::Option* const option : options_of(*command)) {
            page += entry_of(*option);
        }
    }
    page += ".SH EXIT STATUS\n";
    for (const auto& [status, meaning] : exit_statuses) {
        page += ".TP\n" + std::to_string(status) + "\n" + plain(meaning) + "\n";
    }
    return page;
}

std::string bash_completion_of(const CLI::App& app) {
    std::string commands = "--help --version";
    std::string values;   // cases of "COMMAND:OPTION"
    std::string options;  // cases of "COMMAND"
    for (const CLI::App* const command : app.get_subcommands({})) {
        commands += " " + command->get_name();
        std::string names;
        for (const CLI::Option* const option : options_of(*command)) {
            if (option->get_positional()) {
                continue;
            }
            for (const std::string& name : option->get_lnames()) {
                names += " --" + name;
                if (const std::string words = words_of(*option); !words.empty()) {
                    values.append("        ").append(command->get_name()).append(":--").append(name);
                    values.append(") words='").append(words).append("' ;;\n");
                }
            }
        }
        options += "            " + command->get_name() + ") words='" + names.substr(1) + "' ;;\n";
    }
    return "# Completion of lamella in bash: source it, or `eval \"$(lamella --completion)\"`.\n"
           "_lamella() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words=\n"
           "    if ((COMP_CWORD == 1)); then\n"
           "        COMPREPLY=($(compgen -W '" +
           commands +
           "' -- \"$word\"))\n"
           "        return\n"
           "    fi\n"
           "    [[ $word != = ]] || word=  # bash takes --option=value apart\n"
           "    [[ $before != = ]] || before=${COMP_WORDS[COMP_CWORD - 2]}\n"
           "    case ${COMP_WORDS[1]}:$before in\n" +
           values +
           "    esac\n"
           "    if [[ -z $words && $word == -* ]]; then\n"
           "        case ${COMP_WORDS[1]} in\n" +
           options +
           "        esac\n"
           "    fi\n"
           "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
           "}\n"
           "complete -o default -F _lamella lamella\n";
}

}  // namespace lamella::cli
