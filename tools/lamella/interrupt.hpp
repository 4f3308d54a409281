// SIGINT, SIGTERM and SIGHUP end a command in an orderly way, so that nothing half-written stays behind.
#pragma once

#include <atomic>
#include <stop_token>
#include <thread>

#include <csignal>

namespace lamella::cli {

/// While it lives, the signals are taken by a thread of its own. Construct it before any other thread, so that all of them
/// inherit the blocked signals.
class Interrupt {
public:
    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// From here on a signal becomes a stop request; until here, while there is nothing to tidy up, it ends the process.
    std::stop_token defer() noexcept;

    /// Ends the process as the deferred signal would have, if one came.
    void die_if_interrupted() const noexcept;

private:
    void wait_for_signals();

    std::stop_source source_;
    std::atomic<bool> deferring_ = false;
    std::atomic<bool> finished_ = false;
    std::atomic<int> signal_ = 0;
    sigset_t signals_{};
    std::thread waiter_;
};

}  // namespace lamella::cli
