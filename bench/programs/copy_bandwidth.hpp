// The copy bandwidth of memory, to which the `floor` counters refer.
#pragma once

#include <cstddef>

namespace lamella::bench {

/// Bytes read plus bytes written per second when `threads` threads copy warm memory much larger than the caches. The
/// median of several copies, measured once for each run and thread count.
double copy_bandwidth(int threads);

/// Sets the number of bytes that later calls copy.
void set_copy_size(std::size_t bytes);

}  // namespace lamella::bench
