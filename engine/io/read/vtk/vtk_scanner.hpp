// Goes through a legacy VTK file: words and lines, and arrays that are text or binary.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "io/read/vtk/vtk_file.hpp"

namespace lamella {

/// Messages of a text file name the line; in a binary one there are none to count.
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
    Status count(std::string_view what, std::uint64_t& value);
    /// The name of a type, or of a type of integers.
    Status type(NumberType& type, bool of_integers = false);

    /// The `count` numbers that follow. As text they are read as Value.
    template <class Value>
    Result<NumberArray> numbers(std::uint64_t count, NumberType type, std::string_view name) {
        return binary_ ? bytes(count, type, name)
                       : read_text_array<Value>(file_, p_, end_, count, name, storage_.emplace_back(file_.source.memory()));
    }
    Status skip_numbers(std::uint64_t count, NumberType type, std::string_view name);
    Status skip_bits(std::uint64_t count, std::string_view name);
    /// Skips strings; `last` becomes the last of them.
    Status strings(std::uint64_t count, std::string_view name, std::string_view& last);

    /// The memory of the numbers that were read last, if they were text.
    Array<std::byte>& last_storage() noexcept { return storage_.back(); }

    /// An error at the next word.
    Error error(const std::string& what);
    Error expected(const std::string& what);

private:
    Error error_at(const char* p, const std::string& what) const;
    Status begin_bytes(std::uint64_t count, std::size_t bytes_each, std::string_view name);
    Result<NumberArray> bytes(std::uint64_t count, NumberType type, std::string_view name);
    Error truncated_strings(std::string_view name) const;
    Status binary_string(std::string_view name, std::string_view& string);

    VtkFile& file_;
    const char* p_;
    const char* end_;
    bool binary_ = false;
    std::deque<Array<std::byte>> storage_;  ///< of what was text
};

}  // namespace lamella
