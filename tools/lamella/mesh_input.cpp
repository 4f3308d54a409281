#include "mesh_input.hpp"

#include <utility>

#include "bus_error.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "numbers.hpp"

namespace lamella::cli {

namespace {

/// "STL, OBJ, ...": what can be read.
std::string mesh_formats() {
    std::string names;
    for (const std::string_view name : format_names()) {
        names += (names.empty() ? "" : ", ") + std::string(name);
    }
    return names + "; gzip of any";
}

}  // namespace

std::string given(const std::string& text) {
    return text.empty() ? "is empty" : "";
}

std::string given_path(const std::string& path) {
    return path.empty() ? "the path is empty" : "";
}

void declare_mesh(CLI::App& command, MeshArguments& arguments) {
    command.add_option("mesh", arguments.mesh, "Mesh file: " + mesh_formats())
        ->required()
        ->type_name("MESH")
        ->check(given_path);
    command.add_option("--unit", arguments.unit, "Unit of meshes that do not state one (default mm)")
        ->type_name("mm|um|cm|m|in|ft|MM");
    command.add_option("--threads", arguments.threads, "Use at most N threads (0: all)")
        ->type_name("N")
        ->check(CLI::Range(0, most_threads));
}

MeshFile read_mesh_of(const MeshArguments& arguments, ProgressBar& bar) {
    if (arguments.map_file) {
        explain_bus_errors(arguments.mesh);
    }
    const Stage stage(bar, "reading");
    Result<MeshFile> mesh =
        read_mesh(arguments.mesh, {.map_file = arguments.map_file,
                                   .mm_per_unit = parse_unit(arguments.unit.value_or("mm"), "--unit"),
                                   .control = {.threads = arguments.threads, .progress = stage.progress()}});
    if (!mesh) {
        const Failure failure = failure_of(mesh.error());
        // Where memory ran out there was none left to say in which file.
        throw mesh.error().code == ErrorCode::out_of_memory && std::string_view(failure.what()) == "out of memory"
            ? Failure(failure.status(), arguments.mesh + ": " + failure.what())
            : failure;
    }
    if (arguments.unit && mesh->states_unit) {
        mesh->warnings.push_back(arguments.mesh + ": states that its unit is " + exact_text(mesh->mm_per_unit) +
                                 " mm, which holds instead of --unit");
    }
    return std::move(mesh).value();
}

MeshFile read_mesh_and_warn(const MeshArguments& arguments, ProgressBar& bar) {
    MeshFile mesh = read_mesh_of(arguments, bar);
    for (const std::string& warning : mesh.warnings) {
        warn(warning);
    }
    return mesh;
}

std::string description(const MeshFile& mesh) {
    std::string text = std::string(mesh.text ? "text" : "binary") + " " + std::string(name_of(mesh.format)) + ", " +
                       file_size_text(mesh.file_bytes) + (mesh.compressed ? " of gzip" : "");
    if (mesh.mm_per_unit != 1) {
        text += ", in units of " + exact_text(mesh.mm_per_unit) + " mm";
    }
    if (mesh.patient_frame != PatientFrame::unstated) {
        text += ", patient frame " + std::string(name_of(mesh.patient_frame));
    }
    return text;
}

}  // namespace lamella::cli
