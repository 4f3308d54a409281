// How often a test repeats itself, and in which ways to slice.
#pragma once

#include <iterator>
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

/// Threads, instructions, bands and form, which must not change an answer.
struct Way {
    lamella::Context context{};
    lamella::Tuning tuning{};
};

inline std::ostream& operator<<(std::ostream& out, const Way& way) {
    const auto level = way.tuning.instructions.value_or(lamella::instruction_set());
    return out << way.context.threads << " threads, " << lamella::name_of(level) << ", bands of " << way.tuning.band_planes
               << (way.tuning.form == lamella::ContourForm::assembled ? ", assembled" : ", swept");
}

/// The levels that this processor runs.
inline std::vector<lamella::InstructionSet> runnable_levels() {
    std::vector<lamella::InstructionSet> levels;
    for (std::size_t i = 0; i < lamella::instruction_set_names.size(); ++i) {
        if (const auto level = static_cast<lamella::InstructionSet>(i); lamella::runs(level)) {
            levels.push_back(level);
        }
    }
    return levels;
}

/// Numbers of threads, each with one of the levels in turn, and sizes of bands, in both forms.
inline std::vector<Way> ways() {
#ifdef LAMELLA_TESTS_SANITIZED
    constexpr int thread_counts[] = {1, 3};
    constexpr std::int64_t band_sizes[] = {0, 2};
#else
    constexpr int thread_counts[] = {1, 2, 3, 8};
    constexpr std::int64_t band_sizes[] = {0, 1, 2, 7, 1000};
#endif
    const std::vector<lamella::InstructionSet> levels = runnable_levels();
    std::vector<Way> all;
    for (std::size_t t = 0; t < std::size(thread_counts); ++t) {
        const lamella::InstructionSet level = levels[t % levels.size()];
        for (const std::int64_t band : band_sizes) {
            for (const lamella::ContourForm form : {lamella::ContourForm::swept, lamella::ContourForm::assembled}) {
                all.push_back({{.threads = thread_counts[t]}, {.band_planes = band, .form = form, .instructions = level}});
            }
        }
    }
    return all;
}
