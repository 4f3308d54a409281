// The rows of one element of a PLY file, read from numbers that are bytes or text.
#pragma once

#include <limits>

#include "base/words.hpp"
#include "io/read/ply/ply.hpp"

namespace lamella {

/// True if `value` is a whole number, all of which up to 2^53 are exact.
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
    static constexpr bool binary = true;

    BinaryNumbers(const char* begin, const char* end, bool swapped) : p_(begin), end_(end), swapped_(swapped) {}

    const char* at() const { return p_; }
    const char* end() const { return end_; }
    void go_to(const char* at) { p_ = at; }
    /// To where the next number begins.
    void go_to_next() {}
    static void begin_row(const char* /*block_end*/) {}
    static bool end_row() { return true; }
    /// An upper bound of how many numbers are left.
    std::uint64_t most_left(NumberType type) const {
        return static_cast<std::uint64_t>(end_ - p_) >> std::countr_zero(size_of(type));  // a division takes longer
    }

    bool integer(NumberType type, std::int64_t& value) {
        if (type == NumberType::uint8 && p_ != end_) {  // nearly all lengths of lists
            value = static_cast<unsigned char>(*p_++);
            return true;
        }
        if ((type == NumberType::int32 || type == NumberType::uint32) && end_ - p_ >= 4) {  // nearly all indices
            const auto bits = load_number<std::uint32_t>(p_, swapped_);
            value = type == NumberType::int32 ? static_cast<std::int32_t>(bits) : std::int64_t{bits};
            p_ += 4;
            return true;
        }
        const bool whole = most_left(type) > 0 && to_integer(next(type), value);
        p_ += whole ? size_of(type) : 0;
        return whole;
    }

    template <class Value>
    bool number(NumberType type, Value& value, bool /*takes_nan*/ = true) {
        const bool is_there = most_left(type) > 0;
        if (is_there) {
            value = static_cast<Value>(next(type));
            p_ += size_of(type);
        }
        return is_there;
    }

    bool skip(NumberType type, std::uint64_t count) {
        const bool enough = count <= most_left(type);
        p_ = enough ? p_ + count * size_of(type) : p_;
        return enough;
    }

    std::string found(NumberType type) const {
        if (most_left(type) == 0) {
            return "the end of the file";
        }
        return exact_text(next(type));
    }

private:
    /// Exact, as PLY has no integers of 64 bits.
    double next(NumberType type) const {
        return with_type(type,
                         [&](auto sample) { return static_cast<double>(load_number<decltype(sample)>(p_, swapped_)); });
    }

    const char* p_;
    const char* end_;
    bool swapped_;
};

/// The same over words.
class AsciiNumbers {
public:
    static constexpr bool binary = false;

    AsciiNumbers(const char* begin, const char* end) : p_(begin), end_(end) {}

    const char* at() const { return p_; }
    const char* end() const { return end_; }
    void go_to(const char* at) { p_ = at; }
    void go_to_next() { p_ = skip_space(p_, end_); }
    void begin_row(const char* /*block_end*/) { go_to_next(); }
    static bool end_row() { return true; }
    std::uint64_t most_left(NumberType) const { return (static_cast<std::uint64_t>(end_ - p_) + 1) / 2; }

    /// Skips white space. Whether no word is left.
    bool at_end() {
        go_to_next();
        return p_ == end_;
    }

    bool integer(NumberType, std::int64_t& value) {
        if (at_end()) {
            return false;
        }
        constexpr std::ptrdiff_t most_digits = 18;
        const bool negative = *p_ == '-';
        const char* const digits = p_ + (negative ? 1 : 0);
        std::uint64_t magnitude = 0;
        const char* p = read_digits(digits, end_, magnitude);
        bool whole = p != digits && p - digits <= most_digits && (p == end_ || is_space(*p));
        if (whole) {
            value = negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
        } else {  // "+3", "3.0", "3e0": what is declared a float may be a count or an index too
            double number = 0;
            p = p_;
            whole = read_number(p, end_, number) == NumberText::read && to_integer(number, value);
        }
        p_ = whole ? p : p_;
        return whole;
    }

    template <class Value>
    bool number(NumberType, Value& value, bool takes_nan = false) {
        const NumberText got = at_end() ? NumberText::malformed : read_number(p_, end_, value);
        const bool is_nan = takes_nan && got == NumberText::not_finite;
        p_ = is_nan ? skip_word(p_, end_) : p_;
        return is_nan || got == NumberText::read;
    }

    bool skip(NumberType type, std::uint64_t count) {
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

    std::string found(NumberType) const { return word_at(skip_space(p_, end_), end_); }

protected:
    const char* p_;
    const char* end_;
};

/// In a triangle strip: -1, after which the next strip begins.
inline constexpr std::uint32_t strip_end = std::numeric_limits<std::uint32_t>::max();

/// `Numbers` is BinaryNumbers or AsciiNumbers. Each call reads a row, or throws a TextError.
template <class Numbers>
class PlyRows {
public:
    PlyRows(Numbers numbers, const PlyElement& element, std::uint64_t first_row = 0)
        : numbers_(numbers), element_(element), row_(first_row) {}

    void skip() {
        for (const PlyProperty& property : element_.properties) {
            skip_property(property);
        }
        ++row_;
    }

    /// Writes the coordinates of the row's vertex to `out`, as numbers of the type, and its scalars to theirs.
    void vertex(Number type, std::byte* out, std::span<VertexScalars> scalars = {}) {
        type == Number::f64 ? vertex_as<double>(out, scalars) : vertex_as<float>(out, scalars);
    }

    /// The row's list of indices, each of one of `vertex_count` vertices or, in strips, strip_end.
    void indices(std::uint64_t vertex_count, std::vector<std::uint32_t>& list) {
        for (const PlyProperty& property : element_.properties) {
            property.use == PlyUse::indices ? index_list(property, vertex_count, list) : skip_property(property);
        }
        ++row_;
    }

    const Numbers& numbers() const { return numbers_; }

private:
    template <class Value>
    void vertex_as(std::byte* out, std::span<VertexScalars> scalars) {
        Value xyz[3];
        std::size_t next_scalar = 0;
        for (const PlyProperty& property : element_.properties) {
            const auto axis = static_cast<std::size_t>(property.use);
            if (property.use == PlyUse::scalar) {
                if (!numbers_.number(property.type, scalars[next_scalar++].values[row_], true)) {
                    fail(property, "expected a number, found " + numbers_.found(property.type));
                }
            } else if (axis >= 3) {
                skip_property(property);
            } else if (!numbers_.number(property.type, xyz[axis])) {
                fail(property, "expected a finite number, found " + numbers_.found(property.type));
            }
        }
        std::memcpy(out, xyz, sizeof xyz);
        ++row_;
    }

    void skip_property(const PlyProperty& property) {
        if (!numbers_.skip(property.type, property.is_list ? list_count(property) : 1)) {
            fail(property, "expected a number, found " + numbers_.found(property.type));
        }
    }

    std::uint64_t list_count(const PlyProperty& property) {
        numbers_.go_to_next();
        const char* const begin = numbers_.at();
        std::int64_t count = 0;
        if (!numbers_.integer(property.count_type, count)) {
            fail(property, "expected the length of a list, found " + numbers_.found(property.count_type));
        }
        if (count < 0 || static_cast<std::uint64_t>(count) > numbers_.most_left(property.type)) {
            numbers_.go_to(begin);
            fail(property, count < 0 ? "a list of " + std::to_string(count) + " numbers"
                                     : "the file ends within its list of " + std::to_string(count) + " numbers");
        }
        return static_cast<std::uint64_t>(count);
    }

    void index_list(const PlyProperty& property, std::uint64_t vertex_count, std::vector<std::uint32_t>& list) {
        list.resize(list_count(property));
        for (std::uint32_t& index : list) {
            numbers_.go_to_next();
            const char* const begin = numbers_.at();
            std::int64_t number = 0;
            if (!numbers_.integer(property.type, number)) {
                fail(property, "expected an index, found " + numbers_.found(property.type));
            }
            const bool ends_strip = number == -1 && element_.role == PlyRole::strips;
            if (static_cast<std::uint64_t>(number) >= vertex_count && !ends_strip) {
                numbers_.go_to(begin);
                fail(property,
                     "index " + std::to_string(number) + ", but there are " + std::to_string(vertex_count) + " vertices");
            }
            index = static_cast<std::uint32_t>(number);
        }
    }

    [[noreturn]] void fail(const PlyProperty& property, const std::string& what) const {
        throw TextError{numbers_.at(),
                        "property " + in_quotes(property.name) + " of " + in_quotes(element_.name) + " " +
                            std::to_string(row_) + ": " + what,
                        !Numbers::binary};
    }

    Numbers numbers_;
    const PlyElement& element_;
    std::uint64_t row_;
};

}  // namespace lamella
