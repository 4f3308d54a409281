// Numbers and small text files as people write them: on the command line, in manifests, heights, matrices.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace lamella::cli {

/// All of `text` as one finite number; a leading + is allowed.
std::optional<double> parse_number(std::string_view text) noexcept;

/// True if all of `text` is one integer, which `value` is then.
template <class Integer>
bool parse_integer(std::string_view text, Integer& value) {
    const char* const end = text.data() + text.size();
    const auto [stop, problem] = std::from_chars(text.data(), end, value);
    return problem == std::errc() && stop == end;
}

/// "1,2.5,3" (spaces around numbers allowed), or nothing if any part is not a number.
std::optional<std::vector<double>> parse_list(std::string_view text);

/// Exactly three numbers with commas between; throws Failure naming `option`.
std::vector<double> parse_triple(std::string_view text, const std::string& option);

/// mm in a "mm", "um", "cm", "m", "in" or "ft", or in so many mm as the number says; nothing where it is none of these.
std::optional<double> parse_unit(std::string_view text) noexcept;

/// A number of bytes, at least 1: "1500000", "200K", "512M", "2GB", "1TiB", all of powers of 1024. Throws Failure naming
/// `option`.
std::uint64_t parse_bytes(const std::string& text, const std::string& option);

/// "A:B", "A:" or ":B": layers from A up to, but not with, B. False where it is none of these; what is not given stays.
bool parse_layers(std::string_view text, std::uint64_t& first, std::uint64_t& end);

/// All of the file. Throws Failure (bad_input) of one that cannot be read, or is larger than `most_bytes`.
std::string read_bytes(const std::string& path, std::size_t most_bytes = std::numeric_limits<std::size_t>::max());

/// All of a file that people write, but for a byte-order mark. Throws Failure (bad_input) also of one larger than 1 GiB, and
/// of UTF-16.
std::string read_text(const std::string& path);

/// The pieces between separators, of which one more than of these: text that ends with one has an empty last piece.
std::vector<std::string_view> split(std::string_view text, char separator);

struct NumberFile {
    std::vector<double> values;
    std::vector<std::size_t> lines;  ///< where each value stands, from 1
};

/// Numbers separated by white space, semicolons or commas; # begins a comment. In columns separated by semicolons or tabs
/// commas may be decimal ones. Throws Failure naming the file and the line.
NumberFile read_numbers(const std::string& path);

/// True if all of `text` is digits with one comma between them, as 0,5.
bool is_decimal_comma(std::string_view text) noexcept;
/// Its comma as a point.
std::string with_point(std::string_view text);

}  // namespace lamella::cli
