// Deflated data of long runs: a picture of a layer is some thousand runs of 59 million pixels, and zlib would look at each.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <utility>

namespace lamella {

/// A zlib stream (RFC 1950, 1951) of one block with the same codes for all data: a run is a byte and matches at distance 1,
/// of which one of 258 bytes takes two bits. Time and memory: O(runs + bytes / 1000).
class RunDeflater {
public:
    RunDeflater() {
        put(0x0178, 16);
        put(0b101, 3);  // the last block, with codes of its own
        put((codes.size() - 257) | 0 << 5 | (18 - 4) << 10, 14);
        for (const int length : {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1}) {
            put(length == 1 || length == 4 || length == 9 || length == 10 ? 2 : 0, 3);  // bits of a code that tells it
        }
        for (const Code& code : codes) {
            put(code.length == 1 ? 0b00 : code.length == 4 ? 0b10 : code.length == 9 ? 0b01 : 0b11, 2);
        }
        put(0b00, 2);  // the one distance
    }

    /// So many of the byte.
    void run(std::uint64_t count, std::uint8_t byte) {
        if (byte != byte_) {
            flush();
            byte_ = byte;
        }
        count_ += count;
    }

    /// The whole stream.
    std::string finish() {
        flush();
        put(codes[256]);
        put(0, 7);  // to the end of a byte
        for (const std::uint64_t sum : {sum_of_sums_, sum_}) {
            text_ += static_cast<char>(sum >> 8);
            text_ += static_cast<char>(sum & 255);
        }
        return std::move(text_);
    }

private:
    struct Code {
        std::uint32_t bits;  ///< the highest of the code is the lowest here
        int length;
    };

    /// Of bytes, the end (256) and lengths (257 to 285), complete: 1 bit for the longest match, 4 for black and white, 9 for
    /// other matches, the end and 72 bytes, 10 for the rest.
    static constexpr std::array<Code, 286> codes = [] {
        std::array<Code, 286> all{};
        std::uint32_t next = 0;
        for (int length = 1; length <= 10; ++length, next <<= 1) {
            for (std::size_t i = 0; i < all.size(); ++i) {
                if (length == (i == 285 ? 1 : i == 0 || i == 255 ? 4 : i >= 256 || i <= 72 ? 9 : 10)) {
                    all[i].length = length;
                    for (int bit = 0; bit < length; ++bit) {
                        all[i].bits |= (next >> bit & 1) << (length - 1 - bit);
                    }
                    ++next;
                }
            }
        }
        return all;
    }();

    void put(std::uint64_t bits, int count) {
        held_ |= bits << held_bits_;
        for (held_bits_ += count; held_bits_ >= 8; held_bits_ -= 8, held_ >>= 8) {
            text_ += static_cast<char>(held_ & 255);
        }
    }
    void put(Code code) { put(code.bits, code.length); }

    void flush() {
        constexpr std::uint64_t modulus = 65521;  // of Adler-32
        constexpr std::uint64_t longest = 258;
        if (count_ == 0) {
            return;
        }
        const std::uint64_t n = count_ % (2 * modulus);
        sum_of_sums_ = (sum_of_sums_ + n * sum_ + n * (n + 1) / 2 % modulus * byte_) % modulus;
        sum_ = (sum_ + n * byte_) % modulus;
        put(codes[byte_]);
        std::uint64_t left = std::exchange(count_, 0) - 1;
        for (; left >= 16 * longest; left -= 16 * longest) {
            put(0, 32);  // 16 times the longest match and the distance, a bit each
        }
        for (; left >= longest; left -= longest) {
            put(0, 2);
        }
        if (left >= 3) {  // four symbols for each number of further bits
            const std::uint64_t beyond = left - 3;
            const int extra = std::max(0, static_cast<int>(std::bit_width(beyond)) - 3);
            put(codes[257 + 4 * static_cast<std::size_t>(extra) + (beyond >> extra)]);
            put(beyond & ((1U << extra) - 1), extra + 1);
            left = 0;
        }
        for (; left > 0; --left) {
            put(codes[byte_]);
        }
    }

    std::string text_;
    std::uint64_t held_ = 0;  ///< bits that are no byte yet
    int held_bits_ = 0;
    std::uint64_t sum_ = 1;  ///< Adler-32
    std::uint64_t sum_of_sums_ = 0;
    std::uint64_t count_ = 0;
    std::uint8_t byte_ = 0;
};

}  // namespace lamella
