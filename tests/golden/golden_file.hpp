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

#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace golden {

/// FNV-1a over 8-byte words. Not the engine's own hash, so that a bug in that one is seen too.
class Hash {
public:
    Hash& word(std::uint64_t word) noexcept {
        for (int shift = 0; shift < 64; shift += 8) {
            value_ = (value_ ^ (word >> shift & 0xFF)) * 0x100000001B3;
        }
        return *this;
    }
    Hash& integer(std::int64_t number) noexcept { return word(static_cast<std::uint64_t>(number)); }
    /// By its bits.
    Hash& real(double number) noexcept {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &number, sizeof bits);
        return word(bits);
    }
    Hash& reals(std::span<const double> numbers) noexcept {
        for (const double number : numbers) {
            real(number);
        }
        return *this;
    }
    Hash& text(std::string_view bytes) noexcept {
        word(bytes.size());
        for (const char byte : bytes) {
            value_ = (value_ ^ static_cast<unsigned char>(byte)) * 0x100000001B3;
        }
        return *this;
    }
    std::uint64_t value() const noexcept { return value_; }

private:
    std::uint64_t value_ = 0xCBF29CE484222325;
};

inline std::uint64_t hash_of(std::span<const double> numbers) {
    return Hash().reals(numbers).value();
}
inline std::uint64_t hash_of(std::string_view bytes) {
    return Hash().text(bytes).value();
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
