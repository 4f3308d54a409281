// The host's stop request, asked by time: the loops of a call look for it as often as they like.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include "base/clock.hpp"
#include "lamella/control.hpp"

namespace lamella {

/// Thrown where the host wants the call to end.
struct Stopped {};

/// Asks the host at the first look, and then at most once in `interval` on the thread that made the call and once on the
/// others together. The calling thread has an interval of its own because some hosts, such as Python, answer only there.
/// Once the host has said yes, every look says so: of many threads each would else wait until it is its turn to ask.
class PacedStop {
public:
    static constexpr std::chrono::milliseconds interval{2};

    explicit PacedStop(const StopCheck& host = {}) noexcept { follow(host); }
    PacedStop(const PacedStop&) = delete;
    PacedStop& operator=(const PacedStop&) = delete;

    /// A call begins, on this thread.
    void follow(const StopCheck& host) noexcept {
        host_ = host;
        caller_ = std::this_thread::get_id();
        next_[0] = next_[1] = 0;
        const auto look = [](void* self) noexcept { return static_cast<PacedStop*>(self)->look(); };
        check_ = host.requested == nullptr ? StopCheck{} : StopCheck{look, this};
    }

    /// For any thread. A look that does not ask the host costs a look at the clock.
    const StopCheck& check() const noexcept { return check_; }
    void stop_if_asked() const { stop_if(check_); }
    /// Asks the host whatever the time: one of its own functions has just run, and may have found a reason to stop.
    void ask_host() const { stop_if(host_); }

private:
    static void stop_if(const StopCheck& check) {
        if (check.stop_requested()) {
            throw Stopped();
        }
    }
    static Clock::rep now() noexcept { return Clock::now().time_since_epoch().count(); }

    bool look() noexcept {
        constexpr Clock::rep while_asking = std::numeric_limits<Clock::rep>::max();
        constexpr Clock::rep said_yes = -1;
        std::atomic<Clock::rep>& next = next_[std::this_thread::get_id() == caller_ ? 0 : 1];
        Clock::rep due = next.load(std::memory_order_relaxed);
        if (due == said_yes) {
            return true;
        }
        if (now() < due || !next.compare_exchange_strong(due, while_asking, std::memory_order_relaxed)) {
            return false;
        }
        if (!host_.stop_requested()) {
            next.store(now() + Clock::duration(interval).count(), std::memory_order_relaxed);
            return false;
        }
        next_[0] = next_[1] = said_yes;
        return true;
    }

    StopCheck host_;
    StopCheck check_;
    std::thread::id caller_;
    std::array<std::atomic<Clock::rep>, 2> next_{};  ///< when the host is asked again: on the calling thread, on others
};

}  // namespace lamella
