// Time for tests that bound how long something takes.
#pragma once

#include <ctime>

/// Time of this process, on all its threads: while a busy machine does other work, it stands still.
inline double cpu_ms() {
    return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}
