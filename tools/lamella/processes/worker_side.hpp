// A command as a process that a batch has started: it ends with the batch, and passes on what it found.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

namespace lamella::cli {

/// What slice says of a mesh that it has cut.
struct SliceFacts {
    std::uint64_t triangles = 0;
    std::uint64_t layers = 0;
    std::uint64_t contours = 0;
    std::uint64_t open_contours = 0;
    double close_gaps_mm = 0;  ///< as SliceResult::close_gaps_mm
    std::vector<std::string> warnings;

    bool operator==(const SliceFacts&) const = default;
};

/// As members of a JSON object, and back; the latter throws nlohmann::json::exception.
void add_facts(nlohmann::ordered_json& json, const SliceFacts& facts);
SliceFacts facts_of(const nlohmann::ordered_json& json);

/// Declares --worker, which help does not show. Where it is given, this process ends when its standard input does, and the
/// system chooses it first when memory runs out.
void declare_worker(CLI::App& command);

/// Where --worker was given, prints the facts: the last line on standard output.
void pass_on(const CLI::App& command, const SliceFacts& facts);
/// What was passed on by a process that printed `text`.
std::optional<SliceFacts> facts_at_end_of(std::string_view text);

}  // namespace lamella::cli
