// From what was typed to items: sources are listed, manifests read, options parsed as slice parses them.
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "batch/batch.hpp"
#include "files/mesh_input.hpp"
#include "io/text/csv.hpp"
#include "outputs/outputs.hpp"
#include "system/terminal.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

/// Values by the option's name with its dashes, "--layer-height"; a flag has the value "true", or none to take it back.
using OptionValues = std::map<std::string, std::vector<std::string>>;

/// The options of `lamella slice` that an item may have, but for those that the batch has itself or gives to its processes.
struct ItemOptions {
    SliceArguments arguments;
    CLI::App app;

    ItemOptions() {
        declare(app, arguments);
        app.set_help_flag();
        for (const char* const own : {"--quiet", "--progress", "--memory", "--hash"}) {
            app.remove_option(app.get_option(own));
        }
    }

    /// The name with dashes of "layer-height", "layer_height" or "--layer-height"; empty if there is no such option.
    std::string name_of(const std::string& text) const {
        std::string name = text.substr(std::min(text.find_first_not_of('-'), text.size()));
        std::replace(name.begin(), name.end(), '_', '-');
        const CLI::Option* const found =
            name.empty() ? nullptr : app.get_option_no_throw((name.size() == 1 ? "-" : "--") + name);
        return found == nullptr ? std::string() : found->get_name();
    }

    /// Those typed for `command`, which has these options and more.
    OptionValues typed(const CLI::App& command) const {
        OptionValues values;
        for (const CLI::Option* const option : app.get_options()) {
            const CLI::Option& given = *command.get_option(option->get_name());
            if (given.count() > 0 && !given.get_positional()) {
                values[given.get_name()] = is_flag(given) ? std::vector<std::string>{"true"} : given.results();
            }
        }
        return values;
    }

    /// Sets `arguments`. Throws Failure (bad_usage) if slice would refuse these values.
    void parse(const OptionValues& values) {
        std::vector<std::string> typed = {"mesh"};  // the last word comes first
        for (const auto& [name, all] : values) {
            for (std::size_t i = all.size(); i-- > 0;) {
                typed.push_back(is_flag(*app.get_option(name)) ? name : std::string(name).append("=").append(all[i]));
            }
        }
        try {
            app.parse(typed);
        } catch (const CLI::ParseError& error) {
            throw Failure(bad_usage, error.what());
        }
        const OutputArguments& outputs = arguments.outputs;
        refuse_if(outputs.outputs.empty(), bad_usage, "--output: none is given, such as -o 'out/{stem}.nii.gz'");
        require_together(planned_outputs(outputs), outputs, arguments.mesh_count(), arguments.image);
    }
};

struct MeshSource {
    std::string path;
    std::string folder{};   ///< of the mesh below the SOURCE that is a folder; empty where that is the folder itself
    OptionValues values{};  ///< of a manifest, in place of those that were typed
    std::string place{};    ///< FILE:LINE of a manifest, else empty
};

// --- manifests

/// For messages.
std::string name_of_separator(char separator) {
    return separator == '\t' ? "tabs" : std::string(1, separator);
}

/// A list of meshes with options for each: CSV with a line of names, or JSON Lines.
///
///     path,layer-height,like            {"path": "liver.stl", "layer-height": 0.5, "like": "ct.nii.gz"}
///     liver.stl,0.5,ct.nii.gz           {"path": "skull.stl", "spacing": [1, 1, 2], "coverage": true}
///     skull.stl,,
///
/// The names may be separated by semicolons or tabs; then so is the rest, and one number may have a decimal comma: 0,5. An
/// empty cell or null leaves the option as the command line has it. Throws Failure (bad_input) naming the file and the line.
class Manifest {
public:
    Manifest(const std::string& path, const ItemOptions& options) : path_(path), options_(options), text_(read_text(path)) {}

    std::vector<MeshSource> rows() {
        path_.ends_with(".csv") ? read_table() : read_json_lines();
        refuse_if(rows_.empty(), bad_input, path_ + ": no meshes");
        return std::move(rows_);
    }

private:
    void refuse_at(std::size_t line, bool wrong, const std::string& what) const {
        refuse_if(wrong, bad_input, path_ + ":" + std::to_string(line) + ": " + what);
    }

    const CLI::Option& option(const std::string& name) const { return *options_.app.get_option(name); }

    /// The name of an option, or "" where the word names the mesh itself. Adds it to those that were `named`.
    std::string name_of(const std::string& word, std::size_t line, std::set<std::string>& named) const {
        const bool mesh = word == "path" || word == "mesh";
        std::string name = mesh ? "" : options_.name_of(word);
        refuse_at(line, !mesh && name.empty(), "'" + word + "' is neither path nor an option of lamella slice");
        refuse_at(line, !named.insert(name).second, "'" + word + "' stands there twice");
        return name;
    }

    /// Values by words.
    void add_row(const nlohmann::json& object, std::size_t line) {
        MeshSource row{.path = {}, .place = path_ + ":" + std::to_string(line)};
        std::set<std::string> named;
        for (const auto& [word, value] : object.items()) {
            const std::string name = name_of(word, line, named);
            if (value.is_null()) {
                continue;
            }
            std::vector<std::string> values = values_of(name, word, value, line);
            if (name.empty()) {
                row.path = values.front();
                continue;
            }
            if (is_flag(option(name))) {
                const std::string text = values.front();
                const bool is_set = text == "true" || text == "1" || text == "yes";
                refuse_at(line, !is_set && text != "false" && text != "0" && text != "no",
                          std::string(name).append(": '").append(text).append("' is neither true nor false"));
                values = is_set ? std::vector<std::string>{"true"} : std::vector<std::string>();
            }
            row.values[name] = std::move(values);
        }
        refuse_at(line, row.path.empty(), "no path of a mesh");
        refuse_at(line, is_standard(row.path), "'-' is no path: a batch takes files");
        rows_.push_back(std::move(row));
    }

    /// Comma, semicolon or tab: what separates the names in the first line, which must not be several of them; comma where
    /// there is one name.
    char separator() const {
        const std::string_view line = std::string_view(text_).substr(0, text_.find_first_of("\r\n"));
        char found = 0;
        for (const char separator : {',', ';', '\t'}) {
            if (line.find(separator) != std::string_view::npos) {
                refuse_at(1, found != 0,
                          "the names are separated by " + name_of_separator(found) + " and by " +
                              name_of_separator(separator) + ": one of them has to separate all");
                found = separator;
            }
        }
        return found == 0 ? ',' : found;
    }

    /// A decimal comma as a point, where no list can be meant.
    std::string number_in(const std::string& name, const std::string& value, char separator, std::size_t line) const {
        if (name.empty() || !is_decimal_comma(value)) {
            return value;
        }
        const bool one_number = option(name).get_type_name().starts_with("MM");
        refuse_at(
            line, !one_number && separator != ',',
            name + ": '" + value + "' is one number or two: write " + with_point(value) + ", or a blank after the comma");
        return one_number ? with_point(value) : value;
    }

    void read_table() {
        const char separator = this->separator();
        const auto refuse = [this](std::size_t line, const char* what) { refuse_at(line, true, what); };
        const std::vector<CsvRow> rows = read_csv(text_, separator, refuse);
        if (rows.empty()) {
            return;
        }
        const CsvRow& first = rows.front();
        std::vector<std::string> columns;
        std::set<std::string> named;
        for (std::size_t i = 0; !first.is_empty(i); ++i) {
            columns.push_back(name_of(first.cells[i], first.line, named));
        }
        refuse_at(first.line, !named.contains(""), "no column is named path");
        for (auto row = rows.begin() + 1; row != rows.end(); ++row) {
            refuse_at(row->line, row->cells.size() < columns.size() || !row->is_empty(columns.size()),
                      counted(row->cells.size(), "cell") + " where the first line names " +
                          counted(columns.size(), "column") + " separated by " + name_of_separator(separator) +
                          ": quotes keep a cell that holds one whole");
            nlohmann::json object = nlohmann::json::object();
            for (std::size_t i = 0; i < columns.size(); ++i) {
                if (!row->cells[i].empty()) {
                    object[first.cells[i]] = text_of_name(number_in(columns[i], row->cells[i], separator, row->line));
                }
            }
            add_row(object, row->line);
        }
    }

    void read_json_lines() {
        std::size_t line = 0;
        for (const std::string_view row : split(text_, '\n')) {
            ++line;
            if (row.find_first_not_of(" \t\r") == std::string_view::npos) {
                continue;
            }
            const nlohmann::json object = nlohmann::json::parse(row, nullptr, false);
            refuse_at(line, !object.is_object(), "not a JSON object");
            add_row(object, line);
        }
    }

    /// A list is repeated where the option may be, else joined by commas.
    std::vector<std::string> values_of(const std::string& name, const std::string& key, const nlohmann::json& value,
                                       std::size_t line) const {
        if (!value.is_array()) {
            return {scalar(key, value, line)};
        }
        refuse_at(line, value.empty() || name.empty(), "'" + key + "' is a list" + (value.empty() ? " of nothing" : ""));
        std::vector<std::string> values;
        values.reserve(value.size());
        for (const nlohmann::json& each : value) {
            values.push_back(scalar(key, each, line));
        }
        const bool repeats = option(name).get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
        return repeats ? values : std::vector<std::string>{joined(values, ",")};
    }

    std::string scalar(const std::string& key, const nlohmann::json& value, std::size_t line) const {
        refuse_at(line, !value.is_primitive() || value.is_null(),
                  "'" + key + "' is neither text, a number nor true or false");
        return value.is_string()         ? name_of_text(value.get<std::string>())
               : value.is_number_float() ? exact_text(value.get<double>())
                                         : value.dump();
    }

    const std::string& path_;
    const ItemOptions& options_;
    std::string text_;
    std::vector<MeshSource> rows_;
};

// --- sources

/// The path itself, unless it is a pattern and no file.
std::vector<std::string> expanded(const std::string& path) {
    std::error_code unknown;
    if (path.find_first_of("*?[") == std::string::npos || std::filesystem::exists(path_of(path), unknown)) {
        return {path};
    }
    std::optional<std::vector<std::string>> found = expand_glob(path);
    refuse_if(!found || found->empty(), bad_input, path + (found ? ": no file has such a name" : ": cannot be listed"));
    return std::move(*found);
}

/// The meshes of SOURCE..., files, folders, globs and manifests, in the order of the sources; a folder's in the order of
/// names, folders in it included. A mesh need not exist: that is for its item to say. Adds the manifests to `files`.
std::vector<MeshSource> list_sources(const std::vector<std::string>& given, const ItemOptions& options, FilePlan& files) {
    std::vector<MeshSource> sources;
    for (const std::string& each : given) {
        refuse_if(is_standard(each), bad_usage, "'-' is one mesh, which lamella slice takes; a batch takes files");
        for (const std::string& path : expanded(each)) {
            if ((path.ends_with(".csv") || path.ends_with(".jsonl")) && !is_folder(path)) {
                files.reads(path, "a file of the batch");
                std::vector<MeshSource> rows = Manifest(path, options).rows();
                std::move(rows.begin(), rows.end(), std::back_inserter(sources));
                continue;
            }
            for (const ListedMesh& mesh : meshes_at(path)) {
                refuse_if(!mesh.problem.empty(), bad_input, mesh.path + ": " + mesh.problem);
                sources.push_back({.path = mesh.path, .folder = mesh.folder});
            }
        }
    }
    return sources;
}

// --- items

/// The name of an output that has places for that of the mesh: 'out/{parent}/{stem}.nii.gz'. For the mesh
/// a/b/liver.stl.gz found below the SOURCE a: {stem} is liver, {name} liver.stl.gz, {parent} b, {dir} b, the folder below
/// SOURCE.
std::string expand_pattern(const std::string& pattern, const MeshSource& mesh, const std::string& option) {
    const std::filesystem::path path = path_of(mesh.path);
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
        refuse_if(pattern.compare(open, 6, "{layer") == 0, bad_usage,
                  option + ": '" + pattern.substr(open, close + 1 - open) +
                      "': a batch writes the layers of a mesh to one file; lamella slice writes a file a layer");
        refuse_if(
            word == words.end(), bad_usage,
            option + ": '" + pattern.substr(open, close + 1 - open) + "' is not one of {stem}, {name}, {parent}, {dir}");
        text += pattern.substr(at, open - at) + (word->second.empty() ? "." : word->second);
        at = close + 1;
    }
    return path_of(text + pattern.substr(at)).lexically_normal().string();
}

/// What items with the same options share.
Item item_with(const ItemOptions& options) {
    Item item;
    item.threads = options.arguments.threads;
    for (const RecordedOption& option : recorded_options(options.app)) {
        item.words.push_back(option.name + (option.value ? "=" + *option.value : ""));
        if (option.names_file()) {
            item.option_files.push_back(*option.value);
        }
    }
    for (const char* const name : {"--map", "--band", "--form"}) {
        if (const CLI::Option& option = *options.app.get_option(name); option.count() > 0) {
            item.plain.push_back(name + when(!is_flag(option), "=" + option.results().front()));
        }
    }
    return item;
}

/// `item`: item_with() the options.
Item item_of(const MeshSource& source, const SliceArguments& arguments, Item item) {
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
    item.files = files_of(planned_outputs(outputs), arguments.split);
    refuse_if(is_standard(item.report) || std::any_of(outputs.outputs.begin(), outputs.outputs.end(), is_standard),
              bad_usage, "'-': a batch writes files");
    return item;
}

}  // namespace

std::vector<std::string> Item::all_files() const {
    std::vector<std::string> all = files;
    all.insert(all.end(), report.empty() ? 0 : 1, report);
    return all;
}

std::vector<Item> plan_items(const CLI::App& command, const std::vector<std::string>& given,
                             const std::vector<std::string>& own_files) {
    const ItemOptions unset;
    const OptionValues typed = unset.typed(command);
    FilePlan files;  // In all of the batch no file is written twice, and none is an input.
    for (const std::string& file : own_files) {
        files.reads(file, "a file of the batch");
    }
    const std::vector<MeshSource> sources = list_sources(given, unset, files);
    std::vector<Item> items;
    items.reserve(sources.size());
    std::unique_ptr<ItemOptions> common;  // of items without own values, which are parsed once
    Item alike;
    for (const MeshSource& source : sources) {
        try {
            std::unique_ptr<ItemOptions> own;
            std::unique_ptr<ItemOptions>& options = source.values.empty() ? common : own;
            if (!options) {
                OptionValues values = source.values;
                values.insert(typed.begin(), typed.end());
                options = std::make_unique<ItemOptions>();
                options->parse(values);
                alike = common ? item_with(*common) : alike;
            }
            items.push_back(item_of(source, options->arguments, own ? item_with(*own) : alike));
            const Item& item = items.back();
            files.reads(item.mesh, "a mesh of the batch");
            for (const std::string& file : item.option_files) {
                files.reads(file, "the file of an option");
            }
            for (const std::string& file : item.all_files()) {
                const std::string option = file == item.report ? "--report" : "--output";
                files.writes(file, option,
                             "written for '" + item.mesh + "' too; {parent} or {dir} in " + option + " tells them apart");
            }
        } catch (const Failure& failure) {  // What is wrong with a row of a manifest is wrong with a file.
            throw source.place.empty() ? failure : Failure(bad_input, source.place + ": " + failure.what());
        }
    }
    return items;
}

}  // namespace lamella::cli::batch
