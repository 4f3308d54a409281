// Commands as processes that run this program once more, each of which works on one mesh: whatever becomes of one ends only
// that mesh. All that is of POSIX in this is in workers.cpp.
//
//     WorkerPool pool(0);
//     pool.start(0, {"slice", {"a.stl", "-o", "a.svg"}});
//     while (pool.running() > 0) {
//         for (const WorkerEnd& end : pool.wait(std::chrono::milliseconds(100))) { ... }
//     }
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <sys/types.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "files/streams.hpp"

namespace lamella::cli {

/// Counts and warnings of a mesh that slice has cut.
struct SliceFacts {
    std::uint64_t triangles = 0;
    std::uint64_t layers = 0;
    std::uint64_t contours = 0;
    std::uint64_t open_contours = 0;
    double stitch_mm = 0;  ///< the length that --stitch came to
    std::vector<std::string> warnings;
};

/// Declares --worker, which help does not show. Where it is given, this process ends when its standard input does, and the
/// system chooses it first when memory runs out.
void declare_worker(CLI::App& command);

/// Where --worker was given, prints the facts as a JSON object: the last line on standard output.
void pass_on(const CLI::App& command, const SliceFacts& facts);

/// One run of the tool.
struct ToolCall {
    std::string command;
    std::vector<std::string> words;
    std::string folder{};  ///< that it works in; empty: that of this process
};

/// How the work on an item ended.
struct WorkerEnd {
    std::size_t item = 0;
    std::string failure{};                                            ///< empty: it succeeded
    bool may_retry = false;                                           ///< the mesh need not be what is wrong
    bool lacked_memory = false;                                       ///< or was killed, which may mean so
    nlohmann::ordered_json facts = nlohmann::ordered_json::object();  ///< that the process passed on
    std::uint64_t peak_bytes = 0;                                     ///< of memory; 0: not known
};

/// Each process has a pipe as its standard input that ends with this process, and it with that. It is in a process group of
/// its own: Ctrl-C reaches this process alone.
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

    /// Waits so long for a process to print something or to end, and ends those that take too long.
    std::vector<WorkerEnd> wait(std::chrono::milliseconds longest);

    std::size_t running() const noexcept { return workers_.size(); }

private:
    using Clock = std::chrono::steady_clock;

    struct Worker {
        std::size_t item;
        pid_t process;
        Descriptor life;    ///< the end of its standard input that is written to, and never is
        Descriptor output;  ///< its end of file is the end of the process
        Clock::time_point deadline;
        std::string text{};  ///< all that it has printed on standard output and standard error, or the last of it
        bool late = false;
    };

    void end_late_ones();
    WorkerEnd end_of(const Worker& worker);
    std::string reason_of_signal(int signal_number);

    double timeout_s_;
    std::uint64_t kills_without_memory_;  ///< by the system, as far as they are told
    std::vector<Worker> workers_;
};

}  // namespace lamella::cli
