// This program started once more for one mesh: whatever becomes of that process ends only that mesh.
//
//     const ProcessEnd end = run_process({"slice", "a.stl", "-o", "a.svg"}, "", 0, stop);
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace lamella::cli {

/// Declares --worker PID, which help does not show: PID is the process that started this one, which ends with it, and which
/// the system spares when memory runs out.
void declare_worker(CLI::App& command);

/// What a process that slices a mesh prints of it as its last line: counts and warnings.
using Facts = nlohmann::ordered_json;

struct ProcessEnd {
    std::string failure{};          ///< empty: it succeeded
    bool may_retry = false;         ///< the mesh need not be what is wrong
    bool lacked_memory = false;     ///< or was killed, which may mean so
    Facts facts = Facts::object();  ///< if the process printed any
    std::uint64_t peak_bytes = 0;   ///< of memory; 0: unknown
};

/// Starts the tool with these words, the first of which is a command, in that folder (empty: that of this process), and
/// waits for its end. Where `stop` says so, or after `timeout_s` (0: never), it is asked to end, which removes what it has
/// half written, and is killed if it does not. It has a process group of its own: Ctrl-C reaches the calling process alone.
/// Throws Failure (bad_input) where the system refuses another process.
ProcessEnd run_process(std::vector<std::string> words, const std::string& folder, double timeout_s,
                       const std::function<bool()>& stop);

}  // namespace lamella::cli
