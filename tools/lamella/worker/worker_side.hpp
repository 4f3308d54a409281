// What `lamella slice` does where it is a process of a batch: it ends with the batch, and passes on what it found.
#pragma once

#include <string>

#include <sys/types.h>

#include <CLI/CLI.hpp>

#include "worker/slice_facts.hpp"

namespace lamella::cli {

class WorkerSide {
public:
    /// Declares --worker FD:PID, which help does not show: where to write the facts, and the process that forked this one.
    void declare(CLI::App& command);

    /// Asks the system to kill this process when the one that forked it ends, and to choose this one first when memory runs
    /// out. Does nothing without --worker. Throws Failure (bad_usage).
    void begin();

    bool wanted() const noexcept { return descriptor_ >= 0; }

    /// Passes on the facts; a batch that is gone does not miss them.
    void tell(const SliceFacts& facts) const noexcept;

private:
    std::string text_;
    int descriptor_ = -1;
};

/// The word that makes slice such a process: `parent` forks it.
std::string worker_word(int descriptor, pid_t parent);

}  // namespace lamella::cli
