#include "batch/results/result_line.hpp"

#include <nlohmann/json.hpp>

#include "lamella/io/name_text.hpp"

namespace lamella::cli::batch {

namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson json_of(const InputFact& input) {
    OrderedJson json = {{"path", text_of_name(input.path)}, {"bytes", input.bytes}};
    if (input.sha256.empty()) {
        json["modified_ns"] = input.modified_ns;
    } else {
        json["sha256"] = input.sha256;
    }
    return json;
}

InputFact input_of(const OrderedJson& json) {
    return {name_of_text(json.at("path").get<std::string>()), json.at("bytes").get<std::uint64_t>(),
            json.value("modified_ns", std::int64_t{0}), json.value("sha256", std::string())};
}

OrderedJson json_of(const OutputFact& output) {
    OrderedJson json = {{"path", text_of_name(output.path)}};
    if (output.bytes) {
        json["bytes"] = *output.bytes;
    }
    return json;
}

OutputFact output_of(const OrderedJson& json) {
    OutputFact output{name_of_text(json.at("path").get<std::string>()), std::nullopt};
    if (json.contains("bytes")) {
        output.bytes = json.at("bytes").get<std::uint64_t>();
    }
    return output;
}

ResultLine result_of(const OrderedJson& json) {
    ResultLine result;
    result.mesh = name_of_text(json.at("mesh").get<std::string>());
    const bool done = json.at("status").get<std::string>() == "done";
    result.failure = done ? std::string() : json.at("reason").get<std::string>();
    for (const OrderedJson& option : json.at("options")) {
        result.options.push_back(name_of_text(option.get<std::string>()));
    }
    for (const OrderedJson& input : json.at("inputs")) {
        result.inputs.push_back(input_of(input));
    }
    for (const OrderedJson& output : json.at("outputs")) {
        result.outputs.push_back(output_of(output));
    }
    if (json.contains("triangles")) {
        result.facts = facts_of(json);
    }
    return result;
}

}  // namespace

std::string line_of(const ResultLine& result) {
    OrderedJson json = {{"mesh", text_of_name(result.mesh)}, {"status", result.done() ? "done" : "failed"}};
    if (!result.done()) {
        json["reason"] = printable(result.failure);
    }
    json["options"] = OrderedJson::array();
    for (const std::string& option : result.options) {
        json["options"].push_back(text_of_name(option));
    }
    json["inputs"] = OrderedJson::array();
    for (const InputFact& input : result.inputs) {
        json["inputs"].push_back(json_of(input));
    }
    json["outputs"] = OrderedJson::array();
    for (const OutputFact& output : result.outputs) {
        json["outputs"].push_back(json_of(output));
    }
    if (result.facts) {
        add_facts(json, *result.facts);
    }
    return json.dump() + "\n";
}

std::optional<ResultLine> parse_line(std::string_view text) {
    try {
        ResultLine result = result_of(OrderedJson::parse(text));
        return result.outputs.empty() ? std::nullopt : std::optional(std::move(result));
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

}  // namespace lamella::cli::batch
