// Goes through a legacy VTK file: words and lines, and arrays that are text or binary.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "io/read/vtk/vtk_file.hpp"

namespace lamella {

/// Throws TextErrors. Messages of a text file name the line; in a binary one there are none to count.
class VtkScanner {
public:
    explicit VtkScanner(VtkFile& file)
        : file_(file), p_(without_byte_order_mark(file.text).data()), end_(file.text.data() + file.text.size()) {}

    /// What follows is binary, or else text.
    void set_binary(bool binary) noexcept { binary_ = binary; }
    bool binary() const noexcept { return binary_; }

    /// The rest of the line; moves to the next line.
    std::string_view line();
    /// The next word, which stays the next; empty at the end.
    std::string_view peek();
    std::string_view word();
    /// Skips the next word if it is `keyword`, which is upper case, in any case.
    bool accept(std::string_view keyword);
    /// An integer that is not negative; `what` names it in messages.
    std::uint64_t count(const std::string& what);
    /// The name of a type, or of a type of integers.
    NumberType type(bool of_integers = false);

    /// The `count` numbers that follow. As text they are read as `as`: see read_words().
    NumberArray numbers(std::uint64_t count, NumberType type, NumberType as, std::string_view name) {
        return binary_ ? bytes(count, type, name) : read_words(file_, p_, end_, count, as, name);
    }
    void skip_numbers(std::uint64_t count, NumberType type, std::string_view name);
    void skip_bits(std::uint64_t count, std::string_view name);
    /// Skips strings. Returns the last of them.
    std::string_view strings(std::uint64_t count, std::string_view name);

    /// Throws an error at the next word.
    [[noreturn]] void fail(const std::string& what);
    [[noreturn]] void expected(const std::string& what);

private:
    [[noreturn]] void fail_here(const std::string& what) const { throw TextError{p_, what, !binary_}; }
    NumberArray bytes(std::uint64_t count, NumberType type, std::string_view name);
    std::string_view binary_string(std::string_view name);
    void need(std::uint64_t bytes, std::string_view name) const;

    VtkFile& file_;
    const char* p_;
    const char* end_;
    bool binary_ = false;
};

}  // namespace lamella
