// Progress reported to the host: by one thread at a time, and never falling.
#pragma once

#include <mutex>

#include "lamella/control.hpp"

namespace lamella {

class ProgressMeter {
public:
    explicit ProgressMeter(const Progress& sink) noexcept : sink_(sink) {}

    /// From any thread, which does not wait: while another one reports, this is left out. So is what is not below 1, since
    /// the call may still fail.
    void reach(double fraction) noexcept {
        if (sink_.report == nullptr) {
            return;
        }
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock.owns_lock() && fraction > reported_ && fraction < 1) {
            reported_ = fraction;
            sink_.report(sink_.context, fraction);
        }
    }

    /// The call has succeeded, and no thread works on it any more.
    void finish() noexcept {
        if (sink_.report != nullptr) {
            sink_.report(sink_.context, 1);
        }
    }

private:
    Progress sink_;
    std::mutex mutex_;
    double reported_ = -1;
};

}  // namespace lamella
