// One line of results.jsonl: what came of an item. It holds no time of the run and nothing of the machine, so that the same
// meshes give the same bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "batch/plan/item.hpp"

namespace lamella::cli::batch {

/// What slice says of a mesh that it has cut.
struct SliceFacts {
    std::uint64_t triangles = 0;
    std::uint64_t layers = 0;
    std::uint64_t contours = 0;
    std::uint64_t open_contours = 0;
    std::vector<std::string> warnings;

    bool operator==(const SliceFacts&) const = default;
};

struct OutputFact {
    std::string path;
    std::optional<std::uint64_t> bytes;  ///< none: it was not written

    bool operator==(const OutputFact&) const = default;
};

struct ResultLine {
    std::string mesh;
    std::string failure;  ///< why it failed; empty: done
    std::vector<std::string> options;
    std::vector<InputFact> inputs;
    std::vector<OutputFact> outputs;  ///< of a failed item without sizes; the first one names the item
    std::optional<SliceFacts> facts;

    bool done() const noexcept { return failure.empty(); }
    const std::string& key() const { return outputs.front().path; }
};

/// With a final newline.
std::string line_of(const ResultLine& result);

/// None where the text is no such line, as one that was torn by a crash.
std::optional<ResultLine> parse_line(std::string_view text);

/// The facts as slice passes them to the batch, and back; with a final newline.
std::string text_of(const SliceFacts& facts);
std::optional<SliceFacts> parse_facts(std::string_view text);

}  // namespace lamella::cli::batch
