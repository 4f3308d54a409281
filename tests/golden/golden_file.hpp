// The committed hashes, hashes.txt: one line "HASH NAME" each. Names of a group begin with "GROUP: ".
//
// A test case owns one group: it computes all hashes, and check_golden() compares them with the group's lines. With
// LAMELLA_UPDATE_GOLDEN set in the environment the lines are rewritten instead:
//
//     LAMELLA_UPDATE_GOLDEN=1 build/tests/lamella_tests "[golden]"      (one process: every group rewrites the file)
//
// Inputs have hashes of their own. A case first asks for same_input(): where a compiler or a C library makes another mesh,
// the failure says "the input differs", and no result is compared.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "lamella/grid.hpp"

namespace golden {

/// FNV-1a over 8-byte words, and the bytes of text. Not the engine's own hash, so that a bug in that one is seen too.
class Hash {
public:
    /// Integers, doubles by their bits, points, ranges of such, and text.
    template <class... Values>
    Hash& add(const Values&... values) noexcept {
        (one(values), ...);
        return *this;
    }
    std::uint64_t value() const noexcept { return value_; }

private:
    template <class Value>
    void one(const Value& value) noexcept {
        if constexpr (std::is_integral_v<Value>) {
            for (int shift = 0; shift < 64; shift += 8) {
                byte(static_cast<std::uint64_t>(value) >> shift & 0xFF);
            }
        } else if constexpr (std::is_floating_point_v<Value>) {
            one(std::bit_cast<std::uint64_t>(value));
        } else if constexpr (std::is_convertible_v<Value, std::string_view>) {
            const std::string_view text = value;
            one(text.size());
            std::for_each(text.begin(), text.end(), [&](char c) { byte(static_cast<unsigned char>(c)); });
        } else if constexpr (std::is_same_v<Value, lamella::Point>) {
            add(value.x, value.y);
        } else {
            std::for_each(value.begin(), value.end(), [&](const auto& item) { one(item); });
        }
    }
    void byte(std::uint64_t byte) noexcept { value_ = (value_ ^ byte) * 0x100000001B3; }

    std::uint64_t value_ = 0xCBF29CE484222325;
};

inline std::uint64_t hash_of(std::span<const double> numbers) {
    return Hash().add(numbers).value();
}
inline std::uint64_t hash_of(std::string_view bytes) {
    return Hash().add(bytes).value();
}

/// By name within the group.
using Hashes = std::map<std::string, std::uint64_t>;

/// Names are distinct.
void add(Hashes& hashes, const std::string& name, std::uint64_t hash);

/// These must be the lines whose names begin with "`group`: ", or those without any such beginning if it is empty.
void check_golden(const std::string& group, const Hashes& produced);

/// Fails with "the input differs" unless the line "input: NAME" has this hash, or the file is being updated.
bool same_input(const std::string& name, std::uint64_t hash);

}  // namespace golden
