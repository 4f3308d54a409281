// lamella make: a sample mesh of any size.
#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "commands.hpp"
#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "models/models.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

struct MakeArguments {
    std::string output;
    models::Recipe recipe;
};

void run(const MakeArguments& arguments, Interrupt& interrupt) {
    require_writable(arguments.output);
    require_extension(arguments.output, "--output", ".stl");
    interrupt.tidy({arguments.output});
    const Stopwatch watch;
    const Result<std::uint64_t> triangles =
        models::write_stl(arguments.recipe, output_path(arguments.output), interrupt.defer());
    if (!triangles) {
        throw failure_of(triangles.error());
    }
    print_words(output_name(arguments.output) + ": " +
                    std::string(models::shape_names[static_cast<std::size_t>(arguments.recipe.shape)]) + ", " +
                    counted(triangles.value(), "triangle") + ", " + rounded(watch.ms() / 1000, 2) + " s\n",
                is_standard(arguments.output));
}

}  // namespace

void add_make_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("make", "Make a closed sample mesh");
    const auto arguments = std::make_shared<MakeArguments>();
    models::Recipe& recipe = arguments->recipe;
    static constexpr std::array<std::string_view, 2> orders = {"z", "random"};
    add_choice(*command, "shape", models::shape_names, "Shape to make", recipe.shape)->required();
    add(*command, "--triangles", recipe.triangles, "N", "Number of triangles, within 1 % (1000000)");
    add(*command, "--height", recipe.height_mm, "MM", "Height, along z (150)");
    add(*command, "--width", recipe.width_mm, "MM", "Width, along x (by the shape's proportions)");
    add(*command, "--segments", recipe.segments, "M", "Number of segments wanted at --layer-height");
    add(*command, "--layer-height", recipe.layer_height_mm, "MM", "Layer height that --segments counts at (0.032)")
        ->needs("--segments");
    add_choice(*command, "--order", orders, "Order of the triangles in the file (z)", recipe.order);
    add_count(*command, "--seed", "Seed of the shape and of the random order (1)",
              [&recipe](std::uint64_t seed) { recipe.seed = seed; });
    add_text(*command, "-o,--output", arguments->output, "FILE.stl|-", "Binary STL file to write; - for standard output")
        ->required();
    command->callback([arguments, &interrupt] { run(*arguments, interrupt); });
}

}  // namespace lamella::cli
