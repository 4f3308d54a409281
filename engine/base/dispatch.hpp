// Instruction sets: the levels that kernels are written for, and the choice among them. Default builds carry no -march: all
// levels are compiled in, and the processor is asked at run time, here and nowhere else. All forms of a kernel give the same
// bytes. A kernel lists its forms once, the fastest first and the portable one last:
//
//     constexpr Form<Sum> forms[] = {{InstructionSet::avx2, sum_avx2}, {InstructionSet::portable, sum_portable}};
//
//     best_of<Sum>(forms)      the form to use
//     supported<Sum>(forms)    every form that this processor runs, for tests
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#if defined(__x86_64__) && defined(__GNUC__)
#define LAMELLA_X86_FORMS
#include <immintrin.h>

#define LAMELLA_AVX2 __attribute__((target("avx2")))
#define LAMELLA_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline
#define LAMELLA_AVX512 __attribute__((target("avx512f,avx512vl,avx512dq,avx2,popcnt")))
#define LAMELLA_AVX512_INLINE __attribute__((target("avx512f,avx512vl,avx512dq,avx2,popcnt"), always_inline)) inline
#endif

namespace lamella {

#ifdef LAMELLA_X86_FORMS
constexpr std::size_t lanes_of_512 = 16;  // 32 bits each
constexpr __mmask16 all_lanes = 0xFFFF;
#endif

/// Each level includes those before it. On x86-64, `portable` may use SSE2.
enum class InstructionSet : std::uint8_t { portable, avx2, avx512 };

/// The highest level that this processor runs.
inline InstructionSet instruction_set() noexcept {
#ifdef LAMELLA_X86_FORMS
    if (__builtin_cpu_supports("avx2") != 0) {
        const bool wide = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
                          __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("popcnt") != 0;
        return wide ? InstructionSet::avx512 : InstructionSet::avx2;
    }
#endif
    return InstructionSet::portable;
}

/// A kernel, or a set of kernels, as written for one level.
template <class Kernel>
struct Form {
    InstructionSet needs;
    Kernel kernel;
};

/// The `forms` that this processor runs. Precondition: they are ordered by level, the portable one last.
template <class Kernel>
std::span<const Form<Kernel>> supported(std::span<const Form<Kernel>> forms) noexcept {
    const auto first = std::find_if(forms.begin(), forms.end() - 1,
                                    [level = instruction_set()](const Form<Kernel>& form) { return form.needs <= level; });
    return {first, forms.end()};
}

template <class Kernel>
const Kernel& best_of(std::span<const Form<Kernel>> forms) noexcept {
    return supported(forms).front().kernel;
}

template <class Kernel>
const Kernel& portable_of(std::span<const Form<Kernel>> forms) noexcept {
    return forms.back().kernel;
}

}  // namespace lamella
