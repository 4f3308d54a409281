// The facts of a slice as members of a JSON object.
#pragma once

#include <nlohmann/json.hpp>

#include "worker/slice_facts.hpp"

namespace lamella::cli {

void add_facts(nlohmann::ordered_json& json, const SliceFacts& facts);

/// Throws nlohmann::json::exception.
SliceFacts facts_of(const nlohmann::ordered_json& json);

}  // namespace lamella::cli
