#include "files/mesh_list.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "files/standard_streams.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

bool is_folder(const std::string& path) {
    std::error_code unknown;
    return !is_standard(path) && std::filesystem::is_directory(path, unknown);
}

bool is_hidden(const std::filesystem::path& path) {
    return path.filename().native().starts_with('.');
}

}  // namespace

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
            add_folder(path);
        } else {
            entries_.push_back({path, ""});
        }
    }
}

void MeshList::add_folder(const std::string& path) {
    const std::size_t before = entries_.size();
    add_contents(path);
    if (entries_.size() == before) {
        entries_.push_back({path, "is a folder in which no file is named as a mesh"});
    }
}

void MeshList::add_contents(const std::string& folder) {
    std::error_code problem;
    std::vector<std::filesystem::directory_entry> found;
    for (std::filesystem::directory_iterator at(folder, problem); !problem && at != std::filesystem::directory_iterator();
         at.increment(problem)) {
        found.push_back(*at);
    }
    if (problem) {
        entries_.push_back({folder, "cannot be listed: " + problem.message()});
    }
    std::sort(found.begin(), found.end());
    for (const std::filesystem::directory_entry& entry : found) {
        std::error_code unknown;
        if (is_hidden(entry.path())) {
            continue;
        }
        // A link to a folder may lead back to one above it.
        if (entry.is_directory(unknown)) {
            if (!entry.is_symlink(unknown)) {
                add_contents(entry.path().string());
            }
        } else if (is_named_as_mesh(entry.path())) {
            entries_.push_back({entry.path().string(), ""});
        }
    }
}

std::vector<std::string> MeshList::paths() const {
    std::vector<std::string> paths;
    for (const Entry& entry : entries_) {
        paths.push_back(entry.path);
    }
    return paths;
}

std::optional<Failure> MeshList::for_each(Interrupt& interrupt, const Use& use, const Refuse& refuse) const {
    ExitStatus worst = done;
    std::size_t refused = 0;
    for (const Entry& entry : entries_) {
        MeshArguments mesh = each_;
        mesh.mesh = entry.path;
        try {
            if (!entry.problem.empty()) {
                throw Failure(bad_input, entry.path + ": " + entry.problem);
            }
            use(mesh);
        } catch (const Failure& failure) {
            if (entries_.size() == 1 || failure.status() == bad_output) {
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
    return Failure(worst, grouped(refused) + " of " + counted(entries_.size(), "mesh", "meshes") + " could not be used");
}

}  // namespace lamella::cli
