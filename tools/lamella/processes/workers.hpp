// Commands as processes, each of which works on one mesh: whatever becomes of one ends only that mesh.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

#include "processes/tool_process.hpp"

namespace lamella::cli {

/// Counts and warnings of a mesh that slice has cut.
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

/// How the work on an item ended.
struct WorkerEnd {
    std::size_t item = 0;
    std::string failure;         ///< empty: it succeeded
    bool may_retry = false;      ///< the mesh need not be what is wrong
    bool lacked_memory = false;  ///< or was killed, which may mean so
    std::optional<SliceFacts> facts;
    std::uint64_t peak_bytes = 0;
};

class WorkerPool {
public:
    /// `timeout_s` 0: none.
    explicit WorkerPool(double timeout_s);
    /// Asks all processes to end, which removes what they have half written, kills those that do not, and awaits all.
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// Throws Failure (bad_input) when the system refuses another process.
    void start(std::size_t item, const ToolCall& call);

    /// Waits so long for a process to end, and ends those that take too long.
    std::vector<WorkerEnd> wait(std::chrono::milliseconds longest);

    std::size_t running() const noexcept { return workers_.size(); }

private:
    using Clock = std::chrono::steady_clock;

    struct Worker {
        std::size_t item;
        ToolProcess process;
        Clock::time_point deadline;
        bool late = false;
    };

    void end_late_ones();
    WorkerEnd end_of(Worker& worker);
    std::string reason_of_signal(int signal_number);

    double timeout_s_;
    std::uint64_t kills_without_memory_;  ///< by the system, as far as they are told
    std::vector<Worker> workers_;
};

}  // namespace lamella::cli
