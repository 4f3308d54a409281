// Starts the processes of a batch by forking, which takes a fifth of the time that loading this program once more does, and
// two do not wait for each other in the system's loader. A process with threads cannot fork safely. So another one does it,
// the starter, made before this one has a thread:
//
//     int main(int count, char** words) {
//         WorkerStarter starter(run_worker);              // ahead of the first thread
//         const pid_t worker = starter.start({"slice", {"a.stl", "-o", "a.svg"}}, facts, messages);
//         ...                                             // reads `facts` to its end
//         const WorkerStarter::End end = *starter.end_of(worker, true);
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <sys/types.h>

#include "terminal/failure.hpp"

namespace lamella::cli::batch {

/// What the system's refusal of another process means.
Failure no_process(int error_number);

/// One run of the tool.
struct WorkerCall {
    std::string command;
    std::vector<std::string> words;
    std::string folder{};                        ///< that it works in; empty: the one in which this process was started
    std::optional<std::string> date_of_build{};  ///< its SOURCE_DATE_EPOCH (empty: none); without: that of this process
};

class WorkerStarter {
public:
    using Main = int (*)(int count, char** words);

    /// Call it while this process has one thread. A worker runs `main` and ends with the status that it returns. Throws
    /// Failure (bad_input).
    explicit WorkerStarter(Main main);
    /// Ends the starter, and with it what it has started.
    ~WorkerStarter();
    WorkerStarter(const WorkerStarter&) = delete;
    WorkerStarter& operator=(const WorkerStarter&) = delete;

    /// A worker that reads nothing, prints nothing, and writes its facts and what it complains of to these descriptors. It
    /// is in a process group of its own: Ctrl-C reaches the batch alone, which then ends its workers. Throws Failure
    /// (bad_input) when the system refuses another process.
    pid_t start(const WorkerCall& call, int facts, int messages);

    struct End {
        int status = 0;  ///< as waitpid() gives it
        rusage used{};
    };

    /// How a worker ended. Nothing if it still runs and `wait` is false. Throws Failure (bad_input) when the starter is
    /// gone, and its workers with it.
    std::optional<End> end_of(pid_t worker, bool wait);

private:
    int socket_ = -1;
    pid_t starter_ = -1;
};

}  // namespace lamella::cli::batch
