// lamella info: what a mesh is, and whether it is closed.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "commands.hpp"
#include "files/mesh_input.hpp"
#include "files/scale_words.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh/inspect.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"
#include "terminal/stages.hpp"

namespace lamella::cli {

namespace {

std::string box(const MeshInfo& info) {
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
        text += std::string(axis == 0 ? "" : ", ") + "xyz"[axis] + " " + exact_text(info.min_mm[axis]) + " to " +
                exact_text(info.max_mm[axis]);
    }
    return text + " mm";
}

std::string size(const MeshInfo& info) {
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
        text += (axis == 0 ? "" : " x ") + measure_text(info.max_mm[axis] - info.min_mm[axis]);
    }
    return text + " mm";
}

/// Planes lie in the middle of their layers.
std::string layers(const MeshInfo& info) {
    std::string text;
    for (const double layer_mm : {0.1, 0.2}) {
        const double count = std::max(0.0, std::ceil((info.max_mm[2] - info.min_mm[2]) / layer_mm - 0.5));
        text +=
            (text.empty() ? "" : ", ") + grouped(static_cast<std::uint64_t>(count)) + " of " + exact_text(layer_mm) + " mm";
    }
    return text;
}

/// A line for each part, where there are several.
std::string parts(const MeshFile& mesh) {
    std::string text = "parts           " + grouped(mesh.parts.size()) + "\n";
    for (const MeshPart& part : mesh.parts) {
        text += "  " + std::string(name_of(part.role)) + (part.role == PartRole::solid ? ", " : " (left out), ") +
                counted(part.triangle_count, "triangle") + ": " + printable(part.name) + "\n";
    }
    return mesh.parts.size() > 1 ? text : "";
}

std::string words(const std::string& path, const MeshFile& mesh, const MeshInfo& info) {
    return "mesh            " + path + ", " + description(mesh) + "\ntriangles       " + grouped(info.triangles) +
           "\ndegenerate      " + grouped(info.degenerate) + "\nbox             " + box(info) + "\nsize            " +
           size(info) + "\nlayers          " + layers(info) + "\narea            " + measure_text(info.area_mm2) +
           " mm2\nvolume          " + measure_text(info.volume_mm3) + " mm3" +
           (info.closed ? "" : " (not meaningful: the mesh is not closed)") + "\nedges           " + grouped(info.edges) +
           "\nboundary edges  " + grouped(info.boundary_edges) + "\nover-full edges " + grouped(info.overfull_edges) +
           "\nflipped edges   " + grouped(info.mismatched_edges) + "\nshells          " + grouped(info.shells) +
           "\ngrid            " + exact_text(info.unit_mm) + " mm" + joined_by_grid(info) + "\nclosed          " +
           (info.closed ? "yes" : "no") + "\n" + parts(mesh);
}

Result<MeshInfo> inspected(const MeshArguments& arguments, const MeshFile& mesh, ProgressBar& bar) {
    const Stage stage(bar, "inspecting");
    return inspect(mesh, {.unit_mm = parse_grid(arguments.grid),
                          .control = {.threads = arguments.threads, .progress = stage.progress()}});
}

std::string info_words(const MeshArguments& arguments) {
    ProgressBar bar(arguments.progress);
    const MeshFile mesh = read_mesh_and_warn(arguments, bar);
    const MeshInfo info = done_or_thrown(inspected(arguments, mesh, bar), arguments.name());
    for (const std::string& doubt : doubts_of_scale(arguments, mesh, {info.min_mm, info.max_mm, info.unit_mm})) {
        warn(doubt);
    }
    return words(arguments.name(), mesh, info);
}

void run(const MeshListArguments& arguments, Interrupt& interrupt) {
    bool first = true;
    const auto print_info = [&first](const MeshArguments& mesh) {
        const std::string words = info_words(mesh);
        print((first ? "" : "\n") + words);
        first = false;
    };
    const auto refuse = [](const MeshArguments&, const Failure&) {};
    if (const std::optional<Failure> failure = MeshList(arguments).for_each(interrupt, print_info, refuse)) {
        throw Failure(*failure);
    }
}

}  // namespace

void add_info_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("info", "Say what meshes are and whether they are closed");
    const auto arguments = std::make_shared<MeshListArguments>();
    declare_mesh_list(*command, *arguments);
    declare_progress(*command, arguments->each);
    command->callback([arguments, &interrupt] { run(*arguments, interrupt); });
}

}  // namespace lamella::cli
