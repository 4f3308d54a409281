// What this process may use of the machine: the lesser of what the machine has and what its control group grants.
#pragma once

#include <cstdint>

namespace lamella::cli::batch {

/// Processors.
int usable_threads();

/// Three quarters of the memory, or what is free if that is less.
std::uint64_t usable_memory();

}  // namespace lamella::cli::batch
