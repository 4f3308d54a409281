// lamella info: what a mesh is, and whether it is closed.
#include <memory>
#include <string>

#include "commands.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh/inspect.hpp"
#include "mesh_input.hpp"

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

std::string words(const std::string& path, const MeshFile& mesh, const MeshInfo& info) {
    return "mesh            " + path + ", " + description(mesh) + "\ntriangles       " + grouped(info.triangles) +
           "\ndegenerate      " + grouped(info.degenerate) + "\nbox             " + box(info) + "\narea            " +
           rounded(info.area_mm2, 3) + " mm2\nvolume          " + rounded(info.volume_mm3, 3) + " mm3" +
           (info.closed ? "" : " (not meaningful: the mesh is not closed)") + "\nedges           " + grouped(info.edges) +
           "\nboundary edges  " + grouped(info.boundary_edges) + "\nover-full edges " + grouped(info.overfull_edges) +
           "\nflipped edges   " + grouped(info.mismatched_edges) + "\nshells          " + grouped(info.shells) +
           "\ngrid            " + exact_text(info.unit_mm) + " mm\nclosed          " + (info.closed ? "yes" : "no") + "\n";
}

void run(const MeshArguments& arguments) {
    const MeshFile mesh = read_mesh_and_warn(arguments);
    const Result<MeshInfo> info = inspect(mesh, {.control = {.threads = arguments.threads}});
    if (!info) {
        throw Failure(failure_of(info.error()).status(), arguments.mesh + ": " + info.error().message);
    }
    print(words(arguments.mesh, mesh, info.value()));
}

}  // namespace

void add_info_command(CLI::App& app) {
    CLI::App* const command = app.add_subcommand("info", "Say what a mesh is and whether it is closed");
    const auto arguments = std::make_shared<MeshArguments>();
    declare_mesh(*command, *arguments);
    command->callback([arguments] { run(*arguments); });
}

}  // namespace lamella::cli
