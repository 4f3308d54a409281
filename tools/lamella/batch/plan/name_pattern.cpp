#include "batch/plan/name_pattern.hpp"

#include <algorithm>
#include <filesystem>

#include "outputs/write_outputs.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

std::string word_of(const std::string& word, const MeshSource& mesh, const std::string& option) {
    const std::filesystem::path path(mesh.path);
    if (word == "stem") {
        return mesh_name_of(mesh.path);
    }
    if (word == "name") {
        return path.filename().string();
    }
    if (word == "parent") {
        const std::string parent = path.parent_path().filename().string();
        return parent.empty() ? "." : parent;
    }
    if (word == "dir") {
        return mesh.folder.empty() ? "." : mesh.folder;
    }
    throw Failure(bad_usage, option + ": '{" + word + "}' is not one of {stem}, {name}, {parent}, {dir}");
}

Failure unclosed(const std::string& pattern, const std::string& option) {
    return {bad_usage, option + ": '" + pattern + "': a { is not closed"};
}

}  // namespace

std::string expand_pattern(const std::string& pattern, const MeshSource& mesh, const std::string& option) {
    std::string text;
    for (std::size_t at = 0; at < pattern.size();) {
        const std::size_t open = std::min(pattern.find('{', at), pattern.size());
        const std::size_t close = pattern.find('}', open);
        text += pattern.substr(at, open - at);
        if (open < pattern.size() && close == std::string::npos) {
            throw unclosed(pattern, option);
        }
        if (open < pattern.size()) {
            text += word_of(pattern.substr(open + 1, close - open - 1), mesh, option);
        }
        at = open < pattern.size() ? close + 1 : pattern.size();
    }
    return std::filesystem::path(text).lexically_normal().string();
}

std::string fixed_folder(const std::string& pattern) {
    const std::string fixed = pattern.substr(0, pattern.find('{'));
    const std::string folder = std::filesystem::path(fixed).parent_path().string();
    return folder.empty() ? "." : folder;
}

}  // namespace lamella::cli::batch
