#include "slice/slice.hpp"

#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "files/flags.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

/// The heading in the help of what neither prints nor pictures need.
constexpr const char* experiments = "Experiments";

void declare_mending(CLI::App& command, SliceArguments& arguments) {
    add_number(command, "--weld", "MM", "Join vertices at most MM apart before slicing (off)",
               [&arguments](double mm) { arguments.weld_mm = mm; });
    command.add_flag("--orient-shells", arguments.orient_shells,
                     "Turn each closed shell outwards, or inwards where it bounds a cavity, before slicing");
    add_parsed(command, "--normal", "X,Y,Z", "Cut perpendicular to this direction", [&arguments](const std::string& text) {
        const std::array<double, 3> normal = parse_triple(text, "--normal");
        const double length = std::hypot(normal[0], normal[1], normal[2]);
        if (!(length > 0 && std::isfinite(length))) {
            return "'" + text + "' has no direction";
        }
        arguments.options.frame.transform = Transform::from_normal(normal[0], normal[1], normal[2]);
        return std::string();
    })->check(given);
}

void declare_experiments(CLI::App& command, SliceArguments& arguments) {
    static constexpr std::array<std::string_view, 2> forms = {"swept", "assembled"};
    Tuning& tuning = arguments.tuning;
    const auto random_heights = [&tuning]() -> RandomHeights& {
        return tuning.random_heights ? *tuning.random_heights : tuning.random_heights.emplace();
    };
    const auto random = [random_heights](const std::string& text) {
        const std::size_t colon = std::min(text.find(':'), text.size());
        const std::optional<double> least = parse_number(text.substr(0, colon));
        const std::optional<double> most = parse_number(text.substr(std::min(colon + 1, text.size())));
        RandomHeights& heights = random_heights();
        heights.min_step_mm = least.value_or(0);
        heights.max_step_mm = most.value_or(0);
        return heights.min_step_mm > 0 && heights.max_step_mm >= heights.min_step_mm
                   ? ""
                   : "'" + text + "' is not MIN:MAX in mm with 0 < MIN <= MAX";
    };
    add_parsed(command, "--random-heights", "MIN:MAX", "Random steps between MIN and MAX mm", random)
        ->check(given)
        ->group(experiments);
    add_count(command, "--seed", "Seed of the random heights (1)",
              [random_heights](std::uint64_t seed) { random_heights().seed = seed; })
        ->needs("--random-heights")
        ->group(experiments);
    add(command, "--band", tuning.band_planes, "N", "Planes swept as one task (0: chosen by the work)")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()))
        ->group(experiments);
    add_choice(command, "--form", forms, "How contours are built (swept); the results are identical", tuning.form)
        ->group(experiments);
}

void declare_how(CLI::App& command, SliceArguments& arguments) {
    static constexpr std::array<std::string_view, 1> objects = {"objects"};
    command.add_flag("--map", arguments.map_file, "Map the mesh file into memory instead of reading it");
    add_bytes(command, "--memory", "BYTES[k|M|G]",
              "Slice a binary STL or PLY file larger than memory, in ranges of layers within so many bytes (at least 300k a "
              "thread)",
              arguments.memory_bytes);
    add_choice(command, "--split", objects,
               "Make each 3MF object, OBJ object or group, or STL solid a mesh with its own label, ROI and row",
               [&arguments](std::size_t) { arguments.split = true; });
    command.add_flag("--hash", arguments.hash, "Print the hash of the result");
    add_text(command, "--report", arguments.report, "FILE|-", "JSON report to write; - for standard output");
}

}  // namespace

void declare(CLI::App& command, SliceArguments& arguments) {
    add_text(command, "mesh", arguments.meshes, "MESH|-", mesh_help("Mesh files, or - for standard input"))->required();
    declare_reading(command, arguments);
    declare_outputs(command, arguments.outputs);
    declare_image(command, arguments.image);
    declare_options(command, arguments.options);
    declare_mending(command, arguments);
    declare_experiments(command, arguments);
    declare_how(command, arguments);
    const auto exclude = [&command](const char* one, std::initializer_list<const char*> others) {
        for (const char* const other : others) {
            command.get_option(one)->excludes(command.get_option(other));
        }
    };
    exclude("--layer-height", {"--planes", "--random-heights"});
    exclude("--planes", {"--random-heights", "--first-height", "--datum"});
    exclude("--random-heights", {"--first-height", "--datum"});
    exclude("--normal", {"--transform"});
    exclude("--memory", {"--weld", "--orient-shells", "--map", "--split"});
    for (const char* const image : {"--like", "--spacing"}) {
        exclude(image,
                {"--layer-height", "--planes", "--random-heights", "--first-height", "--datum", "--normal", "--transform"});
    }
}

}  // namespace lamella::cli
