#include "io/read/vtk/base64.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "io/text/text.hpp"

namespace lamella {

namespace {

constexpr std::uint32_t no_letter = 0xFF;

constexpr std::array<std::uint8_t, 256> values = [] {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::uint8_t, 256> table{};
    table.fill(no_letter);
    for (std::size_t i = 0; i < alphabet.size(); ++i) {
        table[static_cast<unsigned char>(alphabet[i])] = static_cast<std::uint8_t>(i);
    }
    return table;
}();

std::uint32_t value_of(char letter) {
    return values[static_cast<unsigned char>(letter)];
}

/// Six bits each of four letters, the first being the highest; 2^24 and more if one is no base64.
std::uint32_t bits_of(const char* letters) {
    const std::uint32_t a = value_of(letters[0]);
    const std::uint32_t b = value_of(letters[1]);
    const std::uint32_t c = value_of(letters[2]);
    const std::uint32_t d = value_of(letters[3]);
    const std::uint32_t invalid = (a | b | c | d) & 0x80;
    return invalid << 24 | a << 18 | b << 12 | c << 6 | d;
}

void put(std::uint32_t bits, std::byte* out) {
    out[0] = static_cast<std::byte>(bits >> 16);
    out[1] = static_cast<std::byte>(bits >> 8);
    out[2] = static_cast<std::byte>(bits);
}

}  // namespace

bool Base64Reader::read(std::span<std::byte> out) noexcept {
    while (!out.empty()) {
        if (read_begin_ == read_end_) {
            while (out.size() >= 3 && end_ - p_ >= 4) {
                const std::uint32_t bits = bits_of(p_);
                if (bits >> 24 != 0) {
                    break;
                }
                put(bits, out.data());
                out = out.subspan(3);
                p_ += 4;
            }
            if (out.empty()) {
                return true;
            }
            if (!read_quad()) {
                return false;
            }
        }
        const std::size_t count = std::min(out.size(), read_end_ - read_begin_);
        std::memcpy(out.data(), read_.data() + read_begin_, count);
        read_begin_ += count;
        out = out.subspan(count);
    }
    return true;
}

/// Four letters with white space between them, of which the last one or two may be padding.
bool Base64Reader::read_quad() noexcept {
    std::array<char, 4> letters{};
    std::size_t padding = 0;
    for (std::size_t i = 0; i < letters.size(); ++i, ++p_) {
        p_ = skip_space(p_, end_);
        if (p_ == end_) {
            return false;
        }
        const bool pads = *p_ == '=' && i >= 2;
        padding += pads ? 1 : 0;
        if (!pads && (value_of(*p_) == no_letter || padding > 0)) {
            return false;
        }
        letters[i] = pads ? 'A' : *p_;
    }
    put(bits_of(letters.data()), read_.data());
    read_begin_ = 0;
    read_end_ = 3 - padding;
    return true;
}

}  // namespace lamella
