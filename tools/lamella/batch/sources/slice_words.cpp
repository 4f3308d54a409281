#include "batch/sources/slice_words.hpp"

#include <algorithm>

#include "outputs/output_formats.hpp"
#include "outputs/write_outputs.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

/// Not for items: the batch has its own, or gives them to its processes.
bool is_for_batch(const std::string& name) {
    static const std::vector<std::string> kept = {"mesh", "--help", "--progress", "--memory", "--hash"};
    return std::find(kept.begin(), kept.end(), name) != kept.end();
}

bool takes_no_value(const CLI::Option& option) {
    return option.get_items_expected_max() == 0;
}

}  // namespace

const std::vector<std::string>& words_without_effect() {
    static const std::vector<std::string> words = {"--output", "--to", "--threads", "--report", "--map", "--band", "--form"};
    return words;
}

SliceWords::SliceWords() {
    SliceArguments arguments;
    declare(prototype_, arguments);  // Nothing is ever parsed by it: what it refers to may go.
}

const CLI::Option* SliceWords::option(const std::string& name) const {
    return prototype_.get_option_no_throw(name);
}

std::string SliceWords::name_of(const std::string& text) const {
    std::string name = text.substr(std::min(text.find_first_not_of('-'), text.size()));
    std::replace(name.begin(), name.end(), '_', '-');
    const CLI::Option* const found = name.empty() ? nullptr : option((name.size() == 1 ? "-" : "--") + name);
    return found == nullptr || is_for_batch(found->get_name()) ? std::string() : found->get_name();
}

bool SliceWords::is_flag(const std::string& name) const {
    return takes_no_value(*option(name));
}

bool SliceWords::takes_length(const std::string& name) const {
    const std::string type = option(name)->get_type_name();
    return type == "MM" || type == "MM|auto";
}

bool SliceWords::is_repeatable(const std::string& name) const {
    return option(name)->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
}

std::vector<std::string> SliceWords::names_without_memory() const {
    std::vector<std::string> names;
    for (const CLI::Option* excluded : option("--memory")->get_excludes()) {
        names.push_back(excluded->get_name());
    }
    names.emplace_back("--report");
    return names;
}

OptionValues SliceWords::typed(const CLI::App& command) const {
    OptionValues values;
    for (const CLI::Option* given : command.get_options()) {
        const std::string name = given->get_name();
        if (given->count() > 0 && option(name) != nullptr && !is_for_batch(name)) {
            values[name] = takes_no_value(*given) ? std::vector<std::string>{"true"} : given->results();
        }
    }
    return values;
}

std::vector<std::string> SliceWords::words(const OptionValues& values, const std::vector<std::string>& left_out) const {
    std::vector<std::string> words;
    for (const CLI::Option* known : prototype_.get_options()) {
        const std::string name = known->get_name();
        const auto found = values.find(name);
        if (found == values.end() || std::find(left_out.begin(), left_out.end(), name) != left_out.end()) {
            continue;
        }
        for (const std::string& value : found->second) {
            words.push_back(name);
            if (!takes_no_value(*known)) {
                words.back().append("=").append(value);
            }
        }
    }
    return words;
}

void SliceWords::require_accepted(const OptionValues& values) const {
    CLI::App app;
    SliceArguments arguments;
    declare(app, arguments);
    std::vector<std::string> typed = words(values, {});
    typed.emplace_back("mesh");
    std::reverse(typed.begin(), typed.end());
    try {
        app.parse(typed);
    } catch (const CLI::ParseError& error) {
        throw Failure(bad_usage, error.what());
    }
    (void)options_of(arguments);
    const OutputArguments& outputs = arguments.outputs;
    if (!outputs.outputs.empty()) {
        require_together(planned_outputs(outputs.outputs, outputs.to), outputs, arguments.mesh_count(),
                         arguments.image.given(), arguments.image.subslices);
    }
}

}  // namespace lamella::cli::batch
