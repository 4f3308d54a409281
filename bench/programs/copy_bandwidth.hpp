// What memory can do: the yardstick of the `floor` counters.
#pragma once

#include <cstddef>

namespace lamella::bench {

/// Bytes read plus bytes written per second by a copy of warm memory on `threads` threads, much larger than the caches:
/// median of several, measured once per run and thread count.
double copy_bandwidth(int threads);

/// From now on `bytes` are copied.
void set_copy_size(std::size_t bytes);

}  // namespace lamella::bench
