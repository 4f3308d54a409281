#include "files/mesh_input.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <utility>

#include <unistd.h>

#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"
#include "terminal/stages.hpp"

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

/// Made before it is needed: a handler may neither allocate nor format.
std::string& bus_error_line() {
    static std::string line;
    return line;
}

/// Several threads may read the file: one says so, the others wait for the end.
extern "C" void end_with_bus_error_line(int /*signal_number*/) {
    static std::atomic_flag taken;
    while (taken.test_and_set()) {
        ::pause();
    }
    const std::string& line = bus_error_line();
    (void)!::write(STDERR_FILENO, line.data(), line.size());
    ::_exit(bad_input);
}

/// Reading on where a mapped file has ended is a SIGBUS, which from here on ends the process with one line that names the
/// file. Nothing is being written while the mesh is read, so there is nothing to tidy up.
void explain_bus_errors(const std::string& name) {
    bus_error_line() = complaint(name + ": shrank while it was read, or its disk failed");
    (void)std::signal(SIGBUS, end_with_bus_error_line);
}

Result<MeshFile> read_standard_input(const ReadOptions& options) {
    const Stopwatch watch;
    const SpooledInput input;
    const double spool_ms = watch.ms();
    Result<MeshFile> mesh = read_mesh(input.path(), options);
    if (mesh) {
        mesh->read_ms += spool_ms;
    }
    return mesh;
}

}  // namespace

std::string given(const std::string& text) {
    return text.empty() ? "is empty" : "";
}

std::string given_path(const std::string& path) {
    return path.empty() ? "the path is empty" : "";
}

std::string lower_case(std::string word) {
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c; });
    return word;
}

std::string mesh_help(const std::string& what) {
    return what + ": " + mesh_formats();
}

void declare_reading(CLI::App& command, MeshArguments& arguments) {
    command.add_option("--unit", arguments.unit, "Unit of meshes that do not state one (default mm)")
        ->type_name("mm|um|cm|m|in|ft|MM")
        ->transform(lower_case);
    command
        .add_option("--grid", arguments.grid,
                    "Unit of the integer grid (2^-20 mm, or more if the mesh needs it); auto: the finest that it fits")
        ->type_name("MM|auto")
        ->transform(lower_case)
        ->check(given);
    declare_threads(command, arguments);
}

void declare_threads(CLI::App& command, MeshArguments& arguments) {
    command.add_option("--threads", arguments.threads, "Use at most N threads (0: all)")
        ->type_name("N")
        ->check(CLI::Range(0, most_threads));
}

MeshFile read_mesh_of(const MeshArguments& arguments, ProgressBar& bar) {
    const std::string name = arguments.name();
    if (arguments.map_file) {
        explain_bus_errors(name);
    }
    const Stage stage(bar, "reading");
    ReadOptions options;
    options.map_file = arguments.map_file;
    options.mm_per_unit = parse_unit(arguments.unit.value_or("mm"), "--unit");
    options.control.threads = arguments.threads;
    options.control.progress = stage.progress();
    const bool standard = is_standard(arguments.mesh);
    options.name = standard ? std::string_view(name) : "";
    Result<MeshFile> mesh = standard ? read_standard_input(options) : read_mesh(arguments.mesh, options);
    if (!mesh) {
        const Failure failure = failure_of(mesh.error());
        // Where memory ran out there was none left to say in which file.
        throw mesh.error().code == ErrorCode::out_of_memory && std::string_view(failure.what()) == "out of memory"
            ? Failure(failure.status(), name + ": " + failure.what())
            : failure;
    }
    if (arguments.unit && mesh->states_unit) {
        mesh->warnings.push_back(name + ": states that its unit is " + exact_text(mesh->mm_per_unit) +
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
