// How often a test repeats itself, and in which ways to slice.
#pragma once

#include <ostream>
#include <vector>

#include "slicing/tuning.hpp"

/// All rounds in the release; an eighth under a sanitizer, where each takes ten times as long.
constexpr unsigned rounds(unsigned all) {
#ifdef LAMELLA_TESTS_SANITIZED
    return (all + 7) / 8;
#else
    return all;
#endif
}

/// True where combination number `i` of many is tried: each in the release; every fifth under a sanitizer.
constexpr bool tried([[maybe_unused]] unsigned i) {
#ifdef LAMELLA_TESTS_SANITIZED
    return i % 5 == 0;
#else
    return true;
#endif
}

/// Threads, bands and form, which must not change an answer.
struct Way {
    lamella::Context context{};
    lamella::Tuning tuning{};
};

inline std::ostream& operator<<(std::ostream& out, const Way& way) {
    return out << way.context.threads << " threads, bands of " << way.tuning.band_planes
               << (way.tuning.form == lamella::ContourForm::assembled ? ", assembled" : ", swept");
}

/// Numbers of threads and sizes of bands, in both forms.
inline std::vector<Way> ways() {
#ifdef LAMELLA_TESTS_SANITIZED
    constexpr int thread_counts[] = {1, 3};
    constexpr std::int64_t band_sizes[] = {0, 2};
#else
    constexpr int thread_counts[] = {1, 2, 3, 8};
    constexpr std::int64_t band_sizes[] = {0, 1, 2, 7, 1000};
#endif
    std::vector<Way> all;
    for (const int threads : thread_counts) {
        for (const std::int64_t band : band_sizes) {
            for (const lamella::ContourForm form : {lamella::ContourForm::swept, lamella::ContourForm::assembled}) {
                all.push_back({{.threads = threads}, {.band_planes = band, .form = form}});
            }
        }
    }
    return all;
}
