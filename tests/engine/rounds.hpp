// How often a test with random input repeats itself.
#pragma once

/// All rounds in the release; a quarter under a sanitizer, where each takes ten times as long.
constexpr unsigned rounds(unsigned all) {
#ifdef LAMELLA_TESTS_SANITIZED
    return (all + 3) / 4;
#else
    return all;
#endif
}
