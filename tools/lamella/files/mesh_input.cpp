#include "files/mesh_input.hpp"

#include <algorithm>
#include <array>
#include <cerrno>

#include "base/system/file.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/text_file.hpp"
#include "system/terminal.hpp"

namespace lamella::cli {

namespace {

Failure unreadable(int error_number) {
    return {bad_input, "standard input: cannot be read: " + std::generic_category().message(error_number)};
}

Failure no_spool(int error_number) {
    return {bad_input, "standard input: cannot be kept in a temporary file in '" + temporary_folder() +
                           "': " + std::generic_category().message(error_number)};
}

/// All of standard input in a file that has no name, so that any of its bytes can be read in any order. The file is made in
/// the temporary folder. Throws Failure.
File spooled_input() {
    File input;
    // A file opened now would take the number of a standard input that is closed.
    if (const int failure = input.duplicate(0); failure != 0) {
        throw unreadable(failure);
    }
    File file;
    int failure = file.create_scratch(path_of(temporary_folder()));
    std::vector<char> buffer(std::size_t{1} << 20);
    for (std::size_t count = 1; failure == 0 && count > 0;) {
        if (const int unread = input.read(std::as_writable_bytes(std::span(buffer)), count); unread != 0) {
            throw unreadable(unread);
        }
        failure = file.write({buffer.data(), count});
    }
    if (failure != 0) {
        throw no_spool(failure);
    }
    return file;
}

void add_meshes(const std::filesystem::path& folder, const std::filesystem::path& below, std::vector<ListedMesh>& meshes) {
    std::error_code problem;
    for (const std::filesystem::directory_entry& entry : entries_of(folder, problem)) {
        std::error_code unknown;
        const std::filesystem::path name = entry.path().filename();
        if (name.native().front() == '.') {
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
    if (problem) {
        meshes.push_back({folder.string(), "", "cannot be listed: " + problem.message()});
    }
}

constexpr double longest_mm = 10'000;  // of what is printed, or scanned
constexpr double shortest_mm = 1;

struct Unit {
    std::string_view name;
    std::string_view words;
    double mm;
};
constexpr std::array<Unit, 6> units = {{{"um", "micrometres", 0.001},
                                        {"mm", "millimetres", 1},
                                        {"cm", "centimetres", 10},
                                        {"m", "metres", 1000},
                                        {"in", "inches", 25.4},
                                        {"ft", "feet", 304.8}}};
constexpr const Unit& micrometre = units[0];
constexpr const Unit& metre = units[3];

std::optional<std::string> doubt_of_unit(const MeasuredMesh& mesh) {
    double length_mm = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        length_mm = std::max(length_mm, mesh.box.max_mm[axis] - mesh.box.min_mm[axis]);
    }
    const auto doubt = [&](double mm, const std::string& words, const Unit& unit) {
        const double length_so_mm = length_mm * unit.mm;
        // The mesh may be out of proportion in that unit too.
        const bool is_likely = length_so_mm >= shortest_mm && length_so_mm <= longest_mm;
        return "the mesh is " + measure_text(mm) + words + ": in " +
               (is_likely ? std::string(unit.words) + "? --unit " + std::string(unit.name) : "another unit? see --unit");
    };
    const double height_mm = mesh.box.max_mm[2] - mesh.box.min_mm[2];
    if (length_mm > longest_mm) {
        return doubt(length_mm, " mm long", micrometre);
    }
    // A plate may be thinner than a layer. What would be longer than 10 m in metres is not in metres.
    if (mesh.plane_distance_mm && height_mm < *mesh.plane_distance_mm && length_mm * metre.mm <= longest_mm) {
        return doubt(height_mm, " mm high, less than a layer", metre);
    }
    return std::nullopt;
}

}  // namespace

void write_text(const std::string& path, const std::string& text) {
    if (is_standard(path)) {
        print(text);
    } else {
        done_or_thrown(write_text_file(path_of(path), text));
    }
}

std::string temporary_folder() {
    std::error_code unknown;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(unknown);
    return unknown ? "/tmp" : folder.string();
}

Failure unwritable(const std::string& path, int error_number) {
    return failure_of(lamella::unwritable(path_of(path), error_number));
}

void require_writable(const std::string& path) {
    if (is_standard(path)) {
        const int failure = check_standard_output();
        return refuse_if(failure != 0, bad_output, "cannot write to standard output: " + system_message(failure));
    }
    // Nothing is made for a trial: a signal at that moment would leave it behind.
    const std::filesystem::path file = path_of(path);
    std::error_code unknown;
    if (!file.has_filename() || std::filesystem::is_directory(file, unknown)) {
        throw unwritable(path, EISDIR);
    }
    const bool exists = std::filesystem::exists(file, unknown);
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    if (!exists && std::filesystem::exists(folder, unknown) && !std::filesystem::is_directory(folder, unknown)) {
        throw unwritable(path, ENOTDIR);
    }
    if (const int failure = check_writable(exists ? file : folder); failure != 0) {
        throw unwritable(path, failure);
    }
}

void require_extension(const std::string& path, const std::string& option, const std::string& extension) {
    const std::string own = lower_case(path_of(path).extension().string());
    std::error_code unknown;
    if (!own.empty() && own != extension && !std::filesystem::is_other(path_of(path), unknown)) {
        throw Failure(bad_usage,
                      option + ": '" + path + "': no format that is written ends in " + own + "; there is " + extension);
    }
}

/// Folders are resolved once: a batch has thousands of files in each.
std::vector<std::string> FilePlan::keys_of(const std::string& path) const {
    if (is_standard(path)) {
        return {path};
    }
    std::error_code unknown;
    const std::filesystem::path given = path_of(path);
    const std::filesystem::path name = given.filename();
    std::filesystem::path place;
    if (name.empty() || name == "." || name == ".." || std::filesystem::is_symlink(given, unknown)) {
        place = std::filesystem::weakly_canonical(std::filesystem::absolute(given, unknown), unknown);
        place = unknown ? given.lexically_normal() : place;
    } else {
        const auto [folder, is_new] = folders_.try_emplace(given.parent_path().string());
        if (is_new) {
            const std::filesystem::path whole = std::filesystem::absolute(given.parent_path() / ".", unknown);
            const std::filesystem::path found = std::filesystem::weakly_canonical(whole, unknown);
            folder->second = (unknown ? given.parent_path().lexically_normal() : found).string();
        }
        place = path_of(folder->second) / name;
    }
    std::vector<std::string> keys = {place.string()};
    if (FileStatus file; status_of(given, file) == 0) {
        keys.push_back(std::to_string(file.volume) + ":" + std::to_string(file.number));
    }
    return keys;
}

void FilePlan::require_free(const File& file, const std::vector<std::string>& keys) const {
    for (const std::string& key : keys) {
        const auto at = files_.find(key);
        // Two inputs may be one, and two outputs be links to one file, of which each then gets its own.
        if (at == files_.end() ||
            (file.option.empty() ? at->second.option.empty() : !at->second.option.empty() && key != keys.front())) {
            continue;
        }
        const File& output = file.option.empty() ? at->second : file;
        const File& taken = file.option.empty() ? file : at->second;
        throw Failure(bad_usage, output.option + ": '" + output.path + "' is " + taken.what +
                                     when(is_standard(file.path), ", and standard output takes one of them"));
    }
}

void FilePlan::add(const File& file) {
    if (!file.path.empty() && !(is_standard(file.path) && file.option.empty())) {
        const std::vector<std::string> keys = keys_of(file.path);
        require_free(file, keys);
        for (const std::string& key : keys) {
            files_.emplace(key, file);
        }
    }
}

std::string mesh_help(const std::string& what) {
    return what + ": " + joined(format_names()) + "; gzip of any";
}

void declare_reading(CLI::App& command, MeshArguments& arguments) {
    const auto take = [&arguments](const std::string& text) {
        const auto* const unit = std::find_if(units.begin(), units.end(), [&](const Unit& one) { return one.name == text; });
        arguments.unit_mm = unit != units.end() ? unit->mm : parse_number(text);
        return arguments.unit_mm.value_or(0) > 0
                   ? ""
                   : "'" + text + "' is neither mm, um, cm, m, in, ft nor a positive number of mm";
    };
    add_parsed(command, "--unit", "mm|um|cm|m|in|ft|MM", "Unit of meshes that do not state one (default mm; glTF: m)", take)
        ->transform(in_lower_case);
    declare_options(command, arguments.options, "--grid");
    declare_running(command, arguments);
}

void declare_threads(CLI::App& command, int& threads) {
    add(command, "--threads", threads, "N", "Use at most N threads (0: all)")->check(CLI::Range(0, most_threads));
}

void declare_running(CLI::App& command, MeshArguments& arguments) {
    static constexpr std::array<std::string_view, 3> when = {"auto", "always", "never"};
    declare_threads(command, arguments.threads);
    add_choice(command, "--progress", when, "Progress bar on stderr (auto: on a terminal)", arguments.progress);
}

void declare_quiet(CLI::App& command, MeshArguments& arguments) {
    const auto hush = [&arguments] {
        arguments.quiet = true;
        arguments.progress = ProgressBar::When::never;
    };
    command.add_flag_callback("--quiet", hush, "Say nothing but warnings and errors")->excludes("--progress");
}

MeshFile read_mesh_of(const MeshArguments& arguments, Stages& stages) {
    const std::string name = arguments.name();
    if (arguments.map_file) {
        // Nothing is being written while the mesh is read, so there is nothing to tidy up.
        explain_bus_errors(complaint(name + ": shrank while it was read, or its disk failed"), bad_input);
    }
    const bool standard = is_standard(arguments.mesh);
    const ReadOptions options{.map_file = arguments.map_file,
                              .mm_per_unit = arguments.unit_mm.value_or(0),
                              .name = standard ? std::string_view(name) : "",
                              .all_roles = arguments.all_roles};
    const Stopwatch spooling;
    const File spooled = standard ? spooled_input() : File();
    const double spool_ms = standard ? spooling.ms() : 0;
    const std::filesystem::path path = standard ? spooled.path() : path_of(arguments.mesh);
    std::error_code unknown;
    const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
    const Amount amount{unknown ? 0 : static_cast<double>(bytes), "bytes"};
    Result<MeshFile> mesh =
        stages.run("reading", amount, [&](const Context& context) { return read_mesh(path, options, context); });
    if (!mesh) {
        const Failure failure = failure_of(mesh.error());
        // Where memory ran out there was none left to say in which file.
        throw mesh.error().code == ErrorCode::out_of_memory && std::string_view(failure.what()) == "out of memory"
            ? Failure(failure.status(), name + ": " + failure.what())
            : failure;
    }
    mesh->read_ms += spool_ms;
    if (arguments.unit_mm && mesh->states_unit) {
        mesh->warnings.push_back(name + ": states that its unit is " + exact_text(mesh->mm_per_unit) +
                                 " mm, which holds instead of --unit");
    }
    return std::move(mesh).value();
}

MeshFile read_mesh_and_warn(const MeshArguments& arguments, Stages& stages) {
    MeshFile mesh = read_mesh_of(arguments, stages);
    for (const std::string& warning : mesh.warnings) {
        warn(warning);
    }
    return mesh;
}

std::string description(const MeshFile& mesh) {
    std::string text = std::string(mesh.text ? "text" : "binary") + " " + std::string(name_of(mesh.format)) + ", " +
                       file_size_text(mesh.file_bytes) + (mesh.compressed ? " of gzip" : "");
    text += when(mesh.mm_per_unit != 1, ", in units of " + exact_text(mesh.mm_per_unit) + " mm");
    text +=
        when(mesh.patient_frame != PatientFrame::unstated, ", patient frame " + std::string(name_of(mesh.patient_frame)));
    return text;
}

std::vector<std::string> doubts_of_scale(const MeshArguments& arguments, const MeshFile& file, const MeasuredMesh& mesh) {
    std::vector<std::string> doubts;
    const auto add = [&](const std::string& text) { doubts.push_back(arguments.name() + ": " + text); };
    const std::optional<std::string> doubt = doubt_of_unit(mesh);
    if (doubt && !file.states_unit && !arguments.unit_mm) {
        add(*doubt);
    }
    const MeshScale scale = judge_scale(mesh.box, file.vertex_type, mesh.grid_mm);
    if (scale.coarse_grid) {
        add("the grid of " + exact_text(mesh.grid_mm) + " mm is coarse for a mesh of " + measure_text(scale.diagonal_mm) +
            " mm from corner to corner; " +
            (scale.finest_grid_mm < mesh.grid_mm
                 ? "--grid finest takes " + exact_text(scale.finest_grid_mm) + " mm"
                 : "none finer reaches the coordinate of " + measure_text(scale.farthest_mm) + " mm"));
    }
    const double farthest = mesh.farthest_mm.value_or(scale.farthest_mm);
    const Box there{{farthest, farthest, farthest}, {farthest, farthest, farthest}};
    const MeshScale stored = judge_scale(there, file.vertex_type, mesh.grid_mm, mesh.detail_mm);
    if (stored.coarse_numbers && !mesh.moved) {
        add("coordinates of up to " + measure_text(farthest) + " mm are stored in steps of " +
            measure_text(stored.number_step_mm) + " mm, more than a tenth of " + exact_text(mesh.detail_mm) +
            " mm, the layer height or voxel; it lost precision before it was read");
    }
    return doubts;
}

std::string joined_by_grid(const MeshCheck& info) {
    return info.exact_boundary_edges == info.boundary_edges
               ? ""
               : ", boundary edges " + grouped(info.boundary_edges) + " on it and " + grouped(info.exact_boundary_edges) +
                     " by exact coordinates";
}

std::vector<std::filesystem::directory_entry> entries_of(const std::filesystem::path& folder, std::error_code& problem) {
    std::vector<std::filesystem::directory_entry> entries;
    if (!can_list(folder)) {
        problem = std::make_error_code(std::errc::filename_too_long);
        return entries;
    }
    for (std::filesystem::directory_iterator at(folder, problem); !problem && at != std::filesystem::directory_iterator();
         at.increment(problem)) {
        entries.push_back(*at);
    }
    std::sort(entries.begin(), entries.end());
    return entries;
}

bool is_folder(const std::string& path) {
    std::error_code unknown;
    return !is_standard(path) && std::filesystem::is_directory(path_of(path), unknown);
}

std::vector<ListedMesh> meshes_at(const std::string& path) {
    std::vector<ListedMesh> meshes;
    if (!is_folder(path)) {
        return {{path, "", ""}};
    }
    add_meshes(path_of(path), "", meshes);
    if (meshes.empty()) {
        meshes.push_back({path, "", "is a folder in which no file is named as a mesh"});
    }
    return meshes;
}

void declare_mesh_list(CLI::App& command, MeshList& list) {
    add_text(command, "mesh", list.given, "MESH|FOLDER|-",
             mesh_help("Mesh files, folders with mesh files, or - for standard input; formats"))
        ->required();
    declare_reading(command, list.each);
}

bool MeshList::several() const {
    return given.size() > 1 || is_folder(given.front());
}

std::vector<ListedMesh> MeshList::meshes() const {
    refuse_if(std::count_if(given.begin(), given.end(), is_standard) > 1, bad_usage,
              "mesh: '-' is given twice, and standard input can be read once");
    std::vector<ListedMesh> all;
    for (const std::string& path : given) {
        const std::vector<ListedMesh> found = meshes_at(path);
        all.insert(all.end(), found.begin(), found.end());
    }
    return all;
}

std::optional<Failure> MeshList::for_each(Interrupt& interrupt, const std::function<void(const MeshArguments&)>& use,
                                          const std::function<void(const MeshArguments&, const Failure&)>& refuse) const {
    const std::vector<ListedMesh> all = meshes();
    ExitStatus worst = done;
    std::size_t refused = 0;
    for (const ListedMesh& entry : all) {
        MeshArguments mesh = each;
        mesh.mesh = entry.path;
        try {
            refuse_if(!entry.problem.empty(), bad_input, entry.path + ": " + entry.problem);
            use(mesh);
        } catch (const Failure& failure) {
            if (all.size() == 1 || failure.status() == bad_output) {
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
    return Failure(worst, grouped(refused) + " of " + counted(all.size(), "mesh", "meshes") + " could not be used");
}

}  // namespace lamella::cli
