// Processes that run this program once more. All that is of POSIX in this is in tool_process.cpp.
//
//     ToolProcess process({"slice", {"a.stl", "-o", "a.svg"}});
//     while (process.read()) {
//         wait_for_output({&process}, std::chrono::milliseconds(100));
//     }
//     const ProcessEnd end = process.await();
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "files/streams.hpp"

namespace lamella::cli {

/// One run of the tool.
struct ToolCall {
    std::string command;
    std::vector<std::string> words;
    std::string folder{};                        ///< that it works in; empty: that of this process
    std::optional<std::string> date_of_build{};  ///< its SOURCE_DATE_EPOCH (empty: none); without: that of this process
};

struct ProcessEnd {
    int exit_status = 0;
    int signal_number = 0;         ///< by which it was ended; 0: it ended by itself
    std::uint64_t peak_bytes = 0;  ///< of memory; 0: not known
};

/// Its standard input is a pipe that ends with this process, and it with that: see end_with_starter(). It is in a process
/// group of its own: Ctrl-C reaches this process alone.
class ToolProcess {
public:
    /// Throws Failure (bad_input) when the system refuses another process.
    explicit ToolProcess(const ToolCall& call);

    /// Takes what it has printed. False when it has ended.
    bool read();
    /// All that it has printed on standard output and standard error, or the last of it.
    const std::string& text() const noexcept { return text_; }

    /// Waits for the end, once.
    ProcessEnd await();

    /// Asks the process to end, which removes what it has half written.
    void ask_to_end() const noexcept;
    void kill() const noexcept;

    int output() const noexcept { return output_.number(); }

private:
    struct Pipe {
        Descriptor reading;
        Descriptor writing;
        static Pipe make();
    };
    ToolProcess(const ToolCall& call, Pipe input, Pipe output);

    Descriptor life_;    ///< the end of its standard input that is written to
    Descriptor output_;  ///< its end of file is the end of the process
    std::string text_;
    pid_t process_;
};

/// Called in such a process: from here on it ends when its standard input does, and the system chooses it first when memory
/// runs out.
void end_with_starter();

/// Waits so long for one of them to print something or to end.
void wait_for_output(const std::vector<const ToolProcess*>& processes, std::chrono::milliseconds longest);

}  // namespace lamella::cli
