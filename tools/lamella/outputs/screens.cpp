// Which screen pictures of layers are drawn for; and lamella screens, the printers that are known by name.
#include <algorithm>
#include <array>
#include <functional>
#include <memory>

#include "files/flags.hpp"
#include "lamella/io/screen.hpp"
#include "lamella/slice.hpp"
#include "outputs/outputs.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

std::vector<Printer> printers_called(const std::string& words) {
    std::vector<Printer> found(printers().begin(), printers().end());
    std::erase_if(found, [&](const Printer& printer) { return !is_called(printer, words); });
    return found;
}

/// Returns what is wrong with it.
std::string take_screen(const std::string& text, Screen& screen) {
    const std::string name = lower_case(text);
    const std::vector<std::string_view> sides = split(name, 'x');
    if (sides.size() == 2 && read_integer(sides[0], screen.width) && read_integer(sides[1], screen.height)) {
        return "";
    }
    std::vector<Printer> found = printers_called(name);
    // "saturn" is the Saturn, not the Saturn 2.
    const auto ends_so = [&](const Printer& printer) { return (" " + lower_case(printer.name)).ends_with(" " + name); };
    if (std::count_if(found.begin(), found.end(), ends_so) == 1) {
        std::erase_if(found, std::not_fn(ends_so));
    }
    std::string names;
    for (const Printer& printer : found) {
        names.append(names.empty() ? "' could be " : ", ").append(printer.name);
        screen = printer.screen;
    }
    return found.size() == 1 ? ""
                             : "'" + text + (names.empty() ? "' is neither a printer (see lamella screens) nor WxH" : names);
}

}  // namespace

void declare_screen(CLI::App& command, ScreenArguments& arguments) {
    static constexpr std::array<std::string_view, 4> mirrors = {"none", "x", "y", "xy"};
    static constexpr std::array<std::string_view, 4> turns = {"0", "90", "180", "270"};
    static constexpr std::array<std::string_view, 3> levels = {"2", "16", "256"};
    static constexpr std::array<std::string_view, 2> places = {"centre", "as-is"};
    add_parsed(command, "--screen", "PRINTER|WxH", "Printer's screen for SL1 and PNG pictures: words of its name, or pixels",
               [&arguments](const std::string& text) { return take_screen(text, arguments.of_printer.emplace()); });
    const auto take_pixel = [&arguments](const std::string& text) -> std::string {
        const std::vector<double> mm = parse_numbers(text, ',').value_or(std::vector<double>());
        if (mm.empty() || mm.size() > 2) {
            return "'" + text + "' is not X or X,Y in mm";
        }
        arguments.pixel_mm = PointMm{mm.front(), mm.back()};
        return "";
    };
    for (CLI::Option* const detail :
         {add_parsed(command, "--pixel", "X[,Y]", "Size of a pixel of the screen in mm", take_pixel),
          add_choice(command, "--mirror", mirrors, "Axes in which the screen's picture is mirrored (the printer's, or none)",
                     [&arguments](std::size_t i) { arguments.mirror = i; }),
          add_choice(command, "--turn", turns, "Turn the mesh on the screen counter-clockwise (0)",
                     [&arguments](std::size_t i) { arguments.turn = static_cast<int>(90 * i); }),
          add_choice(command, "--levels", levels, "Grey levels: 256 or 16 by a pixel's share inside, 2 by its centre (256)",
                     [&arguments](std::size_t i) {
                         arguments.levels = std::array{2, 16, 256}[i];
                     }),
          add_choice(command, "--place", places, "Mesh in the screen's middle, or its x = y = 0 in the corner (centre)",
                     [&arguments](std::size_t i) { arguments.centred = i == 0; }),
          add_number(command, "--exposure", "S", "Time for which an SL1 lights a layer, in s (8)",
                     [&arguments](double s) { arguments.times.exposure_s = s; }),
          add_number(command, "--first-exposure", "S", "Time for which an SL1 lights the first layer, in s (35)",
                     [&arguments](double s) { arguments.times.first_exposure_s = s; })}) {
        detail->needs("--screen");
    }
}

std::optional<Screen> ScreenArguments::screen() const {
    std::optional<Screen> screen = of_printer;
    if (screen) {
        refuse_if(!pixel_mm && screen->pixel_x_mm == 0, bad_usage, "--screen: pixels alone need --pixel, their size in mm");
        screen->pixel_x_mm = pixel_mm ? pixel_mm->x : screen->pixel_x_mm;
        screen->pixel_y_mm = pixel_mm ? pixel_mm->y : screen->pixel_y_mm;
        screen->mirror_x = mirror ? (*mirror & 1) != 0 : screen->mirror_x;
        screen->mirror_y = mirror ? (*mirror & 2) != 0 : screen->mirror_y;
        screen->turn = turn;
        screen->levels = levels;
        screen->centred = centred;
    }
    return screen;
}

void require_on_screen(const OutputJob& job, const Source& mesh, const SliceOptions& options) {
    const auto output = std::find_if(job.outputs.begin(), job.outputs.end(), std::mem_fn(&PlannedOutput::on_screen));
    if (output != job.outputs.end()) {  // the first speaks: all have one screen
        const SliceInfo outline = done_or_thrown(Slicer().outline(mesh, options));
        const Status fits = check_fit(*job.arguments.screen.screen(), outline);
        refuse_if(!fits, bad_usage, fits ? "" : "'" + output->path + "': " + fits.error().message);
    }
}

void add_screens_command(CLI::App& app, Interrupt& /*interrupt*/) {
    CLI::App* const command = app.add_subcommand("screens", "List the printers that --screen knows");
    const auto words = std::make_shared<std::vector<std::string>>();
    add_text(*command, "word", *words, "WORD", "Only those with these words in their names");
    command->callback([words] {
        std::string text;
        for (const auto& [name, screen] : printers_called(joined(*words, " "))) {
            text += std::string(name) + ": " + std::to_string(screen.width) + "x" + std::to_string(screen.height) +
                    ", pixels of " + exact_text(screen.pixel_x_mm) + "," + exact_text(screen.pixel_y_mm) +
                    " mm, mirrored in " +
                    std::string(screen.mirror_x   ? "x"
                                : screen.mirror_y ? "y"
                                                  : "none") +
                    "\n";
        }
        refuse_if(text.empty(), bad_usage, "no printer is called so; lamella screens lists all");
        print(text);
    });
}

}  // namespace lamella::cli
