#include "files/mesh_list.hpp"

#include <algorithm>

#include "files/streams.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

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
