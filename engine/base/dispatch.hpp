// Instruction sets: the levels that kernels are written for, and the choice among them. Default builds carry no -march: all
// levels are compiled in, and the processor is asked at run time, here and nowhere else. All forms of a kernel give the same
// bytes, so that a call may ask for any level (Tuning::instructions). A kernel lists its forms once, the fastest first and
// the portable one last:
//
//     constexpr Form<Sum> forms[] = {{InstructionSet::avx2, sum_avx2}, {InstructionSet::portable, sum_portable}};
//
//     best_of<Sum>(forms, level)    the form to use
//     supported<Sum>(forms)         every form that this processor runs, for tests
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/system/processor.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define LAMELLA_X86_FORMS
#include <immintrin.h>

#define LAMELLA_AVX2 __attribute__((target("avx2")))
#define LAMELLA_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline
#define LAMELLA_AVX512 __attribute__((target("avx512f,avx512vl,avx512dq,avx2,popcnt")))
#define LAMELLA_AVX512_INLINE __attribute__((target("avx512f,avx512vl,avx512dq,avx2,popcnt"), always_inline)) inline
#elif defined(__aarch64__) && defined(__GNUC__)
#define LAMELLA_NEON_FORMS
#include <arm_neon.h>
#endif

namespace lamella {

#ifdef LAMELLA_X86_FORMS
constexpr std::size_t lanes_of_512 = 16;  // 32 bits each
constexpr __mmask16 all_lanes = 0xFFFF;
#endif

/// Each level includes those before it that the processor runs. `portable` may use what all processors of a kind have: SSE2
/// on x86-64.
enum class InstructionSet : std::uint8_t { portable, avx2, avx512, neon };
inline constexpr std::array<std::string_view, 4> instruction_set_names = {"portable", "avx2", "avx512", "neon"};

constexpr std::string_view name_of(InstructionSet level) noexcept {
    return instruction_set_names[static_cast<std::size_t>(level)];
}

/// True where this build has forms of the level, and this processor runs them.
inline bool runs(InstructionSet level) noexcept {
#ifdef LAMELLA_X86_FORMS
    if (level == InstructionSet::avx2) {
        static const bool has_avx2 = has_vectors(bit_AVX2, 0x06);  // SSE and AVX
        return has_avx2;
    }
    if (level == InstructionSet::avx512) {
        static const bool has_avx512 =
            has_vectors(bit_AVX2 | bit_AVX512F | bit_AVX512VL | bit_AVX512DQ, 0xE6);  // and the masks
        return has_avx512;
    }
#elif defined(LAMELLA_NEON_FORMS)
    if (level == InstructionSet::neon) {
        return true;
    }
#endif
    return level == InstructionSet::portable;
}

/// The highest level that this processor runs.
inline InstructionSet instruction_set() noexcept {
    auto level = static_cast<InstructionSet>(instruction_set_names.size() - 1);
    while (!runs(level)) {
        level = static_cast<InstructionSet>(static_cast<int>(level) - 1);
    }
    return level;
}

/// A kernel, or a set of kernels, as written for one level.
template <class Kernel>
struct Form {
    InstructionSet needs;
    Kernel kernel;
};

/// The `forms` up to `level`, which this processor runs. Precondition: they are ordered by level, the portable one last.
template <class Kernel>
std::span<const Form<Kernel>> supported(std::span<const Form<Kernel>> forms,
                                        InstructionSet level = instruction_set()) noexcept {
    const auto first =
        std::find_if(forms.begin(), forms.end() - 1, [level](const Form<Kernel>& form) { return form.needs <= level; });
    return {first, forms.end()};
}

template <class Kernel>
const Kernel& best_of(std::span<const Form<Kernel>> forms, InstructionSet level) noexcept {
    return supported(forms, level).front().kernel;
}

template <class Kernel>
const Kernel& portable_of(std::span<const Form<Kernel>> forms) noexcept {
    return forms.back().kernel;
}

}  // namespace lamella
