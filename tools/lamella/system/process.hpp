// Processes: requests to stop this one, those that it starts, and what the machine grants it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lamella::cli {

/// From here on a thread calls take(own, number) for each request to end: SIGINT, SIGTERM and SIGHUP, unless the caller has
/// them ignored, and Ctrl-C, Ctrl-Break and the end of the console. Call it once, before any thread is started. Throws
/// std::system_error.
void take_signals(void (*take)(void* own, int number), void* own);

/// As if the signal had not been taken: callers see it in the exit status.
void end_by_signal(int number) noexcept;

/// Begins the message by which also a process that was started says that it cannot run the program.
inline constexpr const char* cannot_start = "cannot start a process for a mesh: ";

/// How a process ended.
struct ProcessOutcome {
    int exit_status = 0;
    std::string crash{};           ///< in words; empty: by itself, with that exit status
    bool lacked_memory = false;    ///< or was killed, which may mean so
    std::uint64_t peak_bytes = 0;  ///< of memory; 0: unknown
};

/// This program started once more. The process has no input, and does not get the Ctrl-C that this one gets.
class ChildProcess {
public:
    /// In that folder (empty: that of this process); the first word is a command, which takes --worker. Throws
    /// std::system_error.
    ChildProcess(std::vector<std::string> words, const std::string& folder, int exit_status_of_no_program);
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Waits so long for the process to print something, and adds that to `text`. False when it has ended.
    bool read_output(std::string& text, std::chrono::milliseconds longest);
    /// To end in an orderly way: it takes that as a signal.
    void ask_to_end() noexcept;
    void kill() noexcept;
    /// Waits for its end. Precondition: the first call.
    ProcessOutcome wait();

private:
    // Numbers or handles, as systems have them.
    std::intptr_t output_ = 0;
    std::intptr_t process_ = 0;
    [[maybe_unused]] std::intptr_t stop_ = 0;  // an event, where signals are none
};

/// From here on this process ends when `starter`, which started it, does, may be asked to end by it, and is the first to go
/// where memory runs out. False if that one has ended before.
bool end_with(std::uint64_t starter);

/// Where this program lies; empty where the system does not say.
std::filesystem::path program_path();

/// True if another process of this number runs this program.
bool runs_this_program(std::uint64_t process);

/// Of this process, its largest resident size so far.
std::uint64_t peak_rss_bytes();

/// Processors that this process may use.
int granted_processors();

/// Of the machine; 0 where the system does not say.
std::uint64_t free_memory_bytes();

}  // namespace lamella::cli
