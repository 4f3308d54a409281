// The processes of a batch: each slices one mesh, and whatever becomes of it ends only that mesh.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "batch/results/result_line.hpp"
#include "batch/workers/worker_starter.hpp"

namespace lamella::cli::batch {

/// How a process ended.
struct WorkerEnd {
    std::size_t item = 0;
    std::string failure;         ///< empty: it succeeded
    bool may_retry = false;      ///< the mesh need not be what is wrong
    bool lacked_memory = false;  ///< or was killed, which may mean so
    std::optional<SliceFacts> facts;
    std::uint64_t peak_bytes = 0;
    double cpu_s = 0;
};

class WorkerPool {
public:
    using Clock = std::chrono::steady_clock;

    /// `timeout_s` 0: none.
    WorkerPool(WorkerStarter& starter, double timeout_s);
    /// Ends and awaits all processes.
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// Throws Failure (bad_input) when the system refuses another process.
    void start(std::size_t item, const WorkerCall& call);

    /// Waits so long for a process to end, and ends those that take too long. Throws Failure (bad_input) when all were ended
    /// with their starter.
    std::vector<WorkerEnd> wait(std::chrono::milliseconds longest);

    /// Asks all processes to end, which removes what they have half written, and kills those that do not.
    void end_all() noexcept;

    std::size_t running() const noexcept { return workers_.size(); }

private:
    struct Worker {
        std::size_t item = 0;
        pid_t process = -1;
        int facts = -1;     ///< read end; its end of file is the end of the process
        int messages = -1;  ///< of its standard error
        std::string facts_text;
        std::string message_text;
        Clock::time_point deadline = Clock::time_point::max();
        bool late = false;
    };

    void end_late_ones();
    static void drain(int descriptor, std::string& text, bool& ended);
    WorkerEnd reap(Worker& worker);
    std::string reason_of_signal(int signal_number);

    bool still_runs(const Worker& worker) noexcept;

    WorkerStarter& starter_;
    double timeout_s_;
    std::uint64_t kills_without_memory_;  ///< by the system, as far as they are told
    std::vector<Worker> workers_;
};

}  // namespace lamella::cli::batch
