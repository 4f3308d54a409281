#include "worker/slice_facts.hpp"

#include "lamella/io/name_text.hpp"
#include "worker/slice_facts_json.hpp"

namespace lamella::cli {

void add_facts(nlohmann::ordered_json& json, const SliceFacts& facts) {
    json["triangles"] = facts.triangles;
    json["layers"] = facts.layers;
    json["contours"] = facts.contours;
    json["open_contours"] = facts.open_contours;
    json["close_gaps_mm"] = facts.close_gaps_mm;
    json["warnings"] = nlohmann::ordered_json::array();
    for (const std::string& warning : facts.warnings) {
        json["warnings"].push_back(printable(warning));
    }
}

SliceFacts facts_of(const nlohmann::ordered_json& json) {
    return {json.at("triangles").get<std::uint64_t>(), json.at("layers").get<std::uint64_t>(),
            json.at("contours").get<std::uint64_t>(),  json.at("open_contours").get<std::uint64_t>(),
            json.value("close_gaps_mm", 0.0),          json.at("warnings").get<std::vector<std::string>>()};
}

std::string text_of(const SliceFacts& facts) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    add_facts(json, facts);
    return json.dump() + "\n";
}

std::optional<SliceFacts> parse_facts(std::string_view text) {
    try {
        return facts_of(nlohmann::ordered_json::parse(text));
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

}  // namespace lamella::cli
