// Goes through a legacy VTK file: words and lines, and arrays that are text or binary.
#pragma once

#include "io/read/vtk/vtk_file.hpp"

namespace lamella {

/// Throws TextErrors. Messages of a text file name the line; in a binary one there are none to count.
class VtkScanner {
public:
    explicit VtkScanner(VtkFile& file)
        : file_(file), p_(without_byte_order_mark(file.text).data()), end_(file.text.data() + file.text.size()) {}

    /// From here on all is binary, or else text.
    void set_binary(bool binary) noexcept { binary_ = binary; }
    bool binary() const noexcept { return binary_; }

    /// The rest of the line; moves to the next line.
    std::string_view line() {
        const char* const begin = p_;
        p_ = skip_line(p_, end_);
        const std::string_view line(begin, static_cast<std::size_t>(p_ - begin));
        const std::string_view rest(p_, static_cast<std::size_t>(end_ - p_));
        p_ += rest.starts_with("\r\n") ? 2 : (rest.empty() ? 0 : 1);
        return line;
    }

    /// The next word, which stays the next; empty at the end.
    std::string_view peek() {
        p_ = skip_space(p_, end_);
        return {p_, static_cast<std::size_t>(skip_word(p_, end_) - p_)};
    }

    std::string_view word() {
        const std::string_view word = peek();
        p_ += word.size();
        return word;
    }

    /// Skips the next word if it is `keyword`, which is upper case, in any case.
    bool accept(std::string_view keyword) {
        const std::string_view word = peek();
        if (!is_keyword(word, keyword)) {
            return false;
        }
        p_ += word.size();
        return true;
    }

    /// An integer that is not negative; `what` names it in messages.
    std::uint64_t count(const std::string& what) {
        const std::string_view digits = peek();
        std::uint64_t value = 0;
        if (!read_integer(digits, value)) {
            expected("the number of " + what);
        }
        p_ += digits.size();
        return value;
    }

    /// The name of a type, or of a type of integers.
    NumberType type(bool of_integers = false) {
        const std::string_view name = peek();
        const auto* const found = std::find_if(type_names.begin(), type_names.end(),
                                               [name](const TypeName& known) { return is_keyword(name, known.name); });
        if (found == type_names.end() || (of_integers && !is_integer(found->type))) {
            expected(of_integers ? "a type of integers" : "a type of numbers");
        }
        p_ += name.size();
        return found->type;
    }

    /// The `count` numbers that follow. As text they are read as `as`: see read_words().
    NumberArray numbers(std::uint64_t count, NumberType type, NumberType as, std::string_view name) {
        return binary_ ? bytes(count, type, name) : read_words(file_, p_, end_, count, as, name);
    }
    void skip_numbers(std::uint64_t count, NumberType type, std::string_view name) {
        if (binary_) {
            bytes(count, type, name);
        } else {
            skip_words(file_, p_, end_, count, name);
        }
    }

    /// Eight to a byte, or as words.
    void skip_bits(std::uint64_t count, std::string_view name) {
        skip_numbers(binary_ ? count / 8 + (count % 8 != 0 ? 1 : 0) : count, NumberType::uint8, name);
    }

    /// Skips strings, as text each on a line of its own, as bytes each after its length. Returns the last of them.
    std::string_view strings(std::uint64_t count, std::string_view name) {
        std::string_view last;
        line();
        Lookout lookout(file_.source.parallel());
        for (; count > 0; --count) {
            lookout.pass();
            need(1, name);
            last = binary_ ? binary_string(name) : line();
        }
        return last;
    }

    /// Throws an error at the next word.
    [[noreturn]] void fail(const std::string& what) {
        peek();
        fail_here(what);
    }

    [[noreturn]] void expected(const std::string& what) {
        peek();
        fail_here("expected " + what + ", found " + word_at(p_, end_));
    }

private:
    struct TypeName {
        std::string_view name;
        NumberType type;
    };
    /// Sizes are those of 64-bit Unix where they depend on the machine; a vtkIdType has 32 bits in these files, whatever it
    /// had in memory.
    static constexpr std::array type_names = {TypeName{"FLOAT", NumberType::float32},
                                              TypeName{"DOUBLE", NumberType::float64},
                                              TypeName{"CHAR", NumberType::int8},
                                              TypeName{"SIGNED_CHAR", NumberType::int8},
                                              TypeName{"UNSIGNED_CHAR", NumberType::uint8},
                                              TypeName{"SHORT", NumberType::int16},
                                              TypeName{"UNSIGNED_SHORT", NumberType::uint16},
                                              TypeName{"INT", NumberType::int32},
                                              TypeName{"UNSIGNED_INT", NumberType::uint32},
                                              TypeName{"LONG", NumberType::int64},
                                              TypeName{"UNSIGNED_LONG", NumberType::uint64},
                                              TypeName{"VTKIDTYPE", NumberType::int32},
                                              TypeName{"VTKTYPEINT8", NumberType::int8},
                                              TypeName{"VTKTYPEUINT8", NumberType::uint8},
                                              TypeName{"VTKTYPEINT16", NumberType::int16},
                                              TypeName{"VTKTYPEUINT16", NumberType::uint16},
                                              TypeName{"VTKTYPEINT32", NumberType::int32},
                                              TypeName{"VTKTYPEUINT32", NumberType::uint32},
                                              TypeName{"VTKTYPEINT64", NumberType::int64},
                                              TypeName{"VTKTYPEUINT64", NumberType::uint64}};

    /// True if `word` is `keyword`, in any case.
    static bool is_keyword(std::string_view word, std::string_view keyword) {
        return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                          [](char a, char b) { return lower_case(a) == lower_case(b); });
    }

    [[noreturn]] void fail_here(const std::string& what) const { throw TextError{p_, what, !binary_}; }
    /// Those that follow the end of the line.
    NumberArray bytes(std::uint64_t count, NumberType type, std::string_view name) {
        while (p_ != end_ && *p_ != '\n' && is_space(*p_)) {
            ++p_;
        }
        if (p_ == end_ || *p_ != '\n') {
            expected("the end of the line before the bytes of " + std::string(name));
        }
        ++p_;
        const auto left = static_cast<std::uint64_t>(end_ - p_);
        if (count > left / size_of(type)) {
            fail_here("is truncated: expected " + std::to_string(count) + " numbers of " + std::string(name) + " at " +
                      std::to_string(size_of(type)) + " bytes, found " + std::to_string(left) + " bytes");
        }
        const char* const first = p_;
        p_ += count * size_of(type);
        return {reinterpret_cast<const std::byte*>(first), count, type, true, NumberArray::Form::bytes, first};
    }

    /// The first two bits tell how many bytes the length has, of which they are part: 8, 4, 2 or 1.
    std::string_view binary_string(std::string_view name) {
        const std::uint64_t length_bytes = std::uint64_t{8} >> (static_cast<unsigned char>(*p_) >> 6);
        need(length_bytes, name);
        std::uint64_t length = static_cast<unsigned char>(*p_++) & 0x3F;
        for (std::uint64_t i = 1; i < length_bytes; ++i) {
            length = length << 8 | static_cast<unsigned char>(*p_++);
        }
        need(length, name);
        const std::string_view string(p_, length);
        p_ += length;
        return string;
    }

    /// So many bytes of strings must be left.
    void need(std::uint64_t bytes, std::string_view name) const {
        if (static_cast<std::uint64_t>(end_ - p_) < bytes) {
            fail_here("is truncated within the strings of " + std::string(name));
        }
    }

    VtkFile& file_;
    const char* p_;
    const char* end_;
    bool binary_ = false;
};

}  // namespace lamella
