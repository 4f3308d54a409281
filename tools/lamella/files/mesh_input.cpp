#include "files/mesh_input.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <utility>

#include <unistd.h>

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

bool is_folder(const std::string& path) {
    std::error_code unknown;
    return !is_standard(path) && std::filesystem::is_directory(path, unknown);
}

void add_meshes(const std::filesystem::path& folder, const std::filesystem::path& below, std::vector<ListedMesh>& meshes) {
    std::error_code problem;
    const std::vector<std::filesystem::directory_entry> entries = entries_of(folder, problem);
    if (problem) {
        meshes.push_back({folder.string(), "", "cannot be listed: " + problem.message()});
    }
    for (const std::filesystem::directory_entry& entry : entries) {
        std::error_code unknown;
        const std::filesystem::path name = entry.path().filename();
        if (name.native().starts_with('.')) {
            continue;
        }
        if (!entry.is_directory(unknown)) {
            if (is_named_as_mesh(entry.path())) {
                meshes.push_back({entry.path().string(), below.string(), ""});
            }
        } else if (!entry.is_symlink(unknown)) {
            add_meshes(entry.path(), below / name, meshes);
        }
    }
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

std::vector<std::filesystem::directory_entry> entries_of(const std::filesystem::path& folder, std::error_code& problem) {
    std::vector<std::filesystem::directory_entry> entries;
    for (std::filesystem::directory_iterator at(folder, problem); !problem && at != std::filesystem::directory_iterator();
         at.increment(problem)) {
        entries.push_back(*at);
    }
    std::sort(entries.begin(), entries.end());
    return entries;
}

std::vector<ListedMesh> meshes_below(const std::string& folder) {
    std::vector<ListedMesh> meshes;
    add_meshes(folder, "", meshes);
    if (meshes.empty()) {
        meshes.push_back({folder, "", "is a folder in which no file is named as a mesh"});
    }
    return meshes;
}

void declare_mesh_list(CLI::App& command, MeshListArguments& arguments) {
    command
        .add_option("mesh", arguments.given,
                    mesh_help("Mesh files, folders with mesh files, or - for standard input; formats"))
        ->required()
        ->type_name("MESH|FOLDER|-")
        ->check(given_path);
    declare_reading(command, arguments.each);
}

MeshList::MeshList(const MeshListArguments& arguments)
    : each_(arguments.each), several_(arguments.given.size() > 1 || is_folder(arguments.given.front())) {
    if (std::count_if(arguments.given.begin(), arguments.given.end(), is_standard) > 1) {
        throw Failure(bad_usage, "mesh: '-' is given twice, and standard input can be read once");
    }
    (void)parse_unit(each_.unit.value_or("mm"), "--unit");
    (void)parse_grid(each_.grid);
    for (const std::string& path : arguments.given) {
        if (is_folder(path)) {
            const std::vector<ListedMesh> found = meshes_below(path);
            meshes_.insert(meshes_.end(), found.begin(), found.end());
        } else {
            meshes_.push_back({path, "", ""});
        }
    }
}

std::vector<std::string> MeshList::paths() const {
    std::vector<std::string> paths;
    for (const ListedMesh& entry : meshes_) {
        paths.push_back(entry.path);
    }
    return paths;
}

std::optional<Failure> MeshList::for_each(Interrupt& interrupt, const Use& use, const Refuse& refuse) const {
    ExitStatus worst = done;
    std::size_t refused = 0;
    for (const ListedMesh& entry : meshes_) {
        MeshArguments mesh = each_;
        mesh.mesh = entry.path;
        try {
            if (!entry.problem.empty()) {
                throw Failure(bad_input, entry.path + ": " + entry.problem);
            }
            use(mesh);
        } catch (const Failure& failure) {
            if (meshes_.size() == 1 || failure.status() == bad_output) {
                throw;
            }
            interrupt.die_if_interrupted();
            complain(failure.what());
            refuse(mesh, failure);
            worst = std::max(worst, failure.status());
            ++refused;
        }
    }
    if (refused == 0) {
        return std::nullopt;
    }
    return Failure(worst, grouped(refused) + " of " + counted(meshes_.size(), "mesh", "meshes") + " could not be used");
}

}  // namespace lamella::cli
