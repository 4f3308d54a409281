// Two tasks write one integer without synchronisation: the thread sanitizer must say so, or its silence about the engine
// would mean nothing.
#include <cstdio>

#include "base/parallel.hpp"

int main() {
    int shared = 0;
    const lamella::Parallel parallel(4);
    parallel.run(10'000, [&](std::size_t, int) { ++shared; });
    std::printf("%d\n", shared);
    return 0;
}
