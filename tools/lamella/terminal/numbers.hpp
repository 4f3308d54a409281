// Numbers as people write them: on the command line, separated by commas, and in small text files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/planes.hpp"

namespace lamella::cli {

/// All of `text` as one finite number; a leading + is allowed.
std::optional<double> parse_number(std::string_view text) noexcept;

/// "1,2.5,3" (spaces around numbers allowed), or nothing if any part is not a number.
std::optional<std::vector<double>> parse_list(std::string_view text);

/// Exactly three numbers with commas between; throws Failure naming `option`.
std::vector<double> parse_triple(std::string_view text, const std::string& option);

/// mm in a "mm", "um", "cm", "m", "in" or "ft", or in so many mm as the number says; throws Failure naming `option`.
double parse_unit(const std::string& text, const std::string& option);

/// The grid's unit in mm: a number of them, unit_by_box for "auto", 0 for "". Throws Failure naming --grid.
double parse_grid(const std::string& text);

/// The length of --close-gaps in mm: a number of them, gaps_by_mesh for "auto". Throws Failure naming --close-gaps.
double parse_gaps(const std::string& text);

/// A number of bytes, at least 1: "1500000", "200K", "512M", "2GB", "1TiB", all of powers of 1024. Throws Failure naming
/// `option`.
std::uint64_t parse_bytes(const std::string& text, const std::string& option);

/// "A:B", "A:" or ":B": layers from A up to, but not with, B. Throws Failure naming `option`.
LayerRange parse_layers(const std::string& text, const std::string& option);

/// Throws Failure naming `option`.
void require_positive(const std::optional<double>& value_mm, const std::string& option);

struct NumberFile {
    std::vector<double> values;
    std::vector<std::size_t> lines;  ///< where each value stands, from 1
};

/// Numbers separated by white space, semicolons or commas; # begins a comment. In columns separated by semicolons or tabs
/// commas may be decimal ones. Throws Failure naming the file and the line.
NumberFile read_numbers(const std::string& path);

/// Whether all of `text` is digits with one comma between them, as 0,5.
bool is_decimal_comma(std::string_view text) noexcept;
/// Its comma as a point.
std::string with_point(std::string_view text);

}  // namespace lamella::cli
