#include "files/flags.hpp"
#include "slice/slice.hpp"

namespace lamella::cli {

namespace {

AdaptiveOptions& adaptive_of(SliceArguments& arguments) {
    return arguments.adaptive ? *arguments.adaptive : arguments.adaptive.emplace();
}

/// "FROM,TO,MM", each.
void take_ranges(const std::vector<std::string>& all, SliceArguments& arguments) {
    adaptive_of(arguments);
    arguments.height_ranges.clear();
    for (const std::string& text : all) {
        const std::vector<double> range = parse_numbers(text, ',').value_or(std::vector<double>());
        if (range.size() != 3) {
            throw CLI::ValidationError("--height-range", "'" + text + "' is not FROM,TO,MM, such as 0,0.3,0.2");
        }
        arguments.height_ranges.push_back({range[0], range[1], range[2]});
    }
}

}  // namespace

void declare_adaptive(CLI::App& command, SliceArguments& arguments) {
    constexpr const char* group = "Adaptive heights";
    const auto add_length = [&](const char* flag, double AdaptiveOptions::*length, const std::string& help) {
        add_number(command, flag, "MM", help, [&arguments, length](double mm) {
            adaptive_of(arguments).*length = mm;
        })->group(group);
    };
    add_length("--cusp", &AdaptiveOptions::cusp_mm,
               "Layers so high that the corners of steps stand at most MM off the surface");
    add_length("--deviation", &AdaptiveOptions::deviation_mm, "Layers so high that the surface deviates by at most MM");
    add_length("--slope-limit", &AdaptiveOptions::slope_limit_mm, "Layers so high that steps are at most MM wide");
    add_range(command, "--heights", "Heights of adaptive layers (0.05:0.3)", [&arguments](double least, double most) {
        adaptive_of(arguments).least_mm = least;
        adaptive_of(arguments).most_mm = most;
    })->group(group);
    add_length("--height-step", &AdaptiveOptions::step_mm, "Heights of adaptive layers are multiples of MM (0.005)");
    add_length("--height-change", &AdaptiveOptions::most_change_mm,
               "The height of a layer differs from that of the one below by at most MM (any)");
    add_length("--height-smoothing", &AdaptiveOptions::smoothing_mm,
               "The height that the surface allows is at most its mean over MM below and above (off)");
    const auto ranges = [&arguments](const std::vector<std::string>& all) { take_ranges(all, arguments); };
    add_repeatable(command, "--height-range", "FROM,TO,MM",
                   "Layers that begin FROM to TO above the mesh's lowest vertex are MM high; repeatable", ranges)
        ->group(group);
    for (const char* const planes : {"--layer-height", "--planes", "--random-heights", "--first-height", "--datum", "--like",
                                     "--spacing", "--memory"}) {
        for (const CLI::Option* const option :
             command.get_options([](const CLI::Option* one) { return one->get_group() == "Adaptive heights"; })) {
            command.get_option(planes)->excludes(command.get_option(option->get_name()));
        }
    }
}

}  // namespace lamella::cli
