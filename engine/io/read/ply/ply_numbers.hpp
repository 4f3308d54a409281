// The numbers of a PLY file's body, one after another: the same interface over bytes and over text.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "io/read/ply/ply_header.hpp"
#include "io/text/text.hpp"

namespace lamella {

/// Calls `f` with a value of the type, whose number does not matter.
template <class F>
decltype(auto) with_type(PlyType type, F&& f) {
    switch (type) {
        case PlyType::int8:
            return f(std::int8_t{});
        case PlyType::uint8:
            return f(std::uint8_t{});
        case PlyType::int16:
            return f(std::int16_t{});
        case PlyType::uint16:
            return f(std::uint16_t{});
        case PlyType::int32:
            return f(std::int32_t{});
        case PlyType::uint32:
            return f(std::uint32_t{});
        case PlyType::float32:
            return f(float{});
        case PlyType::float64:
            break;
    }
    return f(double{});
}

/// The number at `p`, whose bytes are reversed if `swapped`.
template <class T>
T load_number(const char* p, bool swapped) {
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), p, sizeof(T));
    if (swapped) {
        std::reverse(bytes.begin(), bytes.end());
    }
    return std::bit_cast<T>(bytes);
}

/// Whether `value` is a whole number, all of which up to 2^53 are exact.
inline bool to_integer(double value, std::int64_t& integer) {
    constexpr double exact = 9007199254740992.0;
    if (!(std::abs(value) <= exact) || std::trunc(value) != value) {
        return false;
    }
    integer = static_cast<std::int64_t>(value);
    return true;
}

/// Each call reads the next number and moves past it. False: it has not moved, and found() describes what is there.
class BinaryNumbers {
public:
    BinaryNumbers(const char* begin, const char* end, bool swapped) : p_(begin), end_(end), swapped_(swapped) {}

    const char* at() const { return p_; }
    /// To where the next number begins.
    void go_to_next() {}
    /// An upper bound of how many numbers are left.
    std::uint64_t most_left(PlyType type) const { return static_cast<std::uint64_t>(end_ - p_) / size_of(type); }

    bool integer(PlyType type, std::int64_t& value) {
        if (most_left(type) == 0) {
            return false;
        }
        const bool whole = with_type(type, [&](auto sample) {
            const auto number = load_number<decltype(sample)>(p_, swapped_);
            if constexpr (std::is_floating_point_v<decltype(sample)>) {
                return to_integer(number, value);
            } else {
                value = number;  // NOLINT(bugprone-signed-char-misuse): a number, not a character
                return true;
            }
        });
        p_ += whole ? size_of(type) : 0;
        return whole;
    }

    template <class Value>
    bool number(PlyType type, Value& value) {
        if (most_left(type) == 0) {
            return false;
        }
        value =
            with_type(type, [&](auto sample) { return static_cast<Value>(load_number<decltype(sample)>(p_, swapped_)); });
        p_ += size_of(type);
        return true;
    }

    bool skip(PlyType type, std::uint64_t count) {
        const bool enough = count <= most_left(type);
        p_ = enough ? p_ + count * size_of(type) : p_;
        return enough;
    }

    std::string found(PlyType type) const {
        if (most_left(type) == 0) {
            return "the end of the file";
        }
        const auto value =
            with_type(type, [&](auto sample) { return static_cast<double>(load_number<decltype(sample)>(p_, swapped_)); });
        std::array<char, 32> digits;  // the shortest that mean the number take at most 24
        return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
    }

private:
    const char* p_;
    const char* end_;
    bool swapped_;
};

/// The same over words.
class AsciiNumbers {
public:
    AsciiNumbers(const char* begin, const char* end) : p_(begin), end_(end) {}

    const char* at() const { return p_; }
    void go_to_next() { p_ = skip_space(p_, end_); }
    std::uint64_t most_left(PlyType) const { return (static_cast<std::uint64_t>(end_ - p_) + 1) / 2; }

    /// Skips white space. Whether no word is left.
    bool at_end() {
        go_to_next();
        return p_ == end_;
    }

    bool integer(PlyType, std::int64_t& value) {
        if (at_end()) {
            return false;
        }
        constexpr std::ptrdiff_t most_digits = 18;
        const bool negative = *p_ == '-';
        const char* const digits = p_ + (negative ? 1 : 0);
        std::uint64_t magnitude = 0;
        const char* const p = read_digits(digits, end_, magnitude);
        if (p == digits || p - digits > most_digits || (p != end_ && !is_space(*p))) {
            return unusual_integer(value);
        }
        value = negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
        p_ = p;
        return true;
    }

    template <class Value>
    bool number(PlyType, Value& value) {
        return !at_end() && read_number(p_, end_, value) == NumberText::read;
    }

    bool skip(PlyType type, std::uint64_t count) {
        bool enough = count <= most_left(type);
        go_to_next();
        const char* const before = p_;
        for (; enough && count > 0; --count) {
            enough = !at_end();
            p_ = skip_word(p_, end_);
        }
        p_ = enough ? p_ : before;
        return enough;
    }

    std::string found(PlyType) const { return word_at(skip_space(p_, end_), end_); }

private:
    /// "+3", "3.0", "3e0": what is declared a float may be a count or an index too.
    bool unusual_integer(std::int64_t& value) {
        const char* p = p_;
        double number = 0;
        const bool whole = read_number(p, end_, number) == NumberText::read && to_integer(number, value);
        p_ = whole ? p : p_;
        return whole;
    }

    const char* p_;
    const char* end_;
};

}  // namespace lamella
