// Calls of tests get up to eight threads: on a machine of two cores, oneTBB and so the library would make them two.
#include <tbb/global_control.h>

static const tbb::global_control eight_threads{tbb::global_control::max_allowed_parallelism, 8};
