#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include <glob.h>

#include "batch/batch.hpp"
#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "outputs/outputs.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

/// Not for items: the batch has its own, or gives them to its processes.
bool is_for_batch(const std::string& name) {
    return name == "mesh" || name == "--help" || name == "--progress" || name == "--memory" || name == "--hash";
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
    refuse_if(status != 0, bad_input, path + (status == GLOB_NOMATCH ? ": no file has such a name" : ": cannot be listed"));
    return {found.gl_pathv, found.gl_pathv + found.gl_pathc};
}

/// The name of an output that has places for that of the mesh: 'out/{parent}/{stem}.nii.gz'. For the mesh
/// a/b/liver.stl.gz found below the SOURCE a: {stem} is liver, {name} liver.stl.gz, {parent} b, {dir} b, the folder below
/// SOURCE.
std::string expand_pattern(const std::string& pattern, const MeshSource& mesh, const std::string& option) {
    const std::filesystem::path path(mesh.path);
    const std::map<std::string, std::string> words = {{"stem", mesh_name_of(mesh.path)},
                                                      {"name", path.filename().string()},
                                                      {"parent", path.parent_path().filename().string()},
                                                      {"dir", mesh.folder}};
    std::string text;
    std::size_t at = 0;
    for (std::size_t open = pattern.find('{'); open != std::string::npos; open = pattern.find('{', at)) {
        const std::size_t close = pattern.find('}', open);
        refuse_if(close == std::string::npos, bad_usage,
                  std::string(option).append(": '").append(pattern).append("': a { is not closed"));
        const auto word = words.find(pattern.substr(open + 1, close - open - 1));
        refuse_if(
            word == words.end(), bad_usage,
            option + ": '" + pattern.substr(open, close + 1 - open) + "' is not one of {stem}, {name}, {parent}, {dir}");
        text += pattern.substr(at, open - at) + (word->second.empty() ? "." : word->second);
        at = close + 1;
    }
    return std::filesystem::path(text + pattern.substr(at)).lexically_normal().string();
}

/// An item's options as slice takes them. Items of a SOURCE that is no manifest have them alike.
struct ParsedOptions {
    SliceArguments arguments;
    Item item;  ///< what follows from them for every mesh
};

/// Throws Failure (bad_usage) if slice would refuse these options.
ParsedOptions parsed(const OptionValues& values) {
    ParsedOptions options;
    const SliceArguments& arguments = options.arguments;
    Item& item = options.item;
    CLI::App app;
    declare(app, options.arguments);
    std::vector<std::string> typed = {"mesh"};  // the last word comes first
    for (const auto& [name, all] : values) {
        const bool flag = is_flag(*app.get_option(name));
        const bool plain = name == "--map" || name == "--band" || name == "--form";
        for (std::size_t i = all.size(); i-- > 0;) {
            typed.push_back(flag ? name : std::string(name).append("=").append(all[i]));
            item.plain.insert(item.plain.end(), plain ? 1 : 0, typed.back());
        }
    }
    try {
        app.parse(typed);
    } catch (const CLI::ParseError& error) {
        throw Failure(bad_usage, error.what());
    }
    for (const RecordedOption& option : recorded_options(app)) {
        item.words.push_back(option.name + (option.value ? "=" + *option.value : ""));
        if (option.names_file()) {
            item.option_files.push_back(*option.value);
        }
    }
    item.threads = arguments.threads;
    refuse_if(arguments.outputs.outputs.empty(), bad_usage, "--output: none is given, such as -o 'out/{stem}.nii.gz'");
    require_together(planned_outputs(arguments.outputs), arguments.outputs, arguments.mesh_count(), arguments.image);
    return options;
}

Item planned_item(const MeshSource& source, const ParsedOptions& options) {
    const SliceArguments& arguments = options.arguments;
    Item item = options.item;
    item.mesh = source.path;
    item.place = source.place;
    OutputArguments outputs{.outputs = {}, .to = arguments.outputs.to};
    for (const std::string& pattern : arguments.outputs.outputs) {
        outputs.outputs.push_back(expand_pattern(pattern, source, "--output"));
        item.writes.push_back("--output=" + outputs.outputs.back());
    }
    if (!outputs.to.empty()) {
        item.writes.push_back("--to=" + outputs.to);
    }
    if (!arguments.report.empty()) {
        item.report = expand_pattern(arguments.report, source, "--report");
        item.writes.push_back("--report=" + item.report);
    }
    const std::vector<PlannedOutput> planned = planned_outputs(outputs);
    for (const std::filesystem::path& file : files_of(planned, arguments.split)) {
        item.files.push_back(file.string());
    }
    refuse_if(is_standard(item.report) || std::any_of(outputs.outputs.begin(), outputs.outputs.end(), is_standard),
              bad_usage, "'-': a batch writes files");
    return item;
}

/// What is wrong with a row of a manifest is wrong with a file.
Failure failure_at(const std::string& place, ExitStatus status, const std::string& what) {
    return place.empty() ? Failure(status, what) : Failure(bad_input, place + ": " + what);
}

/// In all of the batch no file is written twice, and none is an input.
void require_distinct(const std::vector<Item>& items, const std::vector<std::string>& own_files) {
    std::unordered_map<std::string, const Item*> writers;
    for (const Item& item : items) {
        for (const std::string& file : item.all_files()) {
            const auto [at, added] = writers.emplace(place_of(file), &item);
            if (!added) {
                throw failure_at(item.place, bad_usage,
                                 "'" + at->second->mesh + "' and '" + item.mesh + "' both write '" + file +
                                     "'; {parent} or {dir} in --output tells them apart");
            }
        }
    }
    const auto require_unwritten = [&writers](const std::vector<std::string>& files, const std::string& what) {
        for (const std::string& file : files) {
            if (const auto written = writers.find(place_of(file)); written != writers.end()) {
                throw failure_at(written->second->place, bad_usage,
                                 std::string("--output: '").append(file).append("' is ").append(what));
            }
        }
    };
    require_unwritten(own_files, "a file of the batch itself");
    for (const Item& item : items) {
        require_unwritten({item.mesh}, "a mesh of the batch itself");
        require_unwritten(item.option_files, "a file that an option of the batch names");
    }
}

}  // namespace

std::string SliceOptionNames::name_of(const std::string& text) const {
    std::string name = text.substr(std::min(text.find_first_not_of('-'), text.size()));
    std::replace(name.begin(), name.end(), '_', '-');
    const CLI::Option* const found =
        name.empty() ? nullptr : prototype_.get_option_no_throw((name.size() == 1 ? "-" : "--") + name);
    return found == nullptr || is_for_batch(found->get_name()) ? std::string() : found->get_name();
}

OptionValues SliceOptionNames::typed(const CLI::App& command) const {
    OptionValues values;
    for (const CLI::Option* given : command.get_options()) {
        const std::string name = given->get_name();
        if (given->count() > 0 && prototype_.get_option_no_throw(name) != nullptr && !is_for_batch(name)) {
            values[name] = is_flag(*given) ? std::vector<std::string>{"true"} : given->results();
        }
    }
    return values;
}

std::vector<std::string> Item::all_files() const {
    std::vector<std::string> all = files;
    all.insert(all.end(), report.empty() ? 0 : 1, report);
    return all;
}

std::vector<MeshSource> list_sources(const std::vector<std::string>& given, const SliceOptionNames& names) {
    std::vector<MeshSource> sources;
    for (const std::string& each : given) {
        refuse_if(is_standard(each), bad_usage, "'-' is one mesh, which lamella slice takes; a batch takes files");
        for (const std::string& path : expanded(each)) {
            if (is_named_as_manifest(path) && !is_folder(path)) {
                const std::vector<MeshSource> rows = read_manifest(path, names);
                sources.insert(sources.end(), rows.begin(), rows.end());
                continue;
            }
            for (const ListedMesh& mesh : meshes_at(path)) {
                refuse_if(!mesh.problem.empty(), bad_input, mesh.path + ": " + mesh.problem);
                sources.push_back({mesh.path, mesh.folder, {}, ""});
            }
        }
    }
    return sources;
}

std::vector<Item> plan_items(const std::vector<MeshSource>& sources, const OptionValues& common,
                             const std::vector<std::string>& own_files) {
    std::vector<Item> items;
    items.reserve(sources.size());
    std::optional<ParsedOptions> of_all;
    for (const MeshSource& source : sources) {
        try {
            if (source.values.empty()) {
                of_all = of_all ? std::move(of_all) : parsed(common);
                items.push_back(planned_item(source, *of_all));
                continue;
            }
            OptionValues values = common;
            for (const auto& [name, own] : source.values) {  // an empty one takes a flag back
                values[name] = own;
            }
            items.push_back(planned_item(source, parsed(values)));
        } catch (const Failure& failure) {
            throw failure_at(source.place, failure.status(), failure.what());
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
