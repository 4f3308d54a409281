// Words, lines and numbers by the eight characters: the same as one by one, wherever the text ends.
#include <catch2/catch.hpp>

#include <charconv>
#include <string>

#include "io/text/text.hpp"

namespace lamella {
namespace {

TEST_CASE("digits are read up to the first other character, however many there are", "[input][text]") {
    const std::string digits = "9081726354091827364509182736";
    for (std::size_t count = 0; count <= digits.size(); ++count) {
        for (int next = 0; next < 256; ++next) {
            std::string text = digits.substr(0, count);
            const bool ends = is_digit(static_cast<char>(next));
            text += ends ? std::string() : static_cast<char>(next) + std::string("12345678");
            std::uint64_t number = 1;
            const char* const end = text.data() + text.size();
            CHECK(read_digits(text.data(), end, number) == text.data() + count);
            std::uint64_t exact = 0;
            std::from_chars(text.data(), text.data() + std::min<std::size_t>(count, 18), exact);
            CHECK((count <= 18 ? number == exact : number >= 1'000'000'000'000'000'000));
        }
    }
}

TEST_CASE("lines end at the first LF or CR", "[input][text]") {
    const std::string other = "\x0B\x0C \x8A\x8D\x09\x0E\xFF";  // one bit from a line end, or around it
    for (std::size_t length = 0; length < 40; ++length) {
        for (const std::string& end : {std::string("\n"), std::string("\r"), std::string("\r\n"), std::string()}) {
            for (const std::size_t behind : {0U, 1U, 20U}) {
                std::string line;
                for (std::size_t i = 0; i < length; ++i) {
                    line += other[i % other.size()];
                }
                const std::string text = line + end + (end.empty() ? "" : std::string(behind, '\n'));
                CHECK(skip_line(text.data(), text.data() + text.size()) == text.data() + length);
            }
        }
    }
}

}  // namespace
}  // namespace lamella
