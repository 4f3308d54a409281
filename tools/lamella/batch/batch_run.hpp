// A batch from its plan to its end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "batch/plan.hpp"
#include "batch/results.hpp"
#include "terminal/console.hpp"
#include "terminal/interrupt.hpp"

namespace lamella::cli::batch {

struct RunOptions {
    int jobs = 1;
    std::uint64_t memory_bytes = 0;
    double timeout_s = 0;
    int retries = 1;
    bool force = false;
    bool hash = false;
    std::vector<std::string> names_without_memory{};  ///< options that a mesh larger than all of it cannot have
    ProgressBar::When progress = ProgressBar::When::automatic;
};

struct BatchOutcome {
    std::string summary;  ///< for people
    std::size_t failed = 0;
};

/// Slices what is not done of `items`, those of this shard. Throws Failure where results cannot be kept.
BatchOutcome run_batch(std::vector<Item> items, const LedgerName& name, const RunOptions& options, Interrupt& interrupt);

}  // namespace lamella::cli::batch
