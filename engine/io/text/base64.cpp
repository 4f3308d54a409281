#include "io/text/base64.hpp"

#include <algorithm>
#include <array>
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

/// Writes the three bytes that four letters are. False: one is no base64.
bool decode_four(const char* letters, std::byte* out) {
    const std::uint32_t a = value_of(letters[0]);
    const std::uint32_t b = value_of(letters[1]);
    const std::uint32_t c = value_of(letters[2]);
    const std::uint32_t d = value_of(letters[3]);
    out[0] = static_cast<std::byte>(a << 2 | b >> 4);
    out[1] = static_cast<std::byte>(b << 4 | c >> 2);
    out[2] = static_cast<std::byte>(c << 6 | d);
    return ((a | b | c | d) & 0x80) == 0;
}

/// Decodes four letters with white space between them, of which the last one or two may be padding, and moves `p` past them.
/// Returns how many bytes of `out` they are; 0: they are no base64.
std::size_t decode_quad(const char*& p, const char* end, std::byte* out) {
    std::array<char, 4> letters{};
    std::size_t padding = 0;
    for (std::size_t i = 0; i < letters.size(); ++i, ++p) {
        p = skip_space(p, end);
        const bool pads = p != end && *p == '=' && i >= 2;
        padding += pads ? 1 : 0;
        if (p == end || (!pads && padding > 0)) {
            return 0;
        }
        letters[i] = pads ? 'A' : *p;
    }
    return decode_four(letters.data(), out) ? 3 - padding : 0;
}

}  // namespace

bool decode_base64(std::string_view text, std::span<std::byte> out, const Parallel& parallel) {
    const char* p = text.data();
    const char* const end = p + text.size();
    while (!out.empty()) {
        parallel.stop_if_asked();
        std::size_t quads = std::min({out.size() / 3, static_cast<std::size_t>(end - p) / 4, std::size_t{1} << 18});
        for (; quads > 0 && decode_four(p, out.data()); --quads, p += 4) {
            out = out.subspan(3);
        }
        std::array<std::byte, 3> three{};
        const std::size_t count = out.empty() ? 0 : std::min(out.size(), decode_quad(p, end, three.data()));
        if (count == 0) {
            return out.empty();
        }
        std::memcpy(out.data(), three.data(), count);
        out = out.subspan(count);
    }
    return true;
}

std::uint64_t base64_bytes(std::string_view text, const Parallel& parallel) {
    constexpr std::size_t step = std::size_t{1} << 20;
    std::uint64_t letters = 0;
    for (; !text.empty(); text.remove_prefix(std::min(step, text.size()))) {
        parallel.stop_if_asked();
        const std::string_view piece = text.substr(0, step);
        letters += static_cast<std::uint64_t>(
            std::count_if(piece.begin(), piece.end(), [](char c) { return !is_space(c) && c != '='; }));
    }
    return letters / 4 * 3 + letters % 4 * 3 / 4;
}

}  // namespace lamella
