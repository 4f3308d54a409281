// lamella make: a sample mesh of any size.
#include <memory>
#include <optional>
#include <string>

#include "commands.hpp"
#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "models/models.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

struct MakeArguments {
    std::string shape;
    std::string order = "z";
    std::string output;
    models::Recipe recipe;
};

std::string shape_list() {
    std::string text;
    for (const std::string_view name : models::shape_names) {
        text += (text.empty() ? "" : "|") + std::string(name);
    }
    return text;
}

void run(MakeArguments& arguments, Interrupt& interrupt) {
    const std::optional<models::Shape> shape = models::shape_from_name(arguments.shape);
    if (!shape) {
        throw Failure(bad_usage, "make: '" + arguments.shape + "' is not one of " + shape_list());
    }
    if (arguments.order != "z" && arguments.order != "random") {
        throw Failure(bad_usage, "--order: '" + arguments.order + "' is not one of z|random");
    }
    require_writable(arguments.output);
    require_extension(arguments.output, "--output", ".stl");
    interrupt.tidy({arguments.output});
    arguments.recipe.shape = *shape;
    arguments.recipe.order = arguments.order == "z" ? models::Order::z : models::Order::random;
    const Stopwatch watch;
    const Result<std::uint64_t> triangles =
        models::write_stl(arguments.recipe, output_path(arguments.output), interrupt.defer());
    if (!triangles) {
        throw failure_of(triangles.error());
    }
    print_words(output_name(arguments.output) + ": " + arguments.shape + ", " + counted(triangles.value(), "triangle") +
                    ", " + rounded(watch.ms() / 1000, 2) + " s\n",
                is_standard(arguments.output));
}

}  // namespace

void add_make_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("make", "Make a closed sample mesh");
    const auto arguments = std::make_shared<MakeArguments>();
    models::Recipe& recipe = arguments->recipe;
    command->add_option("shape", arguments->shape, "Shape to make")
        ->required()
        ->type_name(shape_list())
        ->transform(lower_case);
    command->add_option("--triangles", recipe.triangles, "Number of triangles, within 1 % (1000000)")->type_name("N");
    command->add_option("--height", recipe.height_mm, "Height, along z (150)")->type_name("MM");
    command->add_option("--width", recipe.width_mm, "Width, along x (by the shape's proportions)")->type_name("MM");
    CLI::Option* const segments =
        command->add_option("--segments", recipe.segments, "Number of segments wanted at --layer-height")->type_name("M");
    CLI::Option* const layer_height =
        command->add_option("--layer-height", recipe.layer_height_mm, "Layer height that --segments counts at (0.032)")
            ->type_name("MM");
    layer_height->needs(segments);
    command->add_option("--order", arguments->order, "Order of the triangles in the file (z)")
        ->type_name("z|random")
        ->transform(lower_case);
    command->add_option("--seed", recipe.seed, "Seed of the shape and of the random order (1)")->type_name("N");
    command->add_option("-o,--output", arguments->output, "Binary STL file to write; - for standard output")
        ->required()
        ->type_name("FILE.stl|-")
        ->check(given_path);
    command->callback([arguments, &interrupt] { run(*arguments, interrupt); });
}

}  // namespace lamella::cli
