// How often a test repeats itself, and in which ways to slice.
#pragma once

#include <ostream>
#include <vector>

#include "lamella/slice.hpp"

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

/// Options that must not change an answer.
struct Way {
    int threads;
    int band_planes;
    lamella::ContourForm form;
};

inline lamella::SliceOptions by(const Way& way, lamella::SliceOptions options) {
    options.control.threads = way.threads;
    options.tuning.band_planes = way.band_planes;
    options.tuning.form = way.form;
    return options;
}

inline std::ostream& operator<<(std::ostream& out, const Way& way) {
    return out << way.threads << " threads, bands of " << way.band_planes
               << (way.form == lamella::ContourForm::assembled ? ", assembled" : ", swept");
}

/// Numbers of threads and sizes of bands, in both forms.
inline std::vector<Way> ways() {
#ifdef LAMELLA_TESTS_SANITIZED
    constexpr int thread_counts[] = {1, 3};
    constexpr int band_sizes[] = {0, 2};
#else
    constexpr int thread_counts[] = {1, 2, 3, 8};
    constexpr int band_sizes[] = {0, 1, 2, 7, 1000};
#endif
    std::vector<Way> all;
    for (const int threads : thread_counts) {
        for (const int band : band_sizes) {
            all.push_back({threads, band, lamella::ContourForm::swept});
            all.push_back({threads, band, lamella::ContourForm::assembled});
        }
    }
    return all;
}
