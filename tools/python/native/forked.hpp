// Where calls of the engine run: oneTBB's threads do not survive a fork, and its locks may stay locked by threads that are
// gone. In a forked process a call therefore starts threads of its own.
#pragma once

#include "lamella/control.hpp"

namespace lamella::python {

/// From here on forks are noticed.
void watch_forks();

/// None in a process that is nobody's fork since watch_forks(): then oneTBB's threads are used.
Executor executor_here() noexcept;

}  // namespace lamella::python
