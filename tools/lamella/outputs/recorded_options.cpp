#include "outputs/recorded_options.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

/// Whether the option may stand beside this output alone, and says something of it.
bool concerns(const std::string& name, const PlannedOutput& output) {
    if (name == "--holes" || name == "--without-ct") {
        return output.format == OutputFormat::structure_set;
    }
    return (name != "--coverage" || output.is_mask()) && (name != "--picture-layer" || output.format == OutputFormat::png);
}

}  // namespace

bool is_recorded(const std::string& name) {
    static constexpr std::array<std::string_view, 13> without_effect = {"",  // hidden options have no name
                                                                        "mesh",  "archives",  "parts",      "--output",
                                                                        "--to",  "--threads", "--progress", "--report",
                                                                        "--map", "--band",    "--form",     "--help"};
    return std::find(without_effect.begin(), without_effect.end(), name) == without_effect.end();
}

bool is_flag(const CLI::Option& option) {
    return option.get_items_expected_max() == 0;
}

bool RecordedOption::names_file() const {
    return name == "--like" || name == "--transform" || (name == "--planes" && !parse_list(value.value_or("")));
}

std::vector<RecordedOption> recorded_options(const CLI::App& slice_command) {
    std::vector<RecordedOption> options;
    for (const CLI::Option* option : slice_command.get_options()) {
        const std::string name = option->get_name();
        if (option->count() == 0) {
            for (const ChangedDefault& changed : changed_defaults) {
                if (name == changed.name) {
                    options.push_back({name, std::string(changed.now)});
                }
            }
            continue;
        }
        if (!is_recorded(name)) {
            continue;
        }
        if (is_flag(*option)) {
            options.push_back({name, std::nullopt});
            continue;
        }
        for (const std::string& value : option->results()) {
            options.push_back({name, value});
        }
    }
    return options;
}

std::vector<std::string> record_words(const std::vector<RecordedOption>& options, const PlannedOutput& output) {
    std::vector<std::string> words;
    for (const RecordedOption& option : options) {
        if (concerns(option.name, output)) {
            words.push_back(option.name);
            if (option.value) {
                words.push_back(*option.value);
            }
        }
    }
    return words;
}

}  // namespace lamella::cli
