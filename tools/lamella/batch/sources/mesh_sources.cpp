#include "batch/sources/mesh_sources.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <new>
#include <system_error>
#include <utility>

#include <glob.h>

#include "batch/sources/manifest.hpp"
#include "files/standard_streams.hpp"
#include "lamella/io/mesh_file.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

bool is_glob(const std::string& path) {
    std::error_code unknown;
    return path.find_first_of("*?[") != std::string::npos && !std::filesystem::exists(path, unknown);
}

std::vector<std::string> expanded(const std::string& pattern) {
    glob_t found{};
    const std::unique_ptr<glob_t, void (*)(glob_t*)> owner(&found, &::globfree);
    const int status = ::glob(pattern.c_str(), GLOB_ERR, nullptr, &found);
    if (status == GLOB_NOSPACE) {
        throw std::bad_alloc();
    }
    if (status != 0) {
        throw Failure(bad_input, pattern + (status == GLOB_NOMATCH ? ": no file has such a name" : ": cannot be listed"));
    }
    return {found.gl_pathv, found.gl_pathv + found.gl_pathc};
}

class SourceList {
public:
    explicit SourceList(const SliceWords& words) : words_(words) {}

    void add(const std::string& given) {
        if (is_standard(given)) {
            throw Failure(bad_usage, "'-' is one mesh, which lamella slice takes; a batch takes files");
        }
        if (!is_glob(given)) {
            return add_path(given);
        }
        for (const std::string& path : expanded(given)) {
            add_path(path);
        }
    }

    std::vector<MeshSource> meshes;

private:
    void add_path(const std::string& path) {
        std::error_code unknown;
        if (std::filesystem::is_directory(path, unknown)) {
            const std::size_t before = meshes.size();
            add_folder(path, "");
            if (meshes.size() == before) {
                throw Failure(bad_input, path + ": is a folder in which no file is named as a mesh");
            }
        } else if (is_named_as_manifest(path)) {
            for (ManifestRow& row : read_manifest(path, words_)) {
                meshes.push_back({std::move(row.path), "", std::move(row.values), std::move(row.place)});
            }
        } else {
            meshes.push_back({path, "", {}, ""});
        }
    }

    /// What is hidden is left out, and links to folders, which may lead back to one above them.
    void add_folder(const std::filesystem::path& folder, const std::filesystem::path& below) {
        std::error_code problem;
        std::vector<std::filesystem::directory_entry> found;
        for (std::filesystem::directory_iterator at(folder, problem);
             !problem && at != std::filesystem::directory_iterator(); at.increment(problem)) {
            found.push_back(*at);
        }
        if (problem) {
            throw Failure(bad_input, folder.string() + ": cannot be listed: " + problem.message());
        }
        std::sort(found.begin(), found.end());
        for (const std::filesystem::directory_entry& entry : found) {
            std::error_code unknown;
            const std::filesystem::path name = entry.path().filename();
            if (name.native().starts_with('.')) {
                continue;
            }
            if (!entry.is_directory(unknown)) {
                if (is_named_as_mesh(entry.path())) {
                    meshes.push_back({entry.path().string(), below.string(), {}, ""});
                }
            } else if (!entry.is_symlink(unknown)) {
                add_folder(entry.path(), below / name);
            }
        }
    }

    const SliceWords& words_;
};

}  // namespace

std::vector<MeshSource> list_sources(const std::vector<std::string>& given, const SliceWords& words) {
    SourceList list(words);
    for (const std::string& each : given) {
        list.add(each);
    }
    return std::move(list.meshes);
}

}  // namespace lamella::cli::batch
