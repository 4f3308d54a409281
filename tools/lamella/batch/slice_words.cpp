#include "batch/plan.hpp"

#include <algorithm>

#include "outputs/output_checks.hpp"
#include "outputs/output_formats.hpp"
#include "outputs/recorded_options.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

/// Not for items: the batch has its own, or gives them to its processes.
bool is_for_batch(const std::string& name) {
    static const std::vector<std::string> kept = {"mesh", "--help", "--progress", "--memory", "--hash"};
    return std::find(kept.begin(), kept.end(), name) != kept.end();
}

}  // namespace

SliceWords::SliceWords() {
    SliceArguments arguments;
    declare(prototype_, arguments);  // Nothing is ever parsed by it: what it refers to may go.
}

std::string SliceWords::name_of(const std::string& text) const {
    std::string name = text.substr(std::min(text.find_first_not_of('-'), text.size()));
    std::replace(name.begin(), name.end(), '_', '-');
    const CLI::Option* const found =
        name.empty() ? nullptr : prototype_.get_option_no_throw((name.size() == 1 ? "-" : "--") + name);
    return found == nullptr || is_for_batch(found->get_name()) ? std::string() : found->get_name();
}

std::vector<std::string> SliceWords::names_without_memory() const {
    std::vector<std::string> names;
    for (const CLI::Option* excluded : option("--memory").get_excludes()) {
        names.push_back(excluded->get_name());
    }
    names.emplace_back("--report");
    return names;
}

OptionValues SliceWords::typed(const CLI::App& command) const {
    OptionValues values;
    for (const CLI::Option* given : command.get_options()) {
        const std::string name = given->get_name();
        if (given->count() > 0 && prototype_.get_option_no_throw(name) != nullptr && !is_for_batch(name)) {
            values[name] = is_flag(*given) ? std::vector<std::string>{"true"} : given->results();
        }
    }
    return values;
}

std::vector<std::string> SliceWords::words(const OptionValues& values) const {
    std::vector<std::string> words;
    for (const CLI::Option* known : prototype_.get_options()) {
        const std::string name = known->get_name();
        const auto found = values.find(name);
        if (found == values.end()) {
            continue;
        }
        for (const std::string& value : found->second) {
            words.push_back(is_flag(*known) ? name : name + "=" + value);
        }
    }
    return words;
}

void SliceWords::require_accepted(const OptionValues& values) const {
    CLI::App app;
    SliceArguments arguments;
    declare(app, arguments);
    std::vector<std::string> typed = words(values);
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
