#include "batch/plan.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <new>
#include <system_error>
#include <unordered_map>
#include <utility>

#include <glob.h>

#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "outputs/output_checks.hpp"
#include "outputs/output_formats.hpp"
#include "outputs/recorded_options.hpp"
#include "outputs/write_outputs.hpp"
#include "slice/slice_arguments.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

/// Not for items: the batch has its own, or gives them to its processes.
bool is_for_batch(const std::string& name) {
    static const std::vector<std::string> kept = {"mesh", "--help", "--progress", "--memory", "--hash"};
    return std::find(kept.begin(), kept.end(), name) != kept.end();
}

/// The path itself, unless it is a pattern and no file.
std::vector<std::string> expanded(const std::string& path) {
    std::error_code unknown;
    if (path.find_first_of("*?[") == std::string::npos || std::filesystem::exists(path, unknown)) {
        return {path};
    }
    glob_t found{};
    const std::unique_ptr<glob_t, void (*)(glob_t*)> owner(&found, &::globfree);
    const int status = ::glob(path.c_str(), GLOB_ERR, nullptr, &found);
    if (status == GLOB_NOSPACE) {
        throw std::bad_alloc();
    }
    if (status != 0) {
        throw Failure(bad_input, path + (status == GLOB_NOMATCH ? ": no file has such a name" : ": cannot be listed"));
    }
    return {found.gl_pathv, found.gl_pathv + found.gl_pathc};
}

void add_sources(const std::string& path, const SliceWords& words, std::vector<MeshSource>& sources) {
    std::error_code unknown;
    if (std::filesystem::is_directory(path, unknown)) {
        for (const ListedMesh& mesh : meshes_below(path)) {
            if (!mesh.problem.empty()) {
                throw Failure(bad_input, mesh.path + ": " + mesh.problem);
            }
            sources.push_back({mesh.path, mesh.folder, {}, ""});
        }
    } else if (is_named_as_manifest(path)) {
        const std::vector<MeshSource> rows = read_manifest(path, words);
        sources.insert(sources.end(), rows.begin(), rows.end());
    } else {
        sources.push_back({path, "", {}, ""});
    }
}

/// Text for the word in braces. For the mesh a/b/liver.stl.gz found below the SOURCE a: {stem} is liver, {name}
/// liver.stl.gz, {parent} b, {dir} b, the folder below SOURCE.
std::string word_for(const std::string& word, const MeshSource& mesh, const std::string& option) {
    const std::filesystem::path path(mesh.path);
    if (word == "stem") {
        return mesh_name_of(mesh.path);
    }
    if (word == "name") {
        return path.filename().string();
    }
    if (word == "parent" || word == "dir") {
        const std::string folder = word == "dir" ? mesh.folder : path.parent_path().filename().string();
        return folder.empty() ? "." : folder;
    }
    throw Failure(bad_usage, option + ": '{" + word + "}' is not one of {stem}, {name}, {parent}, {dir}");
}

/// The name of an output that has places for that of the mesh: 'out/{parent}/{stem}.nii.gz'.
std::string expand_pattern(const std::string& pattern, const MeshSource& mesh, const std::string& option) {
    std::string text;
    std::size_t at = 0;
    for (std::size_t open = pattern.find('{'); open != std::string::npos; open = pattern.find('{', at)) {
        const std::size_t close = pattern.find('}', open);
        if (close == std::string::npos) {
            throw Failure(bad_usage, std::string(option).append(": '").append(pattern).append("': a { is not closed"));
        }
        text += pattern.substr(at, open - at) + word_for(pattern.substr(open + 1, close - open - 1), mesh, option);
        at = close + 1;
    }
    return std::filesystem::path(text + pattern.substr(at)).lexically_normal().string();
}

using Values = std::vector<std::string>;

const Values& values_of(const OptionValues& all, const std::string& name) {
    static const Values none;
    const auto found = all.find(name);
    return found == all.end() ? none : found->second;
}

std::string value_of(const OptionValues& all, const std::string& name) {
    const Values& values = values_of(all, name);
    return values.empty() ? std::string() : values.back();
}

/// An option of the manifest takes the place of the one typed.
OptionValues merged(OptionValues common, const OptionValues& own) {
    for (const auto& [name, values] : own) {
        common[name] = values;
    }
    std::erase_if(common, [](const auto& option) { return option.second.empty(); });
    return common;
}

/// --like and --transform name files; --planes does where no list of numbers stands there.
Values files_named_by(const OptionValues& values) {
    Values files;
    for (const char* name : {"--like", "--transform", "--planes"}) {
        const std::string path = value_of(values, name);
        std::error_code unknown;
        if (!path.empty() && (std::string_view(name) != "--planes" || std::filesystem::exists(path, unknown))) {
            files.push_back(path);
        }
    }
    return files;
}

/// The options that results and records hold.
OptionValues recorded(OptionValues values) {
    for (const ChangedDefault& changed : changed_defaults) {
        values.try_emplace(std::string(changed.name), Values{std::string(changed.now)});
    }
    std::erase_if(values, [](const auto& option) { return !is_recorded(option.first); });
    return values;
}

OptionValues plain(OptionValues values) {
    std::erase_if(values, [](const auto& option) {
        return option.first != "--map" && option.first != "--band" && option.first != "--form";
    });
    return values;
}

void plan_outputs(Item& item, const OptionValues& values, const MeshSource& source) {
    for (const std::string& pattern : values_of(values, "--output")) {
        item.outputs.push_back(expand_pattern(pattern, source, "--output"));
    }
    if (item.outputs.empty()) {
        throw Failure(bad_usage, "--output: none is given, such as -o 'out/{stem}.nii.gz'");
    }
    item.to = value_of(values, "--to");
    item.report = value_of(values, "--report");
    if (!item.report.empty()) {
        item.report = expand_pattern(item.report, source, "--report");
    }
    const bool several_meshes = !value_of(values, "--split").empty();
    for (const PlannedOutput& output : planned_outputs(item.outputs, item.to)) {
        if (is_standard(output.path) || is_standard(item.report)) {
            throw Failure(bad_usage, "'-': a batch writes files");
        }
        const std::vector<std::string> files = output.files(several_meshes);
        item.files.insert(item.files.end(), files.begin(), files.end());
    }
}

Item planned_item(const MeshSource& source, const OptionValues& values, const SliceWords& words) {
    Item item;
    item.mesh = source.path;
    item.place = source.place;
    plan_outputs(item, values, source);
    item.option_files = files_named_by(values);
    item.words = words.words(recorded(values));
    item.plain = words.words(plain(values));
    if (const std::string threads = value_of(values, "--threads"); !threads.empty()) {
        (void)std::from_chars(threads.data(), threads.data() + threads.size(), item.threads.emplace());
    }
    return item;
}

std::string before(const std::string& place) {
    return place.empty() ? "" : place + ": ";
}

/// In all of the batch no file is written twice, and none is an input.
void require_distinct(const std::vector<Item>& items, const std::vector<std::string>& own_files) {
    std::unordered_map<std::string, const Item*> writers;
    for (const Item& item : items) {
        for (const std::string& file : item.all_files()) {
            const auto [at, added] = writers.emplace(place_of(file), &item);
            if (!added) {
                throw Failure(bad_usage, before(item.place) + "'" + at->second->mesh + "' and '" + item.mesh +
                                             "' both write '" + file + "'; {parent} or {dir} in --output tells them apart");
            }
        }
    }
    const auto require_unwritten = [&writers](const std::string& file, const std::string& what) {
        if (const auto written = writers.find(place_of(file)); written != writers.end()) {
            throw Failure(bad_usage, before(written->second->place) + "--output: '" + file + "' is " + what);
        }
    };
    for (const std::string& file : own_files) {
        require_unwritten(file, "a file of the batch itself");
    }
    for (const Item& item : items) {
        require_unwritten(item.mesh, "a mesh of the batch itself");
        for (const std::string& file : item.option_files) {
            require_unwritten(file, "a file that an option of the batch names");
        }
    }
}

}  // namespace

SliceWords::SliceWords() {
    SliceArguments arguments;
    declare(prototype_, arguments);  // Nothing is ever parsed by it: what it refers to may go.
}

std::string SliceWords::name_of(const std::string& text) const {
    std::string name = text.substr(std::min(text.find_first_not_of('-'), text.size()));
    std::replace(name.begin(), name.end(), '_', '-');
    const CLI::Option* const found =
        name.empty() ? nullptr : prototype_.get_option_no_throw((name.size() == 1 ? "-" : "--") + name);
    return found == nullptr || is_for_batch(found->get_name()) ? std::string() : found->get_name();
}

std::vector<std::string> SliceWords::names_without_memory() const {
    std::vector<std::string> names;
    for (const CLI::Option* excluded : option("--memory").get_excludes()) {
        names.push_back(excluded->get_name());
    }
    names.emplace_back("--report");
    return names;
}

OptionValues SliceWords::typed(const CLI::App& command) const {
    OptionValues values;
    for (const CLI::Option* given : command.get_options()) {
        const std::string name = given->get_name();
        if (given->count() > 0 && prototype_.get_option_no_throw(name) != nullptr && !is_for_batch(name)) {
            values[name] = is_flag(*given) ? std::vector<std::string>{"true"} : given->results();
        }
    }
    return values;
}

std::vector<std::string> SliceWords::words(const OptionValues& values) const {
    std::vector<std::string> words;
    for (const CLI::Option* known : prototype_.get_options()) {
        const std::string name = known->get_name();
        const auto found = values.find(name);
        if (found == values.end()) {
            continue;
        }
        for (const std::string& value : found->second) {
            words.push_back(is_flag(*known) ? name : std::string(name).append("=").append(value));
        }
    }
    return words;
}

void SliceWords::require_accepted(const OptionValues& values) const {
    CLI::App app;
    SliceArguments arguments;
    declare(app, arguments);
    std::vector<std::string> typed = words(values);
    typed.emplace_back("mesh");
    std::reverse(typed.begin(), typed.end());
    try {
        app.parse(typed);
    } catch (const CLI::ParseError& error) {
        throw Failure(bad_usage, error.what());
    }
    (void)options_of(arguments);
    const OutputArguments& outputs = arguments.outputs;
    if (!outputs.outputs.empty()) {
        require_together(planned_outputs(outputs.outputs, outputs.to), outputs, arguments.mesh_count(),
                         arguments.image.given(), arguments.image.subslices);
    }
}

std::vector<std::string> Item::all_files() const {
    std::vector<std::string> all = files;
    if (!report.empty()) {
        all.push_back(report);
    }
    return all;
}

std::vector<MeshSource> list_sources(const std::vector<std::string>& given, const SliceWords& words) {
    std::vector<MeshSource> sources;
    for (const std::string& each : given) {
        if (is_standard(each)) {
            throw Failure(bad_usage, "'-' is one mesh, which lamella slice takes; a batch takes files");
        }
        for (const std::string& path : expanded(each)) {
            add_sources(path, words, sources);
        }
    }
    return sources;
}

std::vector<Item> plan_items(const std::vector<MeshSource>& sources, const OptionValues& common, const SliceWords& words,
                             const std::vector<std::string>& own_files) {
    std::vector<Item> items;
    for (const MeshSource& source : sources) {
        const OptionValues values = source.values.empty() ? common : merged(common, source.values);
        try {
            if (!source.values.empty() || items.empty()) {
                words.require_accepted(values);
            }
            items.push_back(planned_item(source, values, words));
        } catch (const Failure& failure) {
            throw Failure(failure.status(), before(source.place) + failure.what());
        }
    }
    require_distinct(items, own_files);
    return items;
}

std::string fixed_folder(const std::string& pattern) {
    const std::string folder = std::filesystem::path(pattern.substr(0, pattern.find('{'))).parent_path().string();
    return folder.empty() ? "." : folder;
}

}  // namespace lamella::cli::batch
