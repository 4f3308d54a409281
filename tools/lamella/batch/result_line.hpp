// One line of results.jsonl: what came of an item. It holds no time of the run and nothing of the machine, so that the same
// meshes give the same bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batch/plan.hpp"
#include "lamella/control.hpp"
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

/// What is known of a file: its time, or its content. Of a folder, such as a DICOM series: the bytes in its files, and the
/// latest time. A file that cannot be read has no bytes and no time: the item then says why. Throws Failure where `stop`
/// ends it.
InputFact fact_of(const std::string& path, bool hash, const StopCheck& stop);

/// The outputs of an item with their sizes; an output that is not there has none.
std::vector<OutputFact> outputs_of(const Item& item);

/// Done: the line says so, of the same mesh, options and inputs, and every output is there in the size that it says, or is
/// not there if it says so (slice within --memory leaves out a table).
bool is_done(const Item& item, const ResultLine& line);

/// Whether the line does not state what every line of this version does: see changed_defaults.
bool is_of_older_version(const ResultLine& line);

}  // namespace lamella::cli::batch
