#include "batch/results.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "files/mesh_input.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/medical/record.hpp"
#include "outputs/recorded_options.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson json_of(const std::string& word) {
    return text_of_name(word);
}

OrderedJson json_of(const InputFact& input) {
    OrderedJson json = {{"path", text_of_name(input.path)}, {"bytes", input.bytes}};
    if (input.sha256.empty()) {
        json["modified_ns"] = input.modified_ns;
    } else {
        json["sha256"] = input.sha256;
    }
    return json;
}

OrderedJson json_of(const OutputFact& output) {
    OrderedJson json = {{"path", text_of_name(output.path)}};
    if (output.bytes) {
        json["bytes"] = *output.bytes;
    }
    return json;
}

template <class T>
OrderedJson array_of(const std::vector<T>& all) {
    OrderedJson array = OrderedJson::array();
    for (const T& each : all) {
        array.push_back(json_of(each));
    }
    return array;
}

std::string name_in(const OrderedJson& json) {
    return name_of_text(json.get<std::string>());
}

InputFact input_in(const OrderedJson& json) {
    return {name_in(json.at("path")), json.at("bytes").get<std::uint64_t>(), json.value("modified_ns", std::int64_t{0}),
            json.value("sha256", std::string())};
}

OutputFact output_in(const OrderedJson& json) {
    return {name_in(json.at("path")),
            json.contains("bytes") ? std::optional<std::uint64_t>(json.at("bytes").get<std::uint64_t>()) : std::nullopt};
}

template <class T>
std::vector<T> list_in(const OrderedJson& array, T (*each_in)(const OrderedJson&)) {
    std::vector<T> all;
    for (const OrderedJson& each : array) {
        all.push_back(each_in(each));
    }
    return all;
}

std::int64_t modified_ns(const struct stat& file) {
    return std::int64_t{file.st_mtim.tv_sec} * 1'000'000'000 + file.st_mtim.tv_nsec;
}

InputFact fact_of_folder(const std::string& path) {
    InputFact fact{path, 0, 0, ""};
    std::error_code problem;
    for (const std::filesystem::directory_entry& entry : entries_of(path, problem)) {
        struct stat file {};
        if (::stat(entry.path().c_str(), &file) == 0 && S_ISREG(file.st_mode)) {
            fact.bytes += static_cast<std::uint64_t>(file.st_size);
            fact.modified_ns = std::max(fact.modified_ns, modified_ns(file));
        }
    }
    return fact;
}

}  // namespace

std::string line_of(const ResultLine& result) {
    OrderedJson json = {{"mesh", text_of_name(result.mesh)}, {"status", result.done() ? "done" : "failed"}};
    if (!result.done()) {
        json["reason"] = printable(result.failure);
    }
    json["options"] = array_of(result.options);
    json["inputs"] = array_of(result.inputs);
    json["outputs"] = array_of(result.outputs);
    if (result.facts) {
        add_facts(json, *result.facts);
    }
    return json.dump() + "\n";
}

std::optional<ResultLine> parse_line(std::string_view text) {
    try {
        const OrderedJson json = OrderedJson::parse(text);
        const bool done = json.at("status").get<std::string>() == "done";
        ResultLine result{.mesh = name_in(json.at("mesh")),
                          .failure = done ? std::string() : json.at("reason").get<std::string>(),
                          .options = list_in(json.at("options"), name_in),
                          .inputs = list_in(json.at("inputs"), input_in),
                          .outputs = list_in(json.at("outputs"), output_in),
                          .facts = {}};
        if (json.contains("triangles")) {
            result.facts = facts_of(json);
        }
        return result.outputs.empty() ? std::nullopt : std::optional(std::move(result));
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

InputFact fact_of(const std::string& path, bool hash, const StopCheck& stop) {
    struct stat file {};
    if (::stat(path.c_str(), &file) != 0) {
        return {path, 0, 0, ""};
    }
    if (S_ISDIR(file.st_mode)) {
        return fact_of_folder(path);
    }
    InputFact fact{path, static_cast<std::uint64_t>(file.st_size), 0, ""};
    if (!hash || !S_ISREG(file.st_mode)) {
        fact.modified_ns = modified_ns(file);
        return fact;
    }
    Control control;
    control.stop = stop;
    Result<FileSeal> seal = seal_file(path, control);
    if (!seal && seal.error().code == ErrorCode::cancelled) {
        throw failure_of(seal.error());
    }
    if (seal) {
        fact.bytes = seal->bytes;
        fact.sha256 = std::move(seal->sha256);
    }
    return fact;
}

std::vector<OutputFact> outputs_of(const Item& item) {
    std::vector<OutputFact> outputs;
    for (const std::string& path : item.files) {
        std::error_code unknown;
        const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
        outputs.push_back({path, unknown ? std::nullopt : std::optional<std::uint64_t>(bytes)});
    }
    return outputs;
}

bool is_done(const Item& item, const ResultLine& line) {
    std::error_code unknown;
    return line.done() && line.mesh == item.mesh && line.options == item.words && line.inputs == item.inputs &&
           line.outputs == outputs_of(item) && line.outputs.front().bytes.has_value() &&
           (item.report.empty() || std::filesystem::exists(item.report, unknown));
}

bool is_of_older_version(const ResultLine& line) {
    return std::any_of(changed_defaults.begin(), changed_defaults.end(), [&](const ChangedDefault& changed) {
        return std::none_of(line.options.begin(), line.options.end(),
                            [&](const std::string& word) { return word.starts_with(std::string(changed.name) + "="); });
    });
}

}  // namespace lamella::cli::batch
