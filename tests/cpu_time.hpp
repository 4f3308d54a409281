// Time for tests that bound how long something takes.
#pragma once

#ifdef _WIN32
#include "base/system/windows.hpp"
#else
#include <ctime>
#endif

/// Time of this process, on all its threads: while a busy machine does other work, it stands still.
inline double cpu_ms() {
#ifdef _WIN32  // whose clock() is a clock on the wall
    FILETIME began{};
    FILETIME ended{};
    FILETIME system{};
    FILETIME user{};
    GetProcessTimes(GetCurrentProcess(), &began, &ended, &system, &user);
    const auto tenths_us = [](FILETIME time) { return 4294967296.0 * time.dwHighDateTime + time.dwLowDateTime; };
    return (tenths_us(system) + tenths_us(user)) / 10'000;
#else
    return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
#endif
}
