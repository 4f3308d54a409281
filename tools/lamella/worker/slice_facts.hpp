// What slice passes on to the batch that it works for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lamella::cli {

/// What slice says of a mesh that it has cut.
struct SliceFacts {
    std::uint64_t triangles = 0;
    std::uint64_t layers = 0;
    std::uint64_t contours = 0;
    std::uint64_t open_contours = 0;
    double close_gaps_mm = 0;  ///< as SliceResult::close_gaps_mm
    std::vector<std::string> warnings;

    bool operator==(const SliceFacts&) const = default;
};

/// As one line of text, and back.
std::string text_of(const SliceFacts& facts);
std::optional<SliceFacts> parse_facts(std::string_view text);

}  // namespace lamella::cli
