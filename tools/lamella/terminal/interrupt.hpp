// SIGINT, SIGTERM and SIGHUP end a command in an orderly way, so that nothing half-written stays behind.
#pragma once

#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>
#include <vector>

#include <csignal>

#include "lamella/control.hpp"

namespace lamella::cli {

/// While it lives, the signals are taken by a thread of its own. Construct it before any other thread, so that all of them
/// inherit the blocked signals.
class Interrupt {
public:
    Interrupt();  ///< throws Failure
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// The files that will be written: what is unfinished of them goes with the process.
    void tidy(std::vector<std::filesystem::path> outputs);

    /// From here on a signal becomes a stop request; until here it ends the process, and so does always the second one. One
    /// that comes when all is written is too late: the command ends as it would have.
    StopCheck defer() noexcept;

    /// From here on a signal ends the process again, and one that was deferred does so now.
    void end_deferring() noexcept;

    /// Ends the process as the deferred signal would have, if one came.
    void die_if_interrupted() noexcept;

private:
    void wait_for_signals();
    void die_by(int signal_number) noexcept;

    std::atomic<bool> stop_ = false;
    std::atomic<bool> deferring_ = false;
    std::atomic<bool> finished_ = false;
    std::atomic<int> signal_ = 0;
    sigset_t signals_{};
    std::mutex mutex_;  ///< of the outputs
    std::vector<std::filesystem::path> outputs_;
    std::thread waiter_;
};

}  // namespace lamella::cli
