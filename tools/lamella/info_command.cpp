// lamella info: what a mesh is, and whether it is closed.
#include <memory>
#include <string>

#include "commands.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "lamella/inspect.hpp"
#include "lamella/mesh_file.hpp"
#include "mesh_words.hpp"
#include "numbers.hpp"

namespace lamella::cli {

namespace {

struct InfoArguments {
    std::string mesh;
    std::string unit = "mm";
    int threads = 0;
};

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

void run(const InfoArguments& arguments) {
    const Result<MeshFile> mesh =
        read_mesh(arguments.mesh, {.threads = arguments.threads, .mm_per_unit = parse_unit(arguments.unit, "--unit")});
    if (!mesh) {
        throw failure_of(mesh.error());
    }
    for (const std::string& warning : mesh.value().warnings) {
        warn(warning);
    }
    const Result<MeshInfo> info =
        inspect(mesh.value().view(), {.unit_mm = 0, .threads = arguments.threads, .transform = mesh.value().to_mm()});
    if (!info) {
        throw Failure(failure_of(info.error()).status(), arguments.mesh + ": " + info.error().message);
    }
    print(words(arguments.mesh, mesh.value(), info.value()));
}

}  // namespace

void add_info_command(CLI::App& app) {
    CLI::App* const command = app.add_subcommand("info", "Say what a mesh is and whether it is closed");
    const auto arguments = std::make_shared<InfoArguments>();
    command->add_option("mesh", arguments->mesh, "Mesh file: " + mesh_formats())->required()->type_name("MESH");
    command->add_option("--unit", arguments->unit, "What a mesh that states no unit is measured in (mm)")
        ->type_name("mm|um|cm|m|in|ft|MM");
    command->add_option("--threads", arguments->threads, "At most this many (0: all)")
        ->type_name("N")
        ->check(CLI::Range(0, most_threads));
    command->callback([arguments] { run(*arguments); });
}

}  // namespace lamella::cli
