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
#include "processes/worker_side.hpp"

namespace lamella::cli::batch {

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

}  // namespace lamella::cli::batch
