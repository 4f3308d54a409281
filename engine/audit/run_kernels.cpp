#include "audit/run_kernels.hpp"

#include <bit>
#include <limits>

#include "base/sign.hpp"

namespace lamella {

namespace {

/// The directions in which a path has gone since it last turned, 0 if neither way.
class Heading {
public:
    bool turns_at(Point from, Point to) noexcept {
        const int right = sign_of(std::int64_t{to.x} - from.x);
        const int up = sign_of(std::int64_t{to.y} - from.y);
        const bool turns = right * right_ < 0 || up * up_ < 0;
        right_ = right != 0 || turns ? right : right_;
        up_ = up != 0 || turns ? up : up_;
        return turns;
    }
    bool is_slanting() const noexcept { return right_ != 0 && up_ != 0; }
    /// Bit 0: right, bit 1: up. Precondition: slanting.
    unsigned bits() const noexcept { return (right_ > 0 ? 1U : 0U) | (up_ > 0 ? 2U : 0U); }
    void set(unsigned bits) noexcept {
        right_ = (bits & 1U) != 0 ? 1 : -1;
        up_ = (bits & 2U) != 0 ? 1 : -1;
    }

private:
    int right_ = 0;
    int up_ = 0;
};

std::size_t find_turns_portable(const Point* points, std::size_t edges, std::uint32_t* out) {
    std::size_t found = 0;
    Heading heading;
    for (std::size_t e = 0; e < edges; ++e) {
        out[found] = static_cast<std::uint32_t>(e);
        found += heading.turns_at(points[e], points[e + 1]) ? 1 : 0;
    }
    return found;
}

BoxesMet find_meeting_portable(const BoxArrays& boxes, std::size_t i, std::size_t end, std::int32_t from_x,
                               std::uint32_t* out) {
    std::size_t found = 0;
    std::size_t j = i + 1;
    for (; j < end && boxes.low_y[j] <= boxes.high_y[i]; ++j) {
        const bool right_of = boxes.low_x[j] > boxes.high_x[i];
        const bool left_of = boxes.low_x[i] > boxes.high_x[j];
        const bool before = boxes.low_x[i] < from_x && boxes.low_x[j] < from_x;
        const bool next = boxes.run[j] + 1 == boxes.run[i] || boxes.run[j] == boxes.run[i] + 1;
        out[found] = static_cast<std::uint32_t>(j);
        found += right_of || left_of || before || next ? 0 : 1;
    }
    return {found, j - i - 1};
}

#ifdef LAMELLA_X86_FORMS

LAMELLA_AVX2_INLINE __m256i lanes_at(const void* at) {
    return _mm256_loadu_si256(static_cast<const __m256i*>(at));
}
LAMELLA_AVX2_INLINE unsigned greater(__m256i a, __m256i b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b))));
}

/// Two bits an edge, of eight edges: whether x ascends, and y.
LAMELLA_AVX2 std::size_t find_turns_avx2(const Point* points, std::size_t edges, std::uint32_t* out) {
    constexpr std::size_t step = 8;
    std::size_t found = 0;
    Heading heading;
    std::size_t e = 0;
    for (; e + step <= edges; e += step) {
        const __m256i here[2] = {lanes_at(points + e), lanes_at(points + e + 4)};
        const __m256i next[2] = {lanes_at(points + e + 1), lanes_at(points + e + 5)};
        const unsigned ascends = greater(next[0], here[0]) | greater(next[1], here[1]) << 8;
        const unsigned descends = greater(here[0], next[0]) | greater(here[1], next[1]) << 8;
        if ((ascends | descends) != 0xFFFF || !heading.is_slanting()) {
            for (std::size_t i = e; i < e + step; ++i) {
                out[found] = static_cast<std::uint32_t>(i);
                found += heading.turns_at(points[i], points[i + 1]) ? 1 : 0;
            }
            continue;
        }
        const unsigned changes = (ascends ^ (ascends << 2 | heading.bits())) & 0xFFFF;
        for (unsigned turns = (changes | changes >> 1) & 0x5555; turns != 0; turns &= turns - 1) {
            out[found++] = static_cast<std::uint32_t>(e) + static_cast<std::uint32_t>(std::countr_zero(turns)) / 2;
        }
        heading.set(ascends >> 14);
    }
    for (; e < edges; ++e) {
        out[found] = static_cast<std::uint32_t>(e);
        found += heading.turns_at(points[e], points[e + 1]) ? 1 : 0;
    }
    return found;
}

LAMELLA_AVX2 BoxesMet find_meeting_avx2(const BoxArrays& boxes, std::size_t i, std::size_t end, std::int32_t from_x,
                                        std::uint32_t* out) {
    const __m256i low_x = _mm256_set1_epi32(boxes.low_x[i]);
    const __m256i high_x = _mm256_set1_epi32(boxes.high_x[i]);
    const __m256i high_y = _mm256_set1_epi32(boxes.high_y[i]);
    const __m256i from = _mm256_set1_epi32(boxes.low_x[i] < from_x ? from_x : std::numeric_limits<std::int32_t>::min());
    const __m256i run = _mm256_set1_epi32(static_cast<int>(boxes.run[i]));
    const __m256i one = _mm256_set1_epi32(1);
    constexpr unsigned all = 0xFF;
    std::size_t found = 0;
    for (std::size_t j = i + 1; j < end; j += run_lanes) {
        unsigned level = all & ~greater(lanes_at(boxes.low_y + j), high_y);
        level &= end - j < run_lanes ? (1U << (end - j)) - 1 : all;
        const __m256i other_low = lanes_at(boxes.low_x + j);
        const __m256i other_run = lanes_at(boxes.run + j);
        const __m256i next = _mm256_or_si256(_mm256_cmpeq_epi32(_mm256_add_epi32(other_run, one), run),
                                             _mm256_cmpeq_epi32(other_run, _mm256_add_epi32(run, one)));
        const __m256i beside =
            _mm256_or_si256(_mm256_cmpgt_epi32(other_low, high_x), _mm256_cmpgt_epi32(low_x, lanes_at(boxes.high_x + j)));
        const __m256i left_out = _mm256_or_si256(_mm256_or_si256(beside, next), _mm256_cmpgt_epi32(from, other_low));
        const auto apart = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(left_out)));
        for (unsigned meet = level & ~apart; meet != 0; meet &= meet - 1) {
            out[found++] = static_cast<std::uint32_t>(j + static_cast<std::size_t>(std::countr_zero(meet)));
        }
        if (level != all) {  // ordered: the lowest lanes, and none after these
            return {found, j - i - 1 + static_cast<std::size_t>(std::countr_one(level))};
        }
    }
    return {found, end - i - 1};
}

constexpr Form<RunKernels> forms_of_runs[] = {{InstructionSet::avx2, {find_turns_avx2, find_meeting_avx2}},
                                              {InstructionSet::portable, {find_turns_portable, find_meeting_portable}}};
#else
constexpr Form<RunKernels> forms_of_runs[] = {{InstructionSet::portable, {find_turns_portable, find_meeting_portable}}};
#endif

}  // namespace

std::span<const Form<RunKernels>> run_kernel_forms() noexcept {
    return forms_of_runs;
}

}  // namespace lamella
