// How often a test repeats itself.
#pragma once

/// All rounds in the release; an eighth under a sanitizer, where each takes ten times as long.
constexpr unsigned rounds(unsigned all) {
#ifdef LAMELLA_TESTS_SANITIZED
    return (all + 7) / 8;
#else
    return all;
#endif
}

/// Whether combination number `i` of many is tried: each in the release; every fifth under a sanitizer.
constexpr bool tried([[maybe_unused]] unsigned i) {
#ifdef LAMELLA_TESTS_SANITIZED
    return i % 5 == 0;
#else
    return true;
#endif
}
