// lamella info: what a mesh is, and whether it is closed. lamella check: what is wrong with it, and where. lamella make: a
// sample mesh of any size.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/mesh_input.hpp"
#include "lamella/check.hpp"
#include "lamella/io/check_report.hpp"
#include "lamella/io/mesh_file.hpp"
#include "models/models.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

/// A line for each part, where there are several.
std::string parts(const MeshFile& mesh) {
    std::string text = "parts           " + grouped(mesh.parts.size()) + "\n";
    for (const MeshPart& part : mesh.parts) {
        text += "  " + std::string(name_of(part.role)) + (part.role == PartRole::solid ? ", " : " (left out), ") +
                counted(part.triangle_count, "triangle") + ": " + printable(part.name) + "\n";
    }
    return mesh.parts.size() > 1 ? text : "";
}

std::string words(const std::string& path, const MeshFile& mesh, const MeshCheck& info) {
    std::string box;
    std::string size;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = info.box.min_mm[axis];
        const double high = info.box.max_mm[axis];
        box += when(axis > 0, ", ") + "xyz"[axis] + " " + exact_text(low) + " to " + exact_text(high);
        size += when(axis > 0, " x ") + measure_text(high - low);
    }
    std::string layers;  // planes lie in the middle of their layers
    for (const double layer_mm : {0.1, 0.2}) {
        const double count = std::max(0.0, std::ceil((info.box.max_mm[2] - info.box.min_mm[2]) / layer_mm - 0.5));
        layers +=
            when(!layers.empty(), ", ") + grouped(static_cast<std::uint64_t>(count)) + " of " + exact_text(layer_mm) + " mm";
    }
    return "mesh            " + path + ", " + description(mesh) + "\ntriangles       " + grouped(info.triangles) +
           "\ndegenerate      " + grouped(info.degenerate) + "\nbox             " + box + " mm\nsize            " + size +
           " mm\nlayers          " + layers + "\narea            " + measure_text(info.area_mm2) + " mm2\nvolume          " +
           measure_text(info.volume_mm3) + " mm3" + (info.closed ? "" : " (not meaningful: the mesh is not closed)") +
           "\nedges           " + grouped(info.edges) + "\nboundary edges  " + grouped(info.boundary_edges) +
           "\nover-full edges " + grouped(info.overfull_edges) + "\nflipped edges   " + grouped(info.mismatched_edges) +
           "\nshells          " + grouped(info.shell_count) + "\ngrid            " + exact_text(info.grid_mm) + " mm" +
           joined_by_grid(info) + "\nclosed          " + (info.closed ? "yes" : "no") + "\n" + parts(mesh);
}

void run(const MeshList& meshes, Interrupt& interrupt) {
    bool first = true;
    const auto print_info = [&](const MeshArguments& arguments) {
        Stages stages(arguments.progress, arguments.threads, interrupt);
        const MeshFile mesh = read_mesh_and_warn(arguments, stages);
        const auto inspect = [&](const Context& context) {
            return check(mesh.view(), {.frame = arguments.options.frame, .counts_only = true}, context);
        };
        const MeshCheck info = done_or_thrown(stages.run("inspecting", inspect), arguments.name());
        interrupt.end_deferring();  // what is left may block on a pipe
        for (const std::string& doubt : doubts_of_scale(arguments, mesh, {info.box, info.grid_mm})) {
            warn(doubt);
        }
        print(when(!std::exchange(first, false), "\n") + words(arguments.name(), mesh, info));
    };
    if (const auto failure = meshes.for_each(interrupt, print_info, [](const MeshArguments&, const Failure&) {})) {
        throw Failure(*failure);
    }
}

constexpr std::size_t most_marks =
    1'000'000;  ///< of each kind, as of what is listed; also keeps vertex numbers within PLY's int

struct CheckArguments : MeshList {
    std::string report;
    std::string marks;
    double tolerance_mm = CheckOptions{}.tolerance_mm;
    std::size_t places = CheckOptions{}.most_places;
    bool all_kinds = false;
};

/// The members that the tool adds to the report. They refer to `mesh`.
std::vector<ReportMember> members_of(const CheckTimes& ms, const MeshFile& mesh, double write_ms, double total_ms) {
    return {{ReportPlace::in_times, "read", mesh.read_ms},
            {ReportPlace::in_times, "parse", mesh.parse_ms},
            {ReportPlace::in_times, "measure", ms.measure},
            {ReportPlace::in_times, "faces", ms.faces},
            {ReportPlace::in_times, "edges", ms.edges},
            {ReportPlace::in_times, "joints", ms.joints},
            {ReportPlace::in_times, "shells", ms.shells},
            {ReportPlace::in_times, "meeting", ms.meeting},
            {ReportPlace::in_times, "gaps", ms.gaps},
            {ReportPlace::in_times, "write", write_ms},
            {ReportPlace::in_times, "total", total_ms},
            {ReportPlace::at_end, "warnings", std::span<const std::string>(mesh.warnings)}};
}

/// So that figures stand below one another.
std::string line(std::string name, const std::string& value) {
    constexpr std::size_t column = 27;
    name.resize(std::max(name.size() + 1, column), ' ');
    return name + value + "\n";
}

std::string point(const std::array<double, 3>& mm) {
    return "(" + exact_text(mm[0]) + ", " + exact_text(mm[1]) + ", " + exact_text(mm[2]) + ")";
}

/// Details that only this kind of fault has.
std::string detail(Fault fault, const FaultPlace& place) {
    switch (fault) {
        case Fault::overfull_balanced:
        case Fault::overfull_unbalanced:
            return ", " + counted(place.parts, "face");
        case Fault::boundary_loop:
            return ", " + counted(place.parts, "edge") + ", " + measure_text(place.measure) + " mm" +
                   (place.closed ? "" : ", not closed");
        case Fault::split_vertex:
            return ", " + counted(place.parts, "fan");
        case Fault::needle_face:
        case Fault::cap_face:
            return ", " + rounded(place.measure, 0) + " : 1";
        case Fault::misoriented_shell:
            return ", " + measure_text(place.measure) + " mm3";
        case Fault::t_junction:
        case Fault::crack:
            return ", " + exact_text(place.measure) + " mm wide";
        default:
            return "";
    }
}

std::string words(Fault fault, const FaultPlace& place) {
    std::string text = "  ";
    for (std::size_t i = 0; i < static_cast<std::size_t>(place.point_count); ++i) {
        text += (i == 0 ? "" : " ") + point(place.points_mm[i]);
    }
    text += detail(fault, place);
    text += when(place.triangles[0] >= 0,
                 (place.triangles[1] >= 0 ? ", triangles " : ", triangle ") + std::to_string(place.triangles[0]));
    return text + (place.triangles[1] >= 0 ? " and " + std::to_string(place.triangles[1]) : "") + "\n";
}

/// A line that says how many there are beyond the first.
std::string more(std::uint64_t count, std::size_t shown) {
    return count > shown ? "  ... and " + grouped(count - shown) + " more\n" : "";
}

std::string words(Fault fault, const FaultFinding& finding, std::size_t most) {
    const std::size_t shown = std::min(most, finding.places.size());
    std::string text =
        line(std::string(words_for(fault, 0)), (finding.at_least ? "at least " : "") + grouped(finding.count));
    for (std::size_t i = 0; i < shown; ++i) {
        text += words(fault, finding.places[i]);
    }
    return text + more(finding.count, shown);
}

std::string words(const MeshShell& shell) {
    const std::string kind = !shell.closed           ? "not closed"
                             : shell.orientation > 0 ? "solid"
                             : shell.orientation < 0 ? "cavity"
                                                     : "no volume";
    return "  " + point(shell.first_mm) + ", " + kind + ", depth " + std::to_string(shell.depth) + ", " +
           counted(shell.triangles, "triangle") + (shell.closed ? ", " + measure_text(shell.volume_mm3) + " mm3" : "") +
           ", triangle " + std::to_string(shell.triangle) + "\n";
}

/// One line a kind of fault with its count, below it its places, at most so many; then what was examined; the last line is
/// the verdict. `all_kinds`: also those that were not found.
std::string check_words(const std::string& path, const MeshFile& mesh, const MeshCheck& check, std::size_t most_places,
                        bool all_kinds) {
    std::string text = line("mesh", path + ", " + description(mesh));
    for (std::size_t i = 0; i < fault_count; ++i) {
        text += when(all_kinds || check.findings[i].count > 0 || check.findings[i].at_least,
                     words(static_cast<Fault>(i), check.findings[i], most_places));
    }
    text += line("triangles", grouped(check.triangles)) + line("edges", grouped(check.edges)) +
            line("grid", exact_text(check.grid_mm) + " mm" + joined_by_grid(check)) +
            line("tolerance", exact_text(check.tolerance_mm) + " mm") +
            line("slivers", "from " + exact_text(check.sliver_ratio) + " : 1");
    const std::size_t shown = std::min(most_places, check.shells.size());
    text +=
        line("shells", grouped(check.shells.size()) + (check.nesting_complete ? "" : ", nested at least as deep as this"));
    for (std::size_t i = 0; i < shown; ++i) {
        text += words(check.shells[i]);
    }
    return text + more(check.shells.size(), shown) + done_or_thrown(make_verdict(check)) + "\n";
}

class CheckCommand {
public:
    CheckCommand(const CheckArguments& arguments, Interrupt& interrupt) : arguments_(arguments), interrupt_(interrupt) {}

    void run() {
        const std::vector<ListedMesh> meshes = arguments_.meshes();
        FilePlan plan;
        for (const ListedMesh& mesh : meshes) {
            plan.reads(mesh.path, "the mesh");
        }
        refuse_if(!arguments_.marks.empty() && meshes.size() > 1, bad_usage,
                  "--marks: the marks are of one mesh, and " + grouped(meshes.size()) + " are given");
        for (const auto& [option, path] : {std::pair{"--marks", arguments_.marks}, {"--report", arguments_.report}}) {
            if (!path.empty()) {
                require_writable(path);
                plan.writes(path, option, std::string("the file of ") + option);
            }
        }
        require_extension(arguments_.marks, "--marks", ".ply");
        interrupt_.tidy({arguments_.report, arguments_.marks});
        const std::optional<Failure> failure = arguments_.for_each(
            interrupt_, [this](const MeshArguments& mesh) { examine(mesh); },
            [this](const MeshArguments& mesh, const Failure& reason) {
                const ReportMember error{.key = "error", .value = std::string_view(reason.what())};
                reports_.push_back(done_or_thrown(make_mesh_json({.mesh_name = mesh.mesh, .members = {&error, 1}})));
            });
        std::string text;  // one report, or an array of them, each of which is text that ends a line
        for (const std::string& report : reports_) {
            text += when(!text.empty(), ",\n") + report.substr(0, report.size() - 1);
        }
        if (!arguments_.report.empty()) {
            write_text(arguments_.report, arguments_.several() ? "[\n" + text + "\n]\n" : text + "\n");
        }
        // The words of one mesh come when the report is written.
        print_words(arguments_.several() ? "" : held_words_, stdout_taken());
        if (failure) {
            throw Failure(*failure);
        }
    }

private:
    bool stdout_taken() const noexcept { return is_standard(arguments_.report) || is_standard(arguments_.marks); }

    void examine(const MeshArguments& mesh) {
        const Stopwatch watch;
        Stages stages(mesh.progress, mesh.threads, interrupt_);
        MeshFile file = read_mesh_and_warn(mesh, stages);
        const std::size_t places = arguments_.marks.empty() ? arguments_.places : std::max(arguments_.places, most_marks);
        const CheckOptions options{
            .frame = mesh.options.frame, .tolerance_mm = arguments_.tolerance_mm, .most_places = places};
        const MeshCheck found = done_or_thrown(
            stages.run("checking", [&](const Context& context) { return check(file.view(), options, context); }),
            mesh.name());
        interrupt_.end_deferring();  // what is left may block on a pipe
        for (std::string& doubt : doubts_of_scale(mesh, file, {found.box, found.grid_mm})) {
            warn(doubt);
            file.warnings.push_back(std::move(doubt));
        }
        const Stopwatch marking;
        if (!arguments_.marks.empty()) {
            done_or_thrown(write_marks(found, output_path(arguments_.marks)));
        }
        if (!arguments_.report.empty()) {
            const double write_ms = arguments_.marks.empty() ? 0 : marking.ms();
            const std::vector<ReportMember> members = members_of(found.ms, file, write_ms, watch.ms());
            const ReportParts parts{.mesh_name = mesh.mesh, .file = &file, .members = members};
            reports_.push_back(done_or_thrown(make_check_json(found, parts, arguments_.places)));
        }
        held_words_ += check_words(mesh.name(), file, found, arguments_.places, arguments_.all_kinds);
        if (arguments_.several()) {  // a blank line before each but the first
            print_words(held_words_, stdout_taken());
            held_words_ = "\n";
        }
    }

    const CheckArguments& arguments_;
    Interrupt& interrupt_;
    std::vector<std::string> reports_;  ///< one of each mesh
    std::string held_words_;
};

struct MakeArguments {
    std::string output;
    models::Recipe recipe;
};

void make(const MakeArguments& arguments, Interrupt& interrupt) {
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

void add_info_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("info", "Say what meshes are and whether they are closed");
    const auto arguments = std::make_shared<MeshList>();
    declare_mesh_list(*command, *arguments);
    command->callback([arguments, &interrupt] { run(*arguments, interrupt); });
}

void add_check_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("check", "Say what is wrong with meshes, and where");
    const auto arguments = std::make_shared<CheckArguments>();
    declare_mesh_list(*command, *arguments);
    add_text(*command, "--report", arguments->report, "FILE|-",
             "JSON report to write, an array if several meshes are given; - for standard output");
    add_text(*command, "--marks", arguments->marks, "FILE.ply|-",
             "PLY file of coloured points and edges at every place; - for standard output");
    add_number(*command, "--tolerance", "MM", "Widest gap that counts as a crack or T-junction (0.01)",
               [arguments](double mm) { arguments->tolerance_mm = mm; });
    add(*command, "--places", arguments->places, "N", "List at most N places of each kind (10)")
        ->check(CLI::Range(0, static_cast<int>(most_marks)));
    command->add_flag("--all", arguments->all_kinds, "List the kinds of faults that were not found, too");
    command->callback([arguments, &interrupt] { CheckCommand(*arguments, interrupt).run(); });
}

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
    command->callback([arguments, &interrupt] { make(*arguments, interrupt); });
}

}  // namespace lamella::cli
