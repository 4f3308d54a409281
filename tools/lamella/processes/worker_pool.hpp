// The processes of a batch: each works on one mesh, and whatever becomes of it ends only that mesh.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "processes/tool_process.hpp"
#include "processes/worker_side.hpp"

namespace lamella::cli {

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
